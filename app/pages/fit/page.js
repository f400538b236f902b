// The page "Fit": a measured curve, over it that of the sliders, and what a fit has found.

import { ask, order, sendFile } from "../../static/js/channel.js"
import { set } from "../../static/js/bokeh.js"
import { by, make, minus, on } from "../../static/js/dom.js"
import { extent, figures, fill } from "../../static/js/figures.js"
import { leaveBehind } from "../../static/js/state.js"

const ROOM = 0.08 // of a curve, above and below it
const OWN = ["phi_n", "phi_ratio", "delta_bar", "E"] // of what is found, what the experiment has; the rest is of the axes

let found = null // {values, errors: {name: number}, correlations}
let measured = false // whether there is a measurement, which sets the ranges
let drawn = null // the run whose curve is there, and how much of it

const chosen = () => [...document.querySelectorAll("#fit-free input")].filter((box) => box.checked)

export function connect() {
  sendFile("measurement", (why) => { by("fit-said").textContent = why })
  on("fit-go", "click", () => ask({ what: "fit", free: chosen().map((box) => box.name).join() }))
  on("fit-show", "click", show)
}

export const opened = () => { drawn = null }

export function told(news) {
  by("fit-go").disabled = !("fit" in news) || (news.busy ?? null) !== null
  measured = "fit" in news
  if (news.fit === found) return
  found = news.fit ?? null
  by("fit-values").hidden = by("fit-show").hidden = !found
  if (found) by("fit-values").tBodies[0].replaceChildren(...Object.keys(found.values).map(row))
}

function row(name, i) {
  const box = by("fit-free").querySelector(`[name="${name}"]`)
  const others = found.correlations[i].slice(0, i).map((value) => minus(value.toFixed(2))).join("  ")
  const texts = [box.parentElement.textContent, `${minus(found.values[name])} ${box.value}`, `${found.errors[name]}`, others]
  return make("tr", {}, ...texts.map((text, k) => make(k ? "td" : "th", {}, text)))
}

function show() {
  leaveBehind()
  order("scene", Object.fromEntries(OWN.filter((name) => name in found.values).map((name) => [name, `${found.values[name]}`])))
}

// The curve of the run on screen, as far as it is there
export function frame(run) {
  const state = `${run.number} ${run.length} ${Boolean(run.followed)}`
  if (drawn === state && !run.followed) return
  drawn = state
  for (const [part, force] of [["run", "F"], ["run_load", "L"]]) fill("fit_curve", part, { U_x: run.shear("U_x"), F: run.shear(force) })
  if (measured) return
  const [low, high] = extent(run.shear("F"), run.shear("L")), room = ROOM * (high - low || 1)
  const [start, end] = extent(run.shear("U_x"))
  set(figures.fit_curve.y_range, { start: low - room, end: high + room })
  for (const name of ["fit_curve", "fit_residuals"]) set(figures[name].x_range, { start, end: end || 1 })
}
