// The dialog "Accuracy": asks for a measurement, shows its progress, and draws what is measured as it comes.

import { order } from "./channel.js"
import { by, make, makeShape, minus, offerTable, on } from "./dom.js"
import { me } from "./state.js"

// series: [class in style.css, outline of the marker around 0, 0, place of the text beside it: x, y, anchor]
const MARKERS = {
  "fast": ["fast", "M-5 0a5 5 0 1 0 10 0a5 5 0 1 0-10 0z", 9, -5, "start"],
  "gfmd": ["gfmd", "M-4.5-4.5h9v9h-9z", 9, -5, "start"],
  "gfmd mass-weighted": ["weighted", "M0-6l5.5 10h-11z", 7, 16, "start"],
  "FIRE": ["fire", "M0-6.5l5.5 6.5l-5.5 6.5l-5.5-6.5z", -9, -5, "end"],
}
const CROSS = "M-8-8l16 16M-8 8l16-16"
const PLOTS = { seconds: "time of one core [s]", evaluations: "force evaluations [1]" }
const AROUND = { left: 66, right: 16, top: 10, bottom: 46 } // px beside the frame
let measurement = null // what the server said last

export function openBench() {
  tellBench()
  by("bench").showModal()
  drawBench()
}

export function measured(text) {
  measurement = JSON.parse(text)
  tellBench()
  drawBench()
}

const described = (values) => minus(`δ/δ₀ = ${values.delta_bar}, φₜ/φₙ = ${values.phi_ratio}, E = ${values.E} GPa`)

function tellBench() {
  const now = me.status.values
  by("bench-scene").textContent = now ? described(now) : ""
  by("measure").disabled = !now
  if (!measurement) return
  const { state, progress, why, sentence, others, values } = measurement
  const busy = state === "waiting" || state === "measuring"
  const foreign = now && described(now) !== described(values) ? `, with ${described(values)}` : ""
  const text = {
    waiting: "getting ready, or waiting for another visitor's measurement",
    measuring: `${Math.round(100 * progress)} %`,
    done: `done${foreign}`,
    cancelled: `cancelled${why ? `: ${why}` : ""}${foreign}`,
    failed: `failed: ${why}`,
  }
  by("bench-state").textContent = text[state]
  by("bench-state").dataset.state = state
  by("bench-progress").value = progress
  const [pressed, other] = busy ? ["measure", "cancel"] : ["cancel", "measure"]
  by(other).disabled = false
  if (document.activeElement === by(pressed)) by(other).focus() // a disabled button would lose the keyboard
  by(pressed).disabled = true
  by("bench-sentence").hidden = by("others").hidden = !sentence
  by("bench-sentence").textContent = sentence ?? ""
  by("others").replaceChildren(...(others ?? []).map((line) => make("li", {}, line)))
}

function drawBench() {
  by("bench-plots").hidden = !measurement?.points.length
  if (!by("bench").open || by("bench-plots").hidden) return
  drawKey(measurement.points)
  for (const work in PLOTS) drawErrors(by(`error-${work}`), measurement.points, work)
}

function svg(parent, name, attributes, text) {
  return parent.appendChild(makeShape(name, attributes, ...(text === undefined ? [] : [text])))
}

function drawKey(points) {
  const key = by("bench-key")
  key.replaceChildren()
  const entry = (text, draw) => {
    const item = key.appendChild(make("span"))
    draw(svg(item, "svg", { viewBox: "-15 -8 30 16", "aria-hidden": true }))
    item.append(text)
  }
  for (const [series, [name, path]] of Object.entries(MARKERS)) {
    if (!points.some((p) => p.series === series)) continue
    entry(series, (into) => {
      const group = svg(into, "g", { class: `series ${name}` })
      svg(group, "path", { d: "M-15 0h30" })
      svg(group, "path", { d: path })
    })
  }
  if (points.some((p) => p.astray)) entry("other branch than the reference", (into) => svg(into, "path", { class: "astray", d: CROSS }))
  key.append(" · numbers in the plot: tolerance [nm]")
}

// Whole decades that hold the values, at least `least` of them
function decades(values, least) {
  const low = Math.floor(Math.log10(Math.min(...values)) - 0.1), high = Math.ceil(Math.log10(Math.max(...values)) + 0.1)
  return [Math.min(low, high - least), high]
}

const raised = (n) => `10${String(n).replace("-", "⁻").replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])}`

function drawErrors(into, points, work) {
  const width = into.clientWidth, height = into.clientHeight
  const { left, right, top, bottom } = AROUND
  const [x0, x1] = decades(points.map((p) => p[work]), 2), [y0, y1] = decades(points.map((p) => p.error), 3)
  const x = (log) => left + ((log - x0) / (x1 - x0)) * (width - left - right)
  const y = (log) => height - bottom - ((log - y0) / (y1 - y0)) * (height - top - bottom)
  into.replaceChildren()
  into.setAttribute("viewBox", `0 0 ${width} ${height}`)
  for (let n = x0; n <= x1; n++) {
    svg(into, "path", { class: "grid", d: `M${x(n)} ${top}V${height - bottom}` })
    svg(into, "text", { x: x(n), y: height - bottom + 18, "text-anchor": "middle" }, raised(n))
  }
  for (let n = y0; n <= y1; n++) {
    svg(into, "path", { class: "grid", d: `M${left} ${y(n)}H${width - right}` })
    if (y1 - y0 < 8 || n % 2 === 0) svg(into, "text", { x: left - 6, y: y(n) + 4, "text-anchor": "end" }, raised(n))
  }
  svg(into, "path", { class: "frame", d: `M${left} ${top}V${height - bottom}H${width - right}` })
  svg(into, "text", { class: "label", x: (left + width - right) / 2, y: height - 6, "text-anchor": "middle" }, PLOTS[work])
  const middle = (top + height - bottom) / 2
  svg(into, "text", { class: "label", x: 14, y: middle, "text-anchor": "middle", transform: `rotate(-90 14 ${middle})` }, "relative error [1]")
  for (const series in MARKERS) drawSeries(into, points.filter((p) => p.series === series), (p) => [x(Math.log10(p[work])), y(Math.log10(p.error))])
}

function drawSeries(into, points, place) {
  if (!points.length) return
  const [name, path, right, down, anchor] = MARKERS[points[0].series]
  const group = svg(into, "g", { class: `series ${name}` })
  svg(group, "polyline", { points: points.map((p) => place(p).join()).join(" ") })
  for (const p of points) {
    const [x, y] = place(p), moved = { transform: `translate(${x} ${y})` }
    const said = `${p.series}, tolerance ${p.tolerance} nm: error ${p.error.toExponential(0)}, ${p.seconds.toPrecision(2)} s, ${p.evaluations} evaluations`
    svg(svg(group, "path", { class: "point", d: path, ...moved }), "title", {}, said)
    if (p.astray) svg(group, "path", { class: "astray", d: CROSS, ...moved })
    svg(group, "text", { x: x + right, y: y + down, "text-anchor": anchor }, minus(p.tolerance.toExponential(0)))
  }
}

export function connect() {
  for (const what of ["measure", "cancel"]) on(what, "click", () => order(what))
  for (const figure of by("bench-plots").querySelectorAll("figure")) {
    offerTable(figure, "bench", figure.querySelector("figcaption").textContent, (tables) => tables.openMeasured(measurement.points))
  }
  new ResizeObserver(drawBench).observe(by("bench-plots"))
}
