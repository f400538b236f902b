// The drawer of all parameters: shows those that apply to the surface and the path on screen, finds, and restores.

import { all, by, on, one, root } from "../../static/js/dom.js"
import { declared, me, view } from "../../static/js/store.js"

export function connect() {
  view(["status"], fillDrawer)
  on("parameters", "click", openDrawer)
  on("find", "input", fillDrawer)
  on("drawer", "close", () => by("menu").focus())
  root.addEventListener("keydown", ({ key }) => {
    if (key === "Escape" && !one("dialog:modal") && by("drawer").open) by("drawer").close()
  })
  for (const button of all(".restore")) {
    button.addEventListener("click", () => {
      const entry = by(`${button.dataset.name}-entry`)
      entry.value = declared.usual[me.status.preset][button.dataset.name]
      entry.dispatchEvent(new Event("change", { bubbles: true }))
      entry.focus()
    })
  }
}

function openDrawer() {
  if (by("drawer").open) return by("drawer").close()
  by("drawer").show()
  if (matchMedia("(max-width: 599px)").matches) one(".desk").scrollIntoView() // where it is in sight
  fillDrawer()
}

function fillDrawer() {
  const { values, preset } = me.status, sought = by("find").value.trim().toLowerCase()
  if (!values || !by("drawer").open) return
  const applies = ({ dataset }) =>
    ["surface", "path"].every((which) => dataset[which]?.split(" ").includes(values[which]) ?? true)
  for (const row of all("#drawer .row")) {
    row.hidden = sought ? !`${row.textContent} ${row.dataset.also}`.toLowerCase().includes(sought) : !applies(row)
  }
  for (const group of all("#drawer > fieldset"))
    group.hidden = !group.querySelector(".row:not([hidden])")
  for (const button of all(".restore")) {
    button.hidden = `${values[button.dataset.name]}` === `${declared.usual[preset][button.dataset.name]}`
  }
}
