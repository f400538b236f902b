// The page "Fit": a measured curve, over it that of the sliders, and what a fit has found.

import { ask, order, sendFile } from "../../static/js/channel.js"
import { set } from "../../static/js/bokeh.js"
import { by, make, on } from "../../static/js/dom.js"
import { extent, figures, fill } from "../../static/js/figures.js"
import { minus } from "../../static/js/quantities.js"
import { beginChange, me } from "../../static/js/store.js"

const ROOM = 0.08 // of a curve, above and below it
// parameters of the scene; the others belong to the axes
const OWN = ["phi_n", "phi_ratio", "delta_bar", "E", "drive_t"]

let fitted = null // {values, errors, truth: {name: number}, correlations}
let measured = false // whether there is a measurement, which sets the ranges
let drawn = null // the run whose curve is there, and how much of it
let sent = "", answers = 0 // name of the file sent last; how many answers have come

const chosen = () => [...document.querySelectorAll("#fit-free input")].filter((box) => box.checked)

export function connect() {
  on("measurement", "change", ({ target: { files: [file] } }) => { sent = file?.name ?? "" })
  sendFile("measurement", (why) => { by("fit-text").textContent = why })
  on("fit-go", "click", () => ask({ what: "fit", free: chosen().map((box) => box.name).join() }))
  on("fit-show", "click", show)
}

export const opened = () => { drawn = null }

export function receive(news) {
  by("fit-go").disabled = !("fit" in news) || (news.busy ?? null) !== null
  measured = "fit" in news
  if (news.answers !== answers) nameMeasurement(news)
  fitted = news.fit ?? null
  by("fit-values").hidden = by("fit-show").hidden = !fitted
  if (fitted) by("fit-values").tBodies[0].replaceChildren(...Object.keys(fitted.values).map(row))
}

// Which measurement is in use: the name beside the input would be that of a refused one, too
function nameMeasurement(news) {
  answers = news.answers
  by("measurement").value = ""
  if (answers && !news.refused) by("fit-of").textContent = news.made ? "example data" : sent
}

function row(name, i) {
  const box = by("fit-free").querySelector(`[name="${name}"]`)
  const others = fitted.correlations[i].slice(0, i).map((value) => minus(value.toFixed(2))).join("  ")
  by("fit-truth").hidden = !(name in fitted.truth)
  const value = `${minus(fitted.values[name])} ${box.value}`
  const texts = [box.parentElement.textContent, value, `${fitted.errors[name]}`]
  if (name in fitted.truth) texts.push(minus(fitted.truth[name]))
  return make("tr", {}, ...[...texts, others].map((text, k) => make(k ? "td" : "th", {}, text)))
}

function show() {
  beginChange()
  me.move = { name: "" } // one step of Undo
  const own = OWN.filter((name) => name in fitted.values)
  order("scene", { values: Object.fromEntries(own.map((name) => [name, `${fitted.values[name]}`])) })
}

// The curve of the run on screen, as far as it is there
export function frame(run) {
  const state = `${run.number} ${run.length} ${Boolean(run.followed)}`
  if (drawn === state && !run.followed) return
  drawn = state
  for (const [part, force] of [["run", "F"], ["run_load", "L"]]) {
    fill("fit_curve", part, { U_x: run.shear("U_x"), F: run.shear(force) })
  }
  if (measured) return
  const [low, high] = extent(run.shear("F"), run.shear("L")), room = ROOM * (high - low || 1)
  const [start, end] = extent(run.shear("U_x"))
  set(figures.fit_curve.y_range, { start: low - room, end: high + room })
  for (const name of ["fit_curve", "fit_residuals"]) set(figures[name].x_range, { start, end: end || 1 })
}
