// The visitor's measured curve over the run on screen, with the setting of the instrument. Loaded with the first file.

import { order, take } from "../channel.js"
import { Chart } from "../chart.js"
import { charts } from "../charts.js"
import { by, make, makeButton, say } from "../dom.js"
import { digits, fixed } from "../quantities.js"
import { enter } from "../steer.js"
import { frame, me, memory, redraw, view } from "../store.js"
import { laidOver, mainOf, pointsOf } from "./measured.js"

const LARGEST = 2e6 // bytes of a file, as the server
const WIDEST = 10 // times that the handle of the scale reaches, either way
const PARTS = { F: "forces", L: "forces", A: "area" } // the chart of a quantity
const NEEDS = { load: "unload", loop: "loop" } // the path that has all segments of a kind
const PLAIN = { scale: 1, zero: 0, shift: 0 }
let name = "" // of the file

// Read a dropped or chosen file
export async function read(file) {
  if (!by("laid")) connect()
  by("laid").hidden = false
  name = file.name
  if (file.size > LARGEST) return refuse(`it has ${(file.size / 1e6).toFixed(1)} MB, allowed: 2 MB; thin it out`)
  by("laid-says").textContent = "reading …"
  return order("curve", { content: await file.arrayBuffer() })
}

export function choose() {
  const input = make("input", { type: "file", onchange: () => { if (input.files[0]) read(input.files[0]) } })
  input.click()
}

function refuse(why) {
  say("laid-why", `${name}: ${why}. ${me.laid ? "The last curve and the run" : "The run"} on screen stay${
    me.laid ? "" : "s"}. A profile of a surface is read under Parameters.`)
  tellApart()
}

function receive({ curve, why, key }) {
  if (!curve) return refuse(why)
  say("laid-why", "")
  me.laid = { curve, key, name, base: PLAIN, set: PLAIN, shown: {}, fresh: true }
  return match(false)
}

// Set the instrument by the least squares; all: also where the unit of the force is known
function match(all) {
  const { laid, charted: run } = me, over = run?.whole && laidOver(laid.curve, run)
  const set = over ? over.matched(all) : laid.set
  me.laid = { ...laid, base: set, set, fresh: !over }
  for (const id of ["laid-scale", "laid-zero"]) by(id).value = 0
  redraw() // axes hold what is measured
  tellApart()
  by("announcement").textContent = by("laid-says").textContent
}

const at = (id) => by(id).value / 100 // of a handle

// What the handles say, from the setting of the last match
function turn() {
  const { laid } = me, { base, curve } = laid, main = curve.segments.flatMap((one) => one[mainOf(curve)])
  const most = Math.max(...main.map(Math.abs)) * Math.abs(base.scale)
  me.laid = { ...laid, set: { ...base, scale: base.scale * WIDEST ** at("laid-scale"),
    zero: base.zero + most * at("laid-zero") } }
}

const laidAgain = memory()
const draws = (run, { curve }) => run.part(run.approaching(me.drawn)).abscissa === curve.over

// The points of the curve in the chart it belongs to
function draw() {
  const { laid, charted: run } = me
  if (!run || !laidAgain(laid, run, run.length, run.whole, me.approach, me.look)) return
  const shown = {}
  if (laid?.fresh && run.whole && laidOver(laid.curve, run)) return match(false)
  for (const [of, chart] of Object.entries(PARTS)) {
    const there = laid && laid.curve.segments[0][of] && draws(run, laid)
    const points = there ? pointsOf(laid.curve, of, run, laid.set) : { x: [], y: [] }
    if (there) shown[of] = points.y
    charts[chart].fill(`laid_${of}`, points)
  }
  if (laid) laid.shown = shown
  drawRelation(run)
  tellApart()
}

// Area over a force, in a plot of its own
function drawRelation(run) {
  const { laid } = me, over = laid?.curve.over, there = over === "F" || over === "L"
  by("laid").querySelector("figure").hidden = !there
  if (!there) return
  charts.relation ??= new Chart(by("laid").querySelector(".view"), { x: { start: 0, end: 1 }, y: { start: 0, end: 1 },
    across: "", up: "A (nm)", parts: {
      A: { kind: "line", ink: "--area", width: 2, x: [], y: [] },
      laid_A: { kind: "marks", marker: "circle", size: 4, hollow: true, ink: "--area", x: [], y: [] },
    } })
  const { from, to } = run.part(over === "L"), chart = charts.relation
  const points = pointsOf(laid.curve, "A", run, laid.set)
  const slip = run.curves.slip.findIndex((slipped, k) => slipped && k >= from)
  const end = over === "F" && slip > 0 ? Math.min(slip, to) : to
  const [x, y] = [over, "A"].map((of) => run.curves[of].slice(from, end))
  chart.across = over === "F" ? "friction F (N/m)" : "load L (N/m)"
  chart.fill("A", { x, y })
  chart.fill("laid_A", points)
  for (const [axis, lists] of [["x", [x, points.x]], ["y", [y, points.y]]]) {
    const all = [...lists.flat(), 0], low = Math.min(...all), high = Math.max(...all), room = 0.06 * (high - low || 1)
    chart.range(axis, { start: low - room, end: high + room })
  }
}

// One number: how far both curves are apart
function tellApart() {
  const { laid, charted: run } = me
  for (const element of by("laid").querySelectorAll(".set")) element.hidden = !laid
  if (!laid) return by("laid-says").replaceChildren()
  const { curve, set } = laid, over = run && laidOver(curve, run), main = mainOf(curve)
  by("laid-show").hidden = Boolean(over) || !NEEDS[curve.kind]
  by("laid-notes").textContent = [curve.notes,
    "A tip is three-dimensional, the model is plane strain: compare forces as ratios."].join(" ")
  const says = [`${laid.name}, ${curve.kind}: `]
  if (over) {
    const { rms, noise, outside, points, from, to } = over.apart(set)
    const unit = { N: "N/m", w: "w", "w E": "w E", F_s: "Fₛ", A_0: "A₀" }[curve.units[main]] ?? curve.units[main]
    const ends = curve.over === "F" || curve.over === "L" ? "" : ` (rms from ${fixed(from, 1)} to ${fixed(to, 1)} nm)`
    says.push(make("b", {}, `${digits(rms, 2)} ${unit} apart`), `${ends}, ${digits(rms / noise, 2)} × its noise`)
    if (outside) says.push(`; ${outside} of ${points} points lie beyond the run`)
  } else says.push(curve.kind in NEEDS ? "this run has no such path" : "this run has nothing to compare it with")
  const scale = set.scale === 1 ? "" : ` times ${digits(set.scale)}`
  const zero = set.zero ? `, plus ${digits(set.zero)}` : ""
  const moved = set.shift ? `; δ moved by ${fixed(set.shift, 1)} nm` : ""
  const also = scale || zero || moved ? `. Drawn:${scale ? ` measured${scale}` : " as measured"}${zero}${moved}` : ""
  by("laid-says").replaceChildren(...says, `${also}.`)
  by("laid-fit").hidden = !["friction", "loop"].includes(curve.kind)
  by("laid-fit").href = `?${new URLSearchParams({ lab: "fit", theme: document.documentElement.dataset.theme,
    ...me.status.address, curve: laid.key })}`
}

function remove() {
  order("curve", { content: new ArrayBuffer() })
  me.laid = null
  by("laid").hidden = true
  redraw()
  by("menu").focus()
}

const handle = (id, text) => make("label", { className: "set" }, `${text} `,
  make("input", { type: "range", id, min: -100, max: 100, value: 0, oninput: turn }))

function connect() {
  by("pins").after(make("section", { id: "laid", className: "pins", "aria-label": "Your data" },
    make("span", { id: "laid-says" }), handle("laid-scale", "scale"), handle("laid-zero", "zero"),
    makeButton({ id: "laid-match", className: "set", title: "Scale and zero with the least squares",
      onclick: () => match(true) }, "Match"),
    makeButton({ id: "laid-show", hidden: true, onclick: () => enter({ path: NEEDS[me.laid.curve.kind] }) },
      "Compute that path"),
    make("a", { id: "laid-fit", className: "set", target: "_blank" }, "Fit from here"),
    makeButton({ id: "laid-remove", "aria-label": "Remove your data", onclick: remove }, "×"),
    make("p", { id: "laid-why", role: "alert", className: "error", hidden: true }),
    make("small", { id: "laid-notes", className: "set note" }),
    make("figure", { className: "relation", hidden: true, "aria-label": "Contact area over force" },
      make("figcaption", {}, make("b", {}, "Contact area over force")),
      make("div", { className: "view", data: { view: "relation" } },
        make("canvas", { className: "chart", "aria-hidden": "true" })))))
  take("curve", receive)
  frame(["charted", "run", "laid", "approach", "look"], draw)
  view(["status"], () => { if (me.laid) tellApart() })
}
