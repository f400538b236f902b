// The controls as they show the parameters: sliders, entries and their errors, and the drawer.

import { by, closest, on, say } from "./dom.js"
import { digits, minus } from "./quantities.js"
import { declared, me, view } from "./store.js"

// A slider at the position nearest to a value
export function place(name, value) {
  const slider = by(name), { [name]: values } = declared.positions
  slider.value = closest(values, value)
  slider.dataset.meaning ??= slider.title
  const beyond = value < values[0] || value > values.at(-1)
  slider.title = beyond ? `${minus(value)} lies beyond this slider` : slider.dataset.meaning
  slider.setAttribute("aria-valuetext", minus(value))
}

// The depth itself, beside its part of delta_0, unless that was refused
export function tellDepth(value, refused) {
  const depth = Number(value) * 10 * (me.status.values?.delta_n ?? 1)
  document.querySelector("[data-name=delta_bar] .unit").textContent = refused ? "" : `= ${digits(depth)} nm`
}

// Every control as the server sent it; before: the values sent before
export function describeAll({ values, errors }, before) {
  for (const name in values) describe(name, values[name], errors[name], before?.[name])
  for (const id of ["delta_bar", "delta_bar-entry"]) by(id).disabled = values.path === "points" // they set the depth
  say("profile-error", errors.profile)
}

function describe(name, value, error, before) {
  const entry = by(`${name}-entry`)
  // what was typed stays to be mended, or while it is being typed; a refused choice falls back
  const settled = document.activeElement !== entry || entry.value === entry.dataset.given
  if (entry.matches("select") || !error && settled || value !== before) entry.value = value
  entry.setAttribute("aria-invalid", Boolean(error))
  const fresh = error && by(`${name}-error`).textContent !== error
  say(`${name}-error`, error)
  if (fresh) entry.closest(".row")?.scrollIntoView({ block: "nearest" })
  if (!me.dragging && declared.positions[name]) place(name, value)
  if (name === "delta_bar") tellDepth(value, error)
}

// The drawer of all parameters: shows those that apply to the surface and the path on screen, finds, and restores
export function connectDrawer() {
  view(["status"], fillDrawer)
  on("parameters", "click", openDrawer)
  on("find", "input", fillDrawer)
  on("drawer", "close", () => by("menu").focus())
  for (const button of document.querySelectorAll(".restore")) {
    button.addEventListener("click", () => {
      const entry = by(`${button.dataset.name}-entry`)
      entry.value = declared.usual[me.status.preset][button.dataset.name]
      entry.dispatchEvent(new Event("change"))
      entry.focus()
    })
  }
}

function openDrawer() {
  if (by("drawer").open) return by("drawer").close()
  by("drawer").show()
  if (matchMedia("(max-width: 599px)").matches) document.querySelector(".desk").scrollIntoView() // where it is in sight
  fillDrawer()
}

function fillDrawer() {
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
