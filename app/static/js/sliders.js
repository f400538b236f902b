// The controls as they show the parameters: sliders, entries and their errors.

import { by, closest, focused, one, say } from "./dom.js"
import { digits, minus } from "./quantities.js"
import { declared, me } from "./store.js"

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
  one("[data-name=delta_bar] .unit").textContent = refused ? "" : `= ${digits(depth)} nm`
}

// Every control as the server sent it; before: the values sent before
export function describeAll({ values, errors }, before) {
  for (const name in values) if (by(`${name}-entry`)) describe(name, values[name], errors[name], before?.[name])
  for (const id of ["delta_bar", "delta_bar-entry"]) by(id).disabled = values.path === "points" // they set the depth
}

function describe(name, value, error, before) {
  const entry = by(`${name}-entry`)
  // what was typed stays to be mended, or while it is being typed; a refused choice falls back
  const settled = focused() !== entry || entry.value === entry.dataset.given
  if (entry.matches("select") || !error && settled || value !== before) entry.value = value
  entry.setAttribute("aria-invalid", Boolean(error))
  const fresh = error && by(`${name}-error`).textContent !== error
  say(`${name}-error`, error)
  if (fresh && entry.closest("dialog")) entry.parentElement.scrollIntoView({ block: "nearest" })
  if (!me.dragging && declared.positions[name]) place(name, value)
  if (name === "delta_bar") tellDepth(value, error)
}
