// The curves of the run on screen, into their charts.

import { charts, CURVES, DASHED } from "./charts.js"
import { all, by, one, tell } from "./dom.js"
import { differing, digits, fixed, named } from "./quantities.js"
import { me } from "./store.js"

export const LEAST = 0.05 // GPa; weaker traction is not blown up to fill a view
export const NARROW = 0.5 // of the largest area: where it stays above, the axis does not begin at zero
const EDGE = 0.02 // of a curve, that an axis keeps beyond it, so that marks at its ends are whole
const ROOM = 0.3 // of a curve, that an axis which cannot stay gets beyond it in a drag, so that it stays for a while
const SPARE = 0.08 // of a curve, on either side of it on a new axis
const FAR_LESS = 0.6 // of an axis: where no more of it is needed, the axis shrinks

// Let y of a chart hold low..high. It grows at once when too small; it shrinks when far too large, unless a slider is
// held
function fit(chart, low, high) {
  const { start, end } = chart.y, size = Math.max(high - low, 1e-9)
  const below = low - EDGE * size < start, above = high + EDGE * size > end
  const least = low < 0 ? -Infinity : -SPARE * size // what is never negative has no axis below zero
  if (me.dragging)
    chart.range("y",
      { start: below ? Math.max(low - ROOM * size, least) : start, end: above ? high + ROOM * size : end })
  else if (below || above || size < FAR_LESS * (end - start))
    chart.range("y", { start: low - SPARE * size, end: high + SPARE * size })
}

// The end of an axis, where a run needs `needed`, with `spare` of it without harm out of sight
export const settled = (end, needed, spare = 0) =>
  (needed <= (1 + spare) * end && needed > FAR_LESS * end ? end : needed)

// [lowest, highest] of all numbers, and zero
export const extent = (...lists) => lists.reduce(([a, b], list) => {
  for (const v of list) { if (v < a) a = v; if (v > b) b = v }
  return [a, b]
}, [0, 0])

// Whether a run is drawn along the same path as another
export const drawnAlong = (other, run) => other.sheared >= 0 && other.head.abscissa === run.head.abscissa

const NOTHING = { along: [], value: [] }
export function drawCurves(run, ghost, approach) {
  // along something else, or drawn already
  if (me.beside.includes(ghost) || ghost?.head.abscissa !== run.head.abscissa) ghost = null
  const others = me.beside.filter((of) => drawnAlong(of, run))
  const known = new Map([run, ghost, ...others].map((of) => [of, {}])) // made once
  const part = (of, name) => (of ? (known.get(of)[name] ??= of.drawn(name, approach)) : NOTHING)
  for (const [chart, name] of [["forces", "F"], ["forces", "L"], ["area", "A"]]) {
    for (const [label, of] of [[`ghost_${name}`, ghost], [name, run]]) {
      const { along: x, value: y } = part(of, name)
      charts[chart].fill(label, { x, y })
    }
  }
  one(".key .ghost").hidden = ghost === null
  nameGhost(run, ghost)
  nameAxis(approach ? "delta" : run.head.abscissa)
  markSlips(run, approach)
  const values = (name) => [...[...known.keys()].map((of) => part(of, name).value), ...(me.more[name] ?? [])]
  fitCurves(run, approach, ["F", "L"].map(values), values("A"))
}

// Slips, and which way each part of a loop is walked
function markSlips(run, approach) {
  const along = run.normal || approach
  for (const [chart, name, way] of [["forces", along ? "L" : "F", run.normal ? "L" : "F"], ["area", "A", "A"]]) {
    const [x, y] = run.slips(name, null, approach)
    charts[chart].fill("slips", { x, y })
    pointAlong(run, charts[chart], run.curves[way])
  }
}

// Axes that hold the forces and areas of all runs drawn
function fitCurves(run, approach, forces, areas) {
  const [start, end] = run.extent(approach), room = start < end ? 0 : 1 // nm, where nothing is walked
  for (const name of CURVES) charts[name].range("x", { start: start - room, end: end + room })
  fit(charts.forces, ...extent([-0.01, 0.02], ...forces.flat()))
  const wide = areas.flatMap((list) => [...list])
  const least = Math.min(...wide), most = Math.max(...wide, run.head.spacing)
  const from = least > NARROW * most ? least : 0 // a few per cent of peeling must be seen
  fit(charts.area, from, most)
  const begin = from && charts.area.y.start
  tell(by("area-from"), begin > 0 ? `axis begins at ${digits(begin, 2)} nm` : "")
}

const NAMED = 2 // parameters at most

// What the run before was computed with, where that is another scene
function nameGhost({ scene }, ghost) {
  const names = scene && ghost?.scene ? differing(scene, ghost.scene) : []
  const values = names.map((name) => named(name, ghost.scene[name])).join(", ")
  const text = names.length && names.length <= NAMED ? `: ${values}` : ""
  for (const key of all(".key .ghost .of")) tell(key, text)
}

// Which way each part of a loop is walked: heads of arrows, those of its ways at other places
const HEADS = [[0.25, 0.55], [0.2, 0.65], [0.4, 0.9]] // parts of a way
function pointAlong(run, chart, value) {
  const { along, curves: { stage: stages } } = run, loops = run.normal || run.head.span[0] < 0
  const heads = [...new Set(loops ? stages : [])].filter((stage) => stage > 0).flatMap((stage, i) => {
    const first = stages.indexOf(stage), last = stages.lastIndexOf(stage), way = Math.sign(along[last] - along[first])
    return way ? HEADS[i % HEADS.length].map((part) => [Math.round(first + part * (last - first)), way]) : []
  })
  chart.fill("ways", { x: heads.map(([k]) => along[k]), y: heads.map(([k]) => value[k]),
    marker: heads.map(([, way]) => (way > 0 ? "right" : "left")) })
}

// What curves are drawn along
const AXES = {
  U_x: ["Uₓ", "displacement Uₓ (nm)"], delta: ["δ", "indentation δ (nm)"], path: ["path", "length of the path (nm)"],
}
let abscissaNamed = ""
function nameAxis(abscissa) {
  if (abscissa === abscissaNamed) return
  abscissaNamed = abscissa
  const event = abscissa === "delta" ? "jump" : "slip", [, label] = AXES[abscissa]
  for (const word of all(".slips")) word.textContent = event
  const dashed = abscissa !== "delta" // over the same indentation dashes of both ways would fill each other's gaps
  for (const name of ["L", "ghost_L"]) charts.forces.fill(name, { dash: dashed ? DASHED : [] })
  one("main .forces .key > :nth-child(2) .line").classList.toggle("dashed", dashed)
  for (const name of CURVES) charts[name].across = label
}

// What the charts say about a place that the mouse points at
export const where = (x) => `${AXES[abscissaNamed][0]} = ${fixed(x, 1)} nm`
const at = (x) => (me.run?.sheared >= 0 ? me.run.nearest(x, me.at) : null)
const says = (names) => ({ x }) => {
  const k = at(x)
  if (k === null) return null
  const values = me.run.values(k), { abscissa } = me.run.part(me.run.approaching(k))
  return [where(values[abscissa]), ...names.map((name) => named(name, values[name]))]
}
export function connectCurves() {
  charts.forces.says = says(["F", "L"])
  charts.area.says = says(["A"])
}

// The limits of the colours of a chart, GPa, in its key
export function tellLimits(chart, low, high) {
  tell(by(`${chart}-low`), digits(low, 2))
  tell(by(`${chart}-high`), `+${digits(high, 2)} GPa`)
}
