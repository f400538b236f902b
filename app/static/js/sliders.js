// The controls as they show the parameters: sliders with their marks, entries and their errors, and the drawer.

import { by, closest, make, makeButton, on, say } from "./dom.js"
import { digits, minus } from "./quantities.js"
import { declared, me, memory, view } from "./store.js"

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

// Marks beside the sliders, where the behaviour changes (solver/analysis/marks.py); a click goes there
const APART = [0.2, 64] // of a slider, and px, between two labels, at least
const ENDS = [0.12, 0.82] // of it, beyond which a label stands beside its mark, so that it stays on the slider

const drawn = memory()

export function drawMarks(marks) {
  if (!drawn(JSON.stringify(marks))) return
  for (const name in declared.positions) draw(name, marks[name] ?? [], declared.positions[name])
}

function draw(name, marks, values) {
  const scale = by(name).parentElement.querySelector(".ends"), labels = []
  const apart = Math.max(APART[0], APART[1] / (by(name).clientWidth || Infinity))
  for (const old of scale.querySelectorAll(".mark")) old.remove()
  const titles = marks.map(([value, label]) => `${label} at ${digits(value, 2)}`)
  marks.forEach(([value, label], i) => {
    const at = partAt(value, values), onclick = () => goThere(by(name), closest(values, value))
    // those who cannot see it hear of it at the slider, which has the keyboard
    const mark = makeButton({ className: "mark", title: `${titles[i]}: click to go there`, tabIndex: -1, onclick })
    mark.style.left = `calc(8px + ${at} * (100% - 16px))`
    if (labels.every((other) => Math.abs(other - at) > apart)) {
      mark.append(make("span", {}, label))
      const left = at > ENDS[1] ? "left" : ""
      mark.dataset.side = at < ENDS[0] ? "right" : left
      labels.push(at)
    }
    scale.append(mark)
  })
  by(`${name}-marked`).textContent = marks.length ? `Here: ${titles.join(", ")}.` : ""
}

// Move a slider as a hand does, and let it go
function goThere(slider, position) {
  slider.value = position
  for (const type of ["input", "pointerup"]) slider.dispatchEvent(new Event(type))
}

// Part of the slider at which a value lies
function partAt(value, values) {
  const above = Math.max(1, values.findIndex((v) => v >= value)), below = above - 1
  return (below + (value - values[below]) / (values[above] - values[below])) / (values.length - 1)
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
