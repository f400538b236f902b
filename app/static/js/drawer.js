// The drawer of all parameters: shows those that apply to the surface and the path on screen, finds, and restores.

import { by, on } from "./dom.js"
import { declared, me, view } from "./store.js"

let connected = false

export function openDrawer() {
  if (!connected) connect()
  if (by("drawer").open) by("drawer").close()
  else by("drawer").show()
  // where it is in sight
  if (by("drawer").open && matchMedia("(max-width: 599px)").matches) document.querySelector(".desk").scrollIntoView()
  refresh()
}

function connect() {
  connected = true
  view(["status"], refresh)
  on("find", "input", refresh)
  on("drawer", "close", () => by(by("parameters").checkVisibility() ? "parameters" : "menu").focus())
  for (const button of document.querySelectorAll("[data-slider]"))
    button.addEventListener("click", () => by(`${button.dataset.slider}-entry`).focus())
  for (const button of document.querySelectorAll(".restore")) {
    button.addEventListener("click", () => {
      const entry = by(`${button.dataset.name}-entry`)
      entry.value = declared.usual[me.status.preset][button.dataset.name]
      entry.dispatchEvent(new Event("change"))
      entry.focus()
    })
  }
}

function refresh() {
  const { values, preset } = me.status, sought = by("find").value.trim().toLowerCase()
  if (!values || !by("drawer").open) return
  const applies = ({ dataset }) =>
    ["surface", "path"].every((which) => dataset[which]?.split(" ").includes(values[which]) ?? true)
  for (const row of document.querySelectorAll("#drawer .row")) {
    row.hidden = sought ? !`${row.textContent} ${row.dataset.also}`.toLowerCase().includes(sought) : !applies(row)
  }
  for (const group of document.querySelectorAll("#drawer > fieldset"))
    group.hidden = !group.querySelector(".row:not([hidden])")
  for (const button of document.querySelectorAll(".restore")) {
    button.hidden = `${values[button.dataset.name]}` === `${declared.usual[preset][button.dataset.name]}`
  }
}
