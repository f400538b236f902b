// The visitor's measured curve over the run on screen, with the setting of the instrument. Loaded with the first file.

import { order, take, tooLarge } from "../../static/js/channel.js"
import { addChart, addPart, charts, line, none } from "../../static/js/charts.js"
import { NARROW } from "../../static/js/curves.js"
import { by, make, makeButton, one, root, say } from "../../static/js/dom.js"
import { digits, fixed } from "../../static/js/quantities.js"
import { enter } from "../../static/js/steer.js"
import { frame, me, memory, redraw, sees, view } from "../../static/js/store.js"
import { choose as chooseCurve, seeMore } from "../../static/js/view.js"
import { laidOver, largest, mainOf, pointsOf } from "./measured.js"

const WIDEST = 10 // times that the handle of the scale reaches, either way
const DRAWN = 150 // points at most: more of them hide the run
const PARTS = { F: "forces", L: "forces", A: "area" } // the chart of a quantity
const PLAIN = { scale: 1, zero: 0, shift: 0 }
const ASKED = { speed: "speed (nm/s)", force: "N/m per unit of the force" } // what a file may not say
const TIP = "A tip is three-dimensional, the model is plane strain: compare forces as ratios."
let file = null // {name, content} as read last

// The path that has all stages of a curve, where the run has not
const pathOf = ({ kind }) => (kind === "load" ? "unload" : kind === "loop" ? "loop" : "shear")

// Read a dropped or chosen file
export async function read(given) {
  if (!by("laid")) connect()
  by("laid").hidden = false
  file = { name: given.name, content: await given.arrayBuffer() }
  if (me.lost) return refuse("the server does not answer; choose it again when it does")
  if (tooLarge(given)) return refuse(`it has ${tooLarge(given)}; leave out points`)
  if (!given.size) return refuse("it is empty; choose a file with columns such as U_x (nm) and F (N/m)")
  return send()
}

function send(asked = {}) {
  by("laid-says").textContent = "reading …"
  order("curve", { content: file.content, ...asked })
}

export function choose() {
  const input = make("input", { type: "file", onchange: () => { if (input.files[0]) read(input.files[0]) } })
  input.click()
}

// After the connection was lost, and the page was opened again
export function askAgain(name) {
  connect()
  by("laid").hidden = false
  file = { name }
  refuse("the connection was lost, and the curve with it; choose the file again")
}

function refuse(why) {
  const asks = Object.keys(ASKED).find((name) => why.includes(`${name}=`)) ?? ""
  const text = why.replaceAll(/give \w+= \([^)]*\)/g, "write it here")
  const profile = why.includes("needed: U_x") ? " A profile of a surface is read under Parameters." : ""
  say("laid-why", `${file.name}: ${text}. The run on screen stays.${profile}`)
  by("laid-ask").hidden = !asks
  by("laid-ask").dataset.asks = asks
  by("laid-ask").firstChild.textContent = `${ASKED[asks] ?? ""} `
  describe()
}

function answer() {
  const { asks } = by("laid-ask").dataset, value = Number(by("laid-asked").value.replace(",", "."))
  if (value > 0) return send({ [asks]: value })
  return say("laid-why", `${ASKED[asks]} = ${by("laid-asked").value}: allowed: a number above 0; correct it.`)
}

function receive({ curve, why, key }) {
  if (!curve) return refuse(why)
  say("laid-why", "")
  by("laid-ask").hidden = true
  me.laid = { curve, key, name: file.name, base: PLAIN, set: PLAIN, fresh: true }
  if (curve.kind === "area over displacement") {
    if (!sees("more")) seeMore()
    chooseCurve("area")
  }
  return match(false)
}

// Set the instrument by the least squares; all: also scale and zero where the unit of the force is known
function match(all) {
  const { laid, charted: run } = me, over = run?.whole && laidOver(laid.curve, run), set = over && over.matched(all)
  place(set || laid.set, { fresh: !over, off: Boolean(over) && !set })
  redraw() // axes hold what is measured
  describe()
  by("announcement").textContent = by("laid-says").textContent
}

// The handles begin at a setting
function place(set, more) {
  me.laid = { ...me.laid, base: set, set, ...more }
  for (const id of ["laid-scale", "laid-zero", "laid-shift"]) by(id).value = 0
}

const at = (id) => by(id).value / 100 // of a handle

// What the handles say, from the setting of the last match
function turn() {
  const { base, curve } = me.laid, most = largest(curve.segments.flatMap((part) => part[mainOf(curve)]))
  const far = largest(curve.segments.flatMap(({ x }) => x))
  const set = { scale: base.scale * WIDEST ** at("laid-scale"),
    zero: base.zero + most * Math.abs(base.scale) * at("laid-zero"), shift: base.shift + far * at("laid-shift") }
  me.laid = { ...me.laid, set, off: false }
  const texts = { scale: `times ${digits(set.scale)}`, zero: `plus ${digits(set.zero)}`,
    shift: `moved by ${digits(set.shift)} nm` }
  for (const name in texts) by(`laid-${name}`).setAttribute("aria-valuetext", texts[name])
}

const again = memory()
const belongs = (run, { curve }) => run.part(run.approaching(me.drawn)).abscissa === curve.over
const thinned = (list) => {
  const every = Math.ceil(list.length / DRAWN)
  return list.filter((_, k) => k % every === 0)
}

// The points of the curve in the chart it belongs to
function draw() {
  const { laid, charted: run } = me
  if (!run || !again(laid, run, run.length, run.whole, me.approach, me.look)) return
  if (laid?.fresh && run.whole && laidOver(laid.curve, run)) return match(false)
  const shown = {}
  for (const [of, chart] of Object.entries(PARTS)) {
    const there = laid && !laid.off && laid.curve.segments[0][of] && belongs(run, laid)
    const { x, y } = there ? pointsOf(laid.curve, of, run, laid.set) : { x: [], y: [] }
    if (there) shown[of] = [y]
    charts[chart].fill(`laid_${of}`, { x: thinned(x), y: thinned(y) })
  }
  me.more = shown
  drawRelation(run)
  describe()
}

// Area over a force, in a plot of its own
function drawRelation(run) {
  const { laid } = me, over = laid?.curve.over, there = over === "F" || over === "L"
  by("laid").querySelector("figure").hidden = !there
  if (!there) return
  if (!charts.relation)
    addChart("relation", { x: { start: 0, end: 1 }, y: { start: 0, end: 1 }, across: "", up: "A (nm)",
      parts: { A: line("--area", { width: 2 }), laid_A: { ...charts.area.parts.laid_A } } })
  const { from, to } = run.part(over === "L"), chart = charts.relation
  const points = pointsOf(laid.curve, "A", run, laid.set)
  const slip = run.curves.slip.findIndex((slipped, k) => slipped && k >= from)
  const end = over === "F" && slip > 0 ? Math.min(slip, to) : to
  const [x, y] = [over, "A"].map((of) => run.curves[of].slice(from, end))
  chart.across = over === "F" ? "friction F (N/m)" : "load L (N/m)"
  chart.fill("A", { x, y })
  chart.fill("laid_A", { x: thinned(points.x), y: thinned(points.y) })
  for (const [axis, lists] of [["x", [x, points.x]], ["y", [y, points.y]]]) {
    const all = lists.flat(), high = Math.max(...all, 0), least = Math.min(...all)
    const low = least > NARROW * high ? least : Math.min(least, 0), room = 0.06 * (high - low || 1)
    chart.range(axis, { start: low - room, end: high + room })
  }
}

const UNITS = { N: "N/m", "w E": "w E", F_s: "Fₛ", A_0: "A₀" }
const MISSING = { unload: "no retraction", loop: "no way back", shear: "no shear" }

// One number: how far both curves are apart, and what was done to the measured one
function describe() {
  const { laid, charted: run } = me
  for (const element of by("laid").querySelectorAll(".set")) element.hidden = !laid
  if (!laid) return by("laid-says").replaceChildren()
  const { curve, set, off } = laid, over = run && laidOver(curve, run), main = mainOf(curve), unit = curve.units[main]
  const found = over && !off && over.apart(set), says = [make("i", {}, "○ "), `${laid.name}, ${curve.kind}: `]
  by("laid-path").hidden = Boolean(over)
  if (found) {
    const { rms, noise, outside, points, from, to } = found, lengths = curve.over === "U_x" || curve.over === "delta"
    says.push(make("b", {}, `rms difference ${digits(rms, 2)} ${UNITS[unit] ?? unit}`),
      lengths ? ` (${fixed(from, 1)} to ${fixed(to, 1)} nm)` : "", `, ${digits(rms / noise, 2)} times the noise`,
      outside ? `; ${outside} of ${points} points lie beyond the run` : "")
  } else if (over) says.push("no zero and positive scale bring half of it over the run: compute a longer one")
  else says.push(`this run has ${MISSING[pathOf(curve)]}`)
  const per = unit === "N" ? " N/m per N" : "", scale = set.scale === 1 ? "" : ` × ${digits(set.scale)}${per}`
  if (found && (scale || set.zero)) says.push(`. Drawn: ${main}${scale} + ${digits(set.zero)}`)
  if (found && set.shift) says.push(`. Drawn: δ + ${fixed(set.shift, 1)} nm`)
  by("laid-says").replaceChildren(...says, ".")
  by("laid-notes").textContent = [curve.notes, Object.values(curve.units).includes("N") ? TIP : ""].join(" ")
  by("laid-shift").parentNode.hidden = !curve.free
  const fits = one("nav [data-lab=fit]") && ["friction", "loop"].includes(curve.kind)
  by("laid-fit").hidden = !fits || unit === "N"
  by("laid-fit").href = `?${new URLSearchParams({ lab: "fit", theme: root.dataset.theme,
    ...me.status.address, curve: laid.key })}`
}

function remove() {
  order("forget")
  me.laid = null
  by("laid").hidden = true
  redraw()
  by("menu").focus()
}

const points = (ink) => ({ kind: "marks", marker: "circle", size: 5, hollow: true, ink, ...none })
const handle = (id, text) => make("label", {}, `${text} `,
  make("input", { type: "range", id, min: -100, max: 100, value: 0, oninput: turn }))

function connect() {
  addPart("forces", "laid_F", points("--laid-1"), "F")
  addPart("forces", "laid_L", points("--laid-2"), "F")
  addPart("area", "laid_A", points("--laid-1"), "A")
  by("above").append(make("section", { id: "laid", className: "strip", "aria-label": "Your data" },
    make("span", { id: "laid-says" }),
    makeButton({ id: "laid-path", hidden: true, onclick: () => enter({ path: pathOf(me.laid.curve) }) },
      "Compute that path"),
    make("a", { id: "laid-fit", className: "set", target: "_blank" }, "Fit from here"),
    make("details", { className: "set" }, make("summary", {}, "Instrument"),
      handle("laid-scale", "scale"), handle("laid-zero", "zero"), handle("laid-shift", "zero of δ"),
      makeButton({ id: "laid-match", title: "Scale and zero with the least squares", onclick: () => match(true) },
        "Match"),
      makeButton({ id: "laid-plain", onclick: () => place(PLAIN, { off: false }) }, "As measured"),
      make("small", { id: "laid-notes", className: "note" })),
    makeButton({ id: "laid-remove", "aria-label": "Remove your data", onclick: remove }, "×"),
    make("p", { id: "laid-why", role: "alert", className: "error", hidden: true }),
    make("label", { id: "laid-ask", hidden: true }, "", make("input", { id: "laid-asked", inputmode: "decimal" }),
      makeButton({ onclick: answer }, "Read")),
    make("figure", { className: "relation", hidden: true, "aria-label": "Contact area over force" },
      make("figcaption", {}, make("b", {}, "Contact area over force")),
      make("div", { className: "view", data: { view: "relation" } },
        make("canvas", { className: "chart", "aria-hidden": "true" })))))
  take("measured", receive)
  frame(["charted", "run", "laid", "approach", "look"], draw)
  view(["status"], () => { if (me.laid) describe() })
}
