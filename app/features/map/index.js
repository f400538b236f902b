// The contact map: normal traction over place and path.

import { valueAt } from "../../static/js/chart.js"
import { addChart, charts, chartShown, CURVES, line, none } from "../../static/js/charts.js"
import { nice, pictureOf, shades } from "../../static/js/colours.js"
import { LEAST, settled, tellLimits, where } from "../../static/js/curves.js"
import { by } from "../../static/js/dom.js"
import { shown as shownNow } from "../../static/js/draw.js"
import { acts } from "../../static/js/frames.js"
import { connectChart } from "../../static/js/hover.js"
import { fixed } from "../../static/js/quantities.js"
import { reach } from "../../static/js/punch.js"
import { declare, frame, me, memory, touch } from "../../static/js/store.js"

const QUIET = 150 // ms between two drawings of a growing run: it needs the processor itself
const HELD = 250 // ms between two drawings while a slider is held: the curves come first
const changed = memory()
let drawnAt = 0, timer = 0 // ms, when it was drawn

export function connect() {
  declare({ mapped: true }) // whether the map is that of the run on screen
  CURVES.push("map")
  addChart("map", { x: { ...charts.area.x }, y: { start: -reach.half, end: reach.half }, across: charts.area.across,
    up: "x (nm)", parts: {
      map: { kind: "image", picture: null }, unrested: { kind: "stripes", list: [], ink: "--free" },
      branch: line("--text", { dash: [6, 4] }), // edges of the contact in other stages
      slips: { kind: "marks", marker: "diamond", size: 9, ink: "--slip", hollow: true, ...none },
      cursor: { kind: "upright", at: 0, ink: "--cursor", width: 1.5 },
    } })
  connectChart("map")
  charts.map.says = ({ x, y }) => {
    const { map } = charts.map.parts
    if (!map.picture) return null
    const T = valueAt(map, { x, y }), here = [where(x), `x = ${fixed(y, 0)} nm`]
    if (T === T) return [...here, `Tₙ = ${fixed(T, 3)} GPa`]
    return me.run.whole ? [...here, "free"] : here // what is not computed yet is not free
  }
  frame(["run", "at", "preview", "dragging", "following", "picture", "charted", "look"], draw)
}

// The map of the stage that the increment to show belongs to
function draw() {
  const { run, instead } = me, time = performance.now()
  if (instead || !(run?.sheared >= 0)) return
  const k = shownNow()
  if (changed(run, run.length, stageOfMap(run, k), reach.half, me.look)) me.mapped = false
  if (me.mapped) return
  const growing = run.whole ? 0 : QUIET, pause = me.dragging ? HELD : growing
  if (time - drawnAt < pause) return again(pause)
  drawnAt = time
  drawMap(run, k)
  me.mapped = true
}

function again(pause) {
  clearTimeout(timer)
  timer = setTimeout(() => touch("run"), pause)
}

function drawMap(run, shown) {
  if (!chartShown("map")) return
  charts.map.range("y", { start: -reach.half, end: reach.half })
  const { image: values, rows, columns, start, low, step, unrested } = tractionsOver(run, shown), chart = charts.map
  limitShades(run)
  const limits = [-ends[0], ends[1]], picture = pictureOf(values, [rows, columns], shades(...limits))
  chart.fill("map", { picture, limits, values, rows, columns,
    x: start - step / 2, y: low, wide: columns * step, high: rows * run.head.spacing })
  chart.fill("unrested", { list: unrested })
  by("unrested").hidden = !unrested.length
  const { U_x: x, x: y } = otherEdges(run, shown)
  chart.fill("branch", { x, y })
  by("branch").hidden = !y.some((place) => place === place)
  const [loads] = run.slips("F_bar", stageOfMap(run, shown), run.approaching(shown))
  chart.fill("slips", { x: loads, y: loads.map(() => 0.94 * chart.y.start) })
}

const ends = [0, 0] // GPa, at which the colours of the map end
function limitShades(run) {
  const needed = [-run.T_low, run.T_high].map((T) => nice(Math.max(T, LEAST)))
  needed.forEach((GPa, i) => { ends[i] = settled(ends[i], GPa) })
  tellLimits("map", -ends[0], ends[1])
}

// Normal traction (GPa) over place and displacement, of the stage of frame `shown`; free places and increments
// still to come are NaN
export function tractionsOver(run, shown) {
  const stage = stageOfMap(run, shown)
  const frames = run.frames((k) => (stage === null ? k >= run.sheared : run.curves.stage[k] === stage))
  const blocks = [...new Set(frames.map((k) => run.headOf(k)))]
  const from = Math.min(...blocks.map((head) => head.first))
  const to = Math.max(...blocks.map((head) => head.first + head.nodes))
  const approach = run.approaching(shown), [start, end] = run.extent(approach)
  const step = approach ? run.head.approach[2] : run.head.step, along = run.curves[run.part(approach).abscissa]
  const columns = Math.round((end - start) / step) + 1
  const rows = to - from
  const image = new Float32Array(rows * columns).fill(NaN)
  for (const k of frames) {
    const { head, of } = run.sent(k), { first, scales } = head, T_z = of("T_z")
    const c = Math.round((along[k] - start) / step)
    of("gap").forEach((gap, i) => {
      const value = T_z[i] * scales.T_z
      if (acts(head, value, gap * scales.gap)) image[(first - from + i) * columns + c] = value
    })
  }
  const low = (from - 0.5) * run.head.spacing - run.head.middle
  return { image, rows, columns, start, step, unrested: unrestedOf(run, frames, along, step), low }
}

// [middle, width] of every stretch of the path without a frame, for the surface never came to rest there
function unrestedOf(run, frames, along, step) {
  return frames.slice(1).flatMap((k, i) => {
    const [a, b] = [along[frames[i]], along[k]], missed = Math.abs(b - a) - step
    return missed > 0.6 * step && run.curves.slip[k] ? [[(a + b) / 2, missed]] : []
  })
}

// Edges of what is repelled (place along the path, x, nm) in stages that the map does not show: the other branches of
// a loop, each edge a line that ends with NaN
function otherEdges(run, shown) {
  const stage = stageOfMap(run, shown), { from, to, abscissa } = run.part(run.approaching(shown))
  const lines = { U_x: [], x: [] }, along = run.curves[abscissa]
  if (stage === null) return lines
  for (const other of new Set(run.curves.stage.slice(from, to))) {
    if (other === stage) continue
    const frames = run.frames((k) => k >= from && k < to && run.curves.stage[k] === other)
    for (const edge of run.edgesOver(frames)) {
      lines.U_x.push(...frames.map((k) => along[k]), NaN)
      lines.x.push(...edge, NaN)
    }
  }
  return lines
}

// The stage that the map shows; null: all after the approach, as a path never turns back
function stageOfMap(run, shown) {
  if (run.approaching(shown)) return 0
  if (run.head.abscissa === "path") return null
  return run.curves.stage[Math.max(shown, run.sheared)]
}
