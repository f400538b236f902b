// The punch, its nodes and the tractions of a frame, and the ranges that hold all frames of a run.

import { change, charts, CURVES } from "./charts.js"
import { settled } from "./curves.js"
import { by, one } from "./dom.js"
import { fixed } from "./quantities.js"
import { declared, me } from "./store.js"

export const BAR = 9 // px, height of the top of the layer
const DEEP = 1.2 // nm below the sites that are in view; a punch that goes deeper has a deeper view
const TAIL = 0.2 // of what acts may lie out of sight, where attraction is weak, before the axis grows
const LARGER = 3 // times, at most, that a displacement sideways is drawn
const IN_SIGHT = 0.4 // of half of the view: the top is drawn to move by no more
const SITES = 5 // of a flat surface on either side of the middle: it is all alike

// By how much every displacement sideways is drawn larger, so that lean and slip are seen
export function sideways({ head, normal }) {
  if (head.flat) return 1
  const far = normal ? 0 : Math.max(...head.span.map(Math.abs)) // nm, what the top moves
  return Math.max(1, Math.min(LARGER, Math.floor((IN_SIGHT * charts.punch.x.end) / far)))
}

// Frame k with `drawn`: x as it is drawn, with displacements so many times as large
export function drawnFrame(run, k, times = sideways(run)) {
  const frame = run.frame(k), { first, spacing, middle } = run.headOf(k)
  const larger = (x, i) => times * x - (times - 1) * ((first + i) * spacing - middle)
  const drawn = times === 1 ? frame.x : frame.x.map(larger)
  return { ...frame, drawn, times }
}

export function drawFrame(run, k) {
  const frame = drawnFrame(run, k)
  const top = Math.max(7, Math.min(...frame.gap) + 3) // a punch still far away must be in view as well
  if (!me.dragging) charts.punch.range("y", { end: top })
  drawPunch(run, frame)
  const at = run.curves[run.part(run.approaching(k)).abscissa][k]
  for (const name of CURVES) charts[name].fill("cursor", { at })
}

function drawPunch(run, frame) {
  const { drawn: x, gap } = frame, { punch } = charts
  for (const label of ["body", "surface"]) punch.fill(label, { x, y: gap })
  const groups = Object.groupBy(x.keys(), frame.state)
  for (const label in declared.nodes) {
    const pick = (list) => Float32Array.from(groups[label] ?? [], (i) => list[i])
    punch.fill(label, { x: pick(x), y: pick(gap) })
  }
  punch.says = run.head.flat ? () => null : (_, at) => saidOf(frame, at)
  if (!run.head.flat) return
  const { mark, label } = declared.nodes[frame.state(0)] // in the key of a flat surface, whose nodes are alike
  by("flat-mark").className = mark
  by("flat-state").textContent = label
}

// The node under the mouse, in words
const NEAR = 8 // px
function saidOf({ x, drawn, gap, T_n, T_t, state }, at) {
  const { X, Y } = charts.punch.box, far = (i) => Math.hypot(X(drawn[i]) - at.x, Y(gap[i]) - at.y)
  const i = drawn.reduce((best, _, k) => (far(k) < far(best) ? k : best), 0)
  return far(i) > NEAR ? null : [declared.nodes[state(i)].label, `x = ${fixed(x[i], 1)} nm`,
    `gap = ${fixed(gap[i], 3)} nm`, `Tₙ = ${fixed(T_n[i], 3)} GPa`, `Tₜ = ${fixed(T_t[i], 3)} GPa`]
}

// The sites of the lattice: a line of dashes, which is quicker to paint than hundreds of marks
const SITE = 2.5 // px
function drawSites({ spacing, middle }) {
  const { box, x } = charts.punch, half = Math.ceil(x.end / spacing) + 2
  if (!box) return
  const first = (Math.round(middle / spacing) - half) * spacing - middle - SITE / 2 / box.across
  charts.punch.fill("sites", { width: SITE, dash: [SITE, spacing * box.across - SITE],
    x: [first, first + 2 * half * spacing + SITE / box.across], y: [0, 0] })
}

// How far from the middle something acts in the run on screen, nm, as an axis
export const reach = { half: 250 }
// The same of a run, and how far of it is seen of its punch, nm
const reachOf = ({ head: { flat, nodes, spacing }, reach: acting }) => (
  flat ? Math.min(100, (nodes / 2 - 1) * spacing) : Math.max(100, 50 * Math.ceil((acting * 1.05) / 50)))
const seen = ({ head: { flat, spacing } }, half) => (flat ? Math.min(half, SITES * spacing) : half)

// What stays the same while a run is played: ranges that hold all of its frames
export function fitFrames(run) {
  if (me.dragging) return
  const { punch } = charts, { flat } = run.head, half = run.apart ? reach.half : reachOf(run)
  const key = one(".flat"), others = !me.charted || key.hidden === flat
  key.hidden = !flat
  if (others) change() // other views are in sight
  const spare = flat || others ? 0 : TAIL
  const wide = settled(punch.x.end, seen(run, half), spare)
  reach.half = settled(reach.half, half, spare)
  punch.range("x", { start: -wide, end: wide })
  punch.range("y", { start: -settled(-punch.y.start, Math.max(DEEP, -1.15 * run.lowest)) })
  drawSites(run.head)
}
