// The punch, its nodes and the tractions of a frame, and the ranges that hold all frames of a run.

import { frameBox, set } from "./bokeh.js"
import { readAgain } from "./colours.js"
import { by } from "./dom.js"
import {
  CURVES, figures, fill, parts, settled, shareAxis,
} from "./figures.js"
import { declared, me, memory } from "./store.js"

const DEEP = 1.2 // nm below the sites that are in view; a punch that goes deeper has a deeper view
const TAIL = 0.2 // of what acts may lie out of sight, where attraction is weak, before the axis grows
const LARGER = 3 // times, at most, that a displacement sideways is drawn
const IN_SIGHT = 0.4 // of half of the view: the top is drawn to move by no more
const SITES = 5 // of a flat surface on either side of the middle: it is all alike

// By how much every displacement sideways is drawn larger, so that lean and slip are seen
export function sideways({ head, normal }) {
  if (head.flat) return 1
  const far = normal ? 0 : Math.max(...head.span.map(Math.abs)) // nm, what the top moves
  return Math.max(1, Math.min(LARGER, Math.floor((IN_SIGHT * figures.punch.x_range.end) / far)))
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
  if (!me.dragging) set(figures.punch.y_range, { end: top })
  drawPunch(run, frame, top)
  const location = run.curves[run.part(run.approaching(k)).abscissa][k]
  for (const view of CURVES) set(parts[view].cursor, { location })
}

function drawPunch(run, frame, top) {
  const { x: at, drawn: x, gap, T_n, T_t } = frame, n = x.length
  const outline = { x: new Float32Array(2 * n), y: new Float32Array(2 * n) }
  for (let i = 0; i < n; i++) {
    outline.x[i] = outline.x[2 * n - 1 - i] = x[i]
    outline.y[i] = gap[i]
    outline.y[2 * n - 1 - i] = Math.max(top + 1, gap[i])
  }
  fill("punch", "body", outline)
  fill("punch", "surface", { x, gap })
  const groups = Object.groupBy(x.keys(), frame.state)
  for (const label in declared.nodes) {
    const pick = (list) => Float32Array.from(groups[label] ?? [], (i) => list[i])
    fill("punch", label, { x: pick(x), at: pick(at), gap: pick(gap), T_n: pick(T_n), T_t: pick(T_t) })
  }
  if (!run.head.flat) return
  const { mark, label } = declared.nodes[frame.state(0)] // the key of the nodes of a flat surface, which are all alike
  by("flat-mark").className = mark
  by("flat-state").textContent = label
}

// The sites of the lattice: a line of dashes, which is quicker to paint than hundreds of marks
const SITE = 2.5 // px
const sites = memory()
function drawSites({ spacing, middle }) {
  const box = frameBox(figures.punch), half = Math.ceil(figures.punch.x_range.end / spacing) + 2
  if (!box || !sites(half, spacing, middle, box.across, me.look)) return
  const first = (Math.round(middle / spacing) - half) * spacing - middle - SITE / 2 / box.across
  fill("punch", "sites", { x: [first, first + 2 * half * spacing + SITE / box.across], gap: [0, 0] })
  set(parts.punch.sites.glyph, { line_width: SITE, line_dash: [SITE, spacing * box.across - SITE] })
}

// How far from the middle the map of a run reaches, and its punch is seen, nm
const reach = ({ head: { flat, nodes, spacing }, reach: acting }) => (
  flat ? Math.min(100, (nodes / 2 - 1) * spacing) : Math.max(100, 50 * Math.ceil((acting * 1.05) / 50)))
const seen = ({ head: { flat, spacing } }, half) => (flat ? Math.min(half, SITES * spacing) : half)

// What stays the same while a run is played: ranges that hold all of its frames
export function fitFrames(run) {
  if (me.dragging) return
  const { map, punch } = figures, { flat } = run.head, half = run.apart ? map.y_range.end : reach(run)
  const { dataset } = document.querySelector(".page"), others = dataset.flat !== `${flat}`
  dataset.flat = flat
  if (others) {
    readAgain() // other views are in sight
    shareAxis()
    for (const part of Object.values(parts.punch)) if (part.glyph) set(part, { visible: !flat }) // lens.js draws a flat
  }
  const spare = flat || others ? 0 : TAIL
  const wide = settled(punch.x_range.end, seen(run, half), spare), tall = settled(map.y_range.end, half, spare)
  set(map.y_range, { start: -tall, end: tall })
  set(punch.x_range, { start: -wide, end: wide })
  set(punch.y_range, { start: -settled(-punch.y_range.start, Math.max(DEEP, -1.15 * run.lowest)) })
  drawSites(run.head)
}
