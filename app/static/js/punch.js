// The punch, its nodes and the tractions of a frame, and the ranges that hold all frames of a run.

import { set } from "./bokeh.js"
import { readAgain } from "./colours.js"
import { by } from "./dom.js"
import {
  CURVES, figures, figureShown, fill, fit, LEAST, overlays, parts, punches, setPunches, shareAxis,
} from "./figures.js"
import { declared, me } from "./state.js"

const BELOW = -1.2 // nm; a punch that goes deeper has a deeper view
const SITES = 5 // of a flat surface on either side of the middle: it is all alike

export function drawFrame(run, k) {
  const { x, T_n, T_t } = run.frame(k)
  const drawing = [["punch", run, k], ...overlays.punches(run, k)]
    .map(([view, of, at]) => ({ view, run: of, frame: of.frame(at) }))
  const lowest = drawing.map(({ frame }) => Math.min(...frame.gap))
  const top = Math.max(7, ...lowest.map((least) => least + 3)) // a punch still far away must be in view as well
  if (!me.dragging) setPunches("y_range", { end: top })
  for (const punch of drawing) drawPunch(punch, top)
  if (figureShown("traction")) {
    fill("traction", "T_n", { x, T: T_n })
    fill("traction", "T_t", { x, T: T_t })
  }
  const location = run.curves[run.part(run.approaching(k)).abscissa][k]
  for (const view of CURVES) set(parts[view].cursor, { location })
}

function drawPunch({ view, run, frame }, top) {
  const { x, gap, T_n, T_t } = frame, n = x.length
  const outline = { x: new Float32Array(2 * n), y: new Float32Array(2 * n) }
  for (let i = 0; i < n; i++) {
    outline.x[i] = outline.x[2 * n - 1 - i] = x[i]
    outline.y[i] = gap[i]
    outline.y[2 * n - 1 - i] = Math.max(top + 1, gap[i])
  }
  fill(view, "body", outline)
  fill(view, "surface", { x, gap })
  const found = Object.groupBy(x.keys(), frame.state)
  for (const label in declared.nodes) {
    const pick = (list) => Float32Array.from(found[label] ?? [], (i) => list[i])
    fill(view, label, { x: pick(x), gap: pick(gap), T_n: pick(T_n), T_t: pick(T_t) })
  }
  if (!run.head.flat || view !== "punch") return
  const { mark, said } = declared.nodes[frame.state(0)] // the key of the nodes of a flat surface, which are all alike
  by("flat-mark").className = mark
  by("flat-state").textContent = said
}

let sites = "" // how many are drawn on either side of the middle, and in which figures
function drawSites({ spacing, middle }) {
  const half = Math.ceil(figures.punch.x_range.end / spacing) + 2, wanted = [half, ...punches()].join()
  if (wanted === sites) return
  sites = wanted
  const first = Math.round(middle / spacing)
  const x = Float32Array.from({ length: 2 * half + 1 }, (_, j) => (first - half + j) * spacing - middle)
  for (const view of punches()) fill(view, "sites", { x, gap: x.map(() => 0) })
}

// How far from the middle the map of a run reaches, and its punch is seen, nm
const reach = ({ head: { flat, nodes, spacing }, reach: acting }) => (
  flat ? Math.min(100, (nodes / 2 - 1) * spacing) : Math.max(100, 50 * Math.ceil((acting * 1.05) / 50)))
const seen = (run) => (run.head.flat ? Math.min(reach(run), SITES * run.head.spacing) : reach(run))

// What stays the same while a run is played: ranges that hold all of its frames
export function fitFrames(run) {
  if (me.dragging || run.followed) return
  const { flat } = run.head, half = reach(run)
  const { dataset } = document.querySelector(".page"), others = dataset.flat !== `${flat}`
  dataset.flat = flat
  if (others) {
    readAgain() // other views are in sight
    shareAxis()
    for (const view of punches()) showGlyphs(view, !flat)
  }
  set(figures.map.y_range, { start: -half, end: half })
  const all = [run, ...overlays.punches(run, 0).map(([, of]) => of)], wide = Math.max(...all.map(seen))
  setPunches("x_range", { start: -wide, end: wide })
  setPunches("y_range", { start: Math.min(BELOW, ...all.map((of) => 1.15 * of.lowest)) })
  fit(figures.traction.y_range, Math.min(run.T_least, -LEAST), Math.max(run.T_most, LEAST))
  drawSites(run.head)
}

// The nodes of a flat surface are drawn by lens.js alone, enlarged
function showGlyphs(view, visible) {
  for (const part of Object.values(parts[view])) if (part.glyph) set(part, { visible })
}
