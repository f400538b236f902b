// The dialog "Accuracy": asks for a measurement, shows its progress, and draws what is measured as it comes.

import { order } from "./channel.js"
import { by, make, makeShape, minus, offerTable, on } from "./dom.js"
import { me } from "./state.js"

// series: [class in style.css, place of the text beside a point: x, y, anchor]; page.html has its mark
const SERIES = {
  "fast": ["fast", 9, -5, "start"],
  "gfmd": ["gfmd", 9, -5, "start"],
  "gfmd mass-weighted": ["weighted", 7, 16, "start"],
  "FIRE": ["fire", -9, -5, "end"],
}
const PLOTS = { seconds: "time of one core [s]", evaluations: "force evaluations [1]" }
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
  const points = measurement?.points ?? []
  by("bench-plots").hidden = !points.length
  if (!by("bench").open || !points.length) return
  for (const entry of by("bench-key").children) entry.hidden = !points.some((p) => p.series === entry.dataset.of || p[entry.dataset.of])
  for (const work in PLOTS) drawErrors(by(`error-${work}`), points, work)
}

// Whole decades that hold the values, at least `least` of them
function decades(values, least) {
  const low = Math.floor(Math.log10(Math.min(...values)) - 0.1), high = Math.ceil(Math.log10(Math.max(...values)) + 0.1)
  return [Math.min(low, high - least), high]
}

const raised = (n) => `10${String(n).replace("-", "⁻").replace(/\d/g, (digit) => "⁰¹²³⁴⁵⁶⁷⁸⁹"[digit])}`
const between = (low, high) => Array.from({ length: high - low + 1 }, (_, i) => low + i)
const line = (d, name = "grid") => makeShape("path", { class: name, d })
const write = (x, y, said, more) => makeShape("text", { x, y, "text-anchor": "middle", ...more }, said)

function drawErrors(into, points, work) {
  const width = into.clientWidth, height = into.clientHeight
  const left = 66, right = width - 16, top = 10, bottom = height - 46, middle = (top + bottom) / 2 // px, of the frame
  const [x0, x1] = decades(points.map((p) => p[work]), 2), [y0, y1] = decades(points.map((p) => p.error), 3)
  const x = (log) => left + ((log - x0) / (x1 - x0)) * (right - left)
  const y = (log) => bottom - ((log - y0) / (y1 - y0)) * (bottom - top)
  const every = y1 - y0 < 8 ? 1 : 2 // decades from one number to the next
  into.setAttribute("viewBox", `0 0 ${width} ${height}`)
  into.replaceChildren(
    ...between(x0, x1).flatMap((n) => [line(`M${x(n)} ${top}V${bottom}`), write(x(n), bottom + 18, raised(n))]),
    ...between(y0, y1).map((n) => line(`M${left} ${y(n)}H${right}`)),
    ...between(y0, y1).filter((n) => n % every === 0).map((n) => write(left - 6, y(n) + 4, raised(n), { "text-anchor": "end" })),
    line(`M${left} ${top}V${bottom}H${right}`, "frame"),
    write((left + right) / 2, height - 6, PLOTS[work], { class: "label" }),
    write(14, middle, "relative error [1]", { class: "label", transform: `rotate(-90 14 ${middle})` }),
    ...Object.keys(SERIES).map((series) => seriesOf(points.filter((p) => p.series === series), series, (p) => [x(Math.log10(p[work])), y(Math.log10(p.error))])),
  )
}

function seriesOf(points, series, place) {
  const [name, right, down, anchor] = SERIES[series]
  const group = makeShape("g", { class: `series ${name}` }, makeShape("polyline", { points: points.map(place).join(" ") }))
  for (const p of points) {
    const [x, y] = place(p), tolerance = minus(p.tolerance.toExponential(0))
    const said = `${series}, tolerance ${p.tolerance} nm: error ${p.error.toExponential(0)}, ${p.seconds.toPrecision(2)} s, ${p.evaluations} evaluations`
    group.append(makeShape("use", { class: "point", href: `#mark-${name}`, x, y }, makeShape("title", {}, said)))
    if (p.astray) group.append(makeShape("use", { class: "astray", href: "#mark-astray", x, y }))
    group.append(write(x + right, y + down, tolerance, { "text-anchor": anchor }))
  }
  return group
}

export function connect() {
  for (const what of ["measure", "cancel"]) on(what, "click", () => order(what))
  for (const figure of by("bench-plots").querySelectorAll("figure")) {
    offerTable(figure, "bench", figure.querySelector("figcaption").textContent, (tables) => tables.openMeasured(measurement.points))
  }
  new ResizeObserver(drawBench).observe(by("bench-plots"))
}
