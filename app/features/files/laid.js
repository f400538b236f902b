// The visitor's measured curve over the run on screen, as the server compares both. Loaded with the first file.

import { order, take } from "../../static/js/channel.js"
import { addChart, addPart, charts, line, none } from "../../static/js/charts.js"
import { by, make, makeButton, one, root, say } from "../../static/js/dom.js"
import { enter } from "../../static/js/steer.js"
import { frame, me, memory, redraw, sees, view } from "../../static/js/store.js"
import { choose as chooseCurve, seeMore } from "../../static/js/view.js"

const PARTS = { F: "forces", L: "forces", A: "area" } // the chart of a quantity
const PAUSE = 400 // ms between two comparisons in a drag, whose predictions need the workers
const BEYOND = 0.1 // of the points beyond the run, from which on the curve is drawn in its own range, too
export const AXES = { U_x: "Uₓ", delta: "δ", F: "F", L: "L", A: "A" }
const TIP = "A tip is three-dimensional, the model is plane strain: compare forces as ratios."
const PREFIXES = [["", 1], ["m", 1e3], ["µ", 1e6], ["n", 1e9], ["p", 1e12]]
let asked = null // the run that the server compares with

// again: the file and what was chosen of it, to choose anew
export const lay = { again: null }

const overForce = ({ over }) => over === "F" || over === "L"

// Points of a quantity in the units of the run, or of the file where the server has not compared them
function pointsOf({ curve, apart }, name) {
  const [[times, plus], [across, shift]] = [name, curve.over].map((of) => apart?.set?.[of] ?? [1, 0])
  const there = curve.segments.filter((part) => part[name])
  return { x: there.flatMap(({ x }) => x.map((v) => across * v + shift)),
    y: there.flatMap((part) => part[name].map((v) => times * v + plus)) }
}

function receive({ curve, key }) {
  by("laid").hidden = false
  say("laid-why", "")
  asked = null
  me.laid = { curve, key, name: lay.name, apart: null, run: null }
  if (curve.kind.startsWith("area over displacement")) {
    if (!sees("more")) seeMore()
    chooseCurve("area")
  }
}

// Let the server compare the curve with the run on screen, one run at a time
function compare() {
  const { laid, charted: run } = me
  if (!laid || !run?.whole || laid.run === run || asked) return
  asked = run
  const { force, middle, stages } = run.head
  const content = new Float32Array(laid.curve.columns.flatMap((name) => run.curves[name].map(Number))).buffer
  order("compare", { content, stages, force, width: 2 * middle })
}

function compared(apart) {
  if (!me.laid) return
  if (!me.laid.apart || !me.dragging) redraw() // axes hold what is measured; in a drag they stay
  me.laid = { ...me.laid, apart, run: asked }
  setTimeout(() => {
    asked = null
    compare()
  }, me.dragging ? PAUSE : 0)
}

const again = memory()
const belongs = (run, { curve }) => run.part(run.approaching(me.drawn)).abscissa === curve.over

// The points of the curve in the chart it belongs to
function draw() {
  const { laid, charted: run } = me
  compare()
  if (!run || !again(laid, run, run.length, run.whole, me.approach, me.look)) return
  const shown = {}
  for (const [of, chart] of Object.entries(PARTS)) {
    const there = laid?.apart?.set && laid.curve.segments[0][of] && belongs(run, laid)
    const drawn = there ? pointsOf(laid, of) : none
    if (there) shown[of] = [drawn.y]
    charts[chart].fill(`laid_${of}`, drawn)
  }
  me.more = shown
  drawOwn(run)
  describe()
}

// The curve in a plot of its own: where the run is shorter, and over a force
function drawOwn(run) {
  const { laid } = me, { curve, apart } = laid ?? {}
  const far = apart && (!apart.set || apart.outside > BEYOND * apart.points)
  const there = Boolean(laid) && (far || overForce(curve)), figure = by("laid").querySelector("figure")
  figure.hidden = !there
  if (!there) return
  if (!charts.own)
    addChart("own", { x: { start: 0, end: 1 }, y: { start: 0, end: 1 }, across: "", up: "",
      parts: { run: line("--body", { width: 2 }), points: points("--laid-1") } })
  const { over, main } = curve, drawn = pointsOf(laid, main), chart = charts.own
  const computed = apart?.set ? alongRun(run, curve) : none
  chart.fill("run", computed)
  for (const [axis, side, name] of [["x", "across", over], ["y", "up", main]]) {
    const unit = apart?.set ? ("FL".includes(name) ? "N/m" : "nm") : curve.units[name]
    const all = [...drawn[axis], ...computed[axis]], most = Math.max(...all.map(Math.abs))
    // numbers of newtons that an axis has room for
    const [prefix, times] = (unit === "N" && PREFIXES.find(([, size]) => most * size >= 1)) || ["", 1]
    drawn[axis] = drawn[axis].map((value) => times * value)
    const high = times * Math.max(...all), low = times * Math.min(...all), room = 0.06 * (high - low || 1)
    chart[side] = `${AXES[name]} (${prefix}${unit})`
    chart.range(axis, { start: low - room, end: high + room })
  }
  chart.fill("points", drawn)
}

// The run over the same quantity; an area over friction up to the first slip
function alongRun(run, { over, main }) {
  const { from, to } = run.part(over === "L" || over === "delta")
  const slip = run.curves.slip.findIndex((slipped, k) => slipped && k >= from)
  const end = over === "F" && slip > 0 ? Math.min(slip, to) : to
  const [x, y] = [over, main].map((of) => run.curves[of].slice(from, end))
  return { x, y }
}

// How far both curves are apart, and what was done to the measured one; or what keeps them from being compared
function describe() {
  const { laid } = me
  for (const element of by("laid").querySelectorAll(".set")) element.hidden = !laid
  if (!laid) return by("laid-says").replaceChildren()
  const { curve, apart, name } = laid, says = [make("i", {}, "○ "), `${name}, ${curve.kind}: `]
  by("laid-path").hidden = !apart?.path
  if (!apart) says.push("comparing …")
  else if (apart.why) says.push(`${apart.why}.`)
  else says.push(make("b", {}, apart.near), apart.says)
  by("laid-says").replaceChildren(...says)
  by("laid-notes").textContent = [curve.notes, Object.values(curve.units).includes("N") ? TIP : ""].join(" ")
  by("laid-fit").hidden = !(laid.key && one("nav [data-lab=fit]"))
  by("laid-fit").href = `?${new URLSearchParams({ lab: "fit", theme: root.dataset.theme,
    ...me.status.address, curve: laid.key })}`
  by("laid-again").hidden = !lay.again
}

// After the connection was lost, and the page was opened again
export function askAgain(name) {
  prepare()
  by("laid").hidden = false
  say("laid-why", `${name}: the connection was lost, and the curve with it; choose the file again.`)
}

function remove() {
  order("forget")
  asked = null
  me.laid = null
  by("laid").hidden = true
  redraw()
  by("menu").focus()
}

const points = (ink) => ({ kind: "marks", marker: "circle", size: 5, hollow: true, ink, ...none })

// Make what is there with the first file
export function prepare() {
  if (by("laid")) return
  addPart("forces", "laid_F", points("--laid-1"), "F")
  addPart("forces", "laid_L", points("--laid-2"), "F")
  addPart("area", "laid_A", points("--laid-1"), "A")
  by("above").append(make("section", { id: "laid", className: "strip", "aria-label": "Your data", hidden: true },
    make("span", { id: "laid-says", role: "status" }),
    makeButton({ id: "laid-path", hidden: true, onclick: () => enter({ path: me.laid.apart.path }) },
      "Compute that path"),
    makeButton({ id: "laid-again", className: "set", "aria-haspopup": "dialog", onclick: async () => {
      const { file, ...chosen } = lay.again
      await (await import("./dialog.js")).open(file, chosen)
    } }, "Columns and part"),
    make("a", { id: "laid-fit", className: "set", target: "_blank" }, "Fit from here"),
    makeButton({ id: "laid-remove", "aria-label": "Remove your data", onclick: remove }, "×"),
    make("p", { id: "laid-why", role: "alert", className: "error", hidden: true }),
    make("small", { id: "laid-notes", className: "note set" }),
    make("figure", { hidden: true, "aria-label": "Your data in their own range" },
      make("div", { className: "view", data: { view: "own" } },
        make("canvas", { className: "chart", "aria-hidden": "true" })))))
  take("laid", receive)
  take("compared", compared)
  frame(["charted", "run", "laid", "approach", "look"], draw)
  view(["status"], () => { if (me.laid) describe() })
}
