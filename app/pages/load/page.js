// The page "Friction over load": the points of slips.js, coloured by the one parameter that changed before each.

import { set } from "../../static/js/bokeh.js"
import { ask } from "../../static/js/channel.js"
import { by, on } from "../../static/js/dom.js"
import { extent } from "../../static/js/curves.js"
import { figures, fill } from "../../static/js/figures.js"
import { digits, named, withUnit } from "../../static/js/quantities.js"
import { download } from "../../static/js/share.js"
import { addSwept, clear, collect, points } from "../../static/js/slips.js"
import { me } from "../../static/js/store.js"

const NAMED = ["delta_bar", "phi_ratio", "E"] // parameters that have a colour of their own, and name every point
const ROOM = 0.12 // of an axis, beyond the points
const ALONE = 0.05 // of the largest force of all points: the least room, also around one point
const FEWEST = 3 // points of one interface that have a line
const EMPTY = 100 // N/m, either way of an axis without points

const groupOf = ({ changed }) => (changed === null ? "several" : NAMED.includes(changed) ? changed : "another")

export function connect() {
  on("load-csv", "click", () => download(new Blob([csv()], { type: "text/csv" }), "-friction-over-load.csv"))
  on("load-clear", "click", () => { clear(); ask({ what: "clear" }); draw() })
}

export const opened = draw

export function frame(run) {
  collect(run)
  draw()
}

export function receive({ swept = [] }) {
  swept.forEach(addSwept)
  draw()
}

let drawn = "" // what the figure shows
function draw() {
  if (!figures.load_slips) return
  const key = JSON.stringify(me.run?.head.scene), now = points.find((point) => point.key === key)
  const state = `${figures.load_slips.id} ${points.map((point) => point.key)} ${key}`
  if (state === drawn) return
  drawn = state
  const groups = Object.groupBy(points, groupOf)
  for (const name of [...NAMED, "another", "several"]) show(name, groups[name] ?? [])
  show("mark now", now ? [now] : [])
  showLaw(me.run ? ofInterface(me.run.head.scene) : [])
  axis("x_range", "L")
  axis("y_range", "F")
  by("load-count").textContent = `${points.length} point${points.length === 1 ? "" : "s"}`
}

const interfaceOf = (scene) => JSON.stringify({ ...scene, delta_bar: 0, u_x_max: 0 })

// The points of a scene and of those that differ in the press depth only, by that depth
function ofInterface(scene) {
  const own = interfaceOf(scene)
  return points.filter((point) => interfaceOf(point.scene) === own)
    .toSorted((a, b) => a.scene.delta_bar - b.scene.delta_bar)
}

// The straight line through points by least squares: its slope, its F at L = 0, and the largest |F| by which it misses
export function straight(list) {
  const mean = (of) => list.reduce((sum, point) => sum + of(point), 0) / list.length
  const L = mean((point) => point.L), F = mean((point) => point.F)
  const spread = mean((point) => (point.L - L) ** 2)
  const slope = spread > 0 ? mean((point) => (point.L - L) * (point.F - F)) / spread : 0
  const offset = F - slope * L
  return { slope, offset, miss: Math.max(...list.map((point) => Math.abs(point.F - offset - slope * point.L))) }
}

// F at L = 0 between the first two successive points on either side of it; null where there are none
export function alone(list) {
  const after = list.findIndex((point, i) => i > 0 && point.L * list[i - 1].L <= 0 && point.L !== list[i - 1].L)
  if (after < 0) return null
  const [a, b] = [list[after - 1], list[after]]
  return a.F + (b.F - a.F) * a.L / (a.L - b.L)
}

// The points of one interface joined, the straight line through them, and both in words
function showLaw(list) {
  const enough = list.length >= FEWEST, { slope, offset, miss } = straight(list), held = alone(list)
  const ends = enough ? extent([0, ...list.map(({ L }) => L)]) : []
  fill("load_slips", "mark runs", columns(enough ? list : []))
  fill("load_slips", "mark line", { L: ends, F: ends.map((L) => offset + slope * L) })
  const line = `The straight line through ${list.length} runs, F = ${digits(slope)} L ${offset < 0 ? "−" : "+"} ${
    withUnit("F", Math.abs(offset))} (dotted), misses them by up to ${withUnit("F", miss)}.`
  const first = held === null ? "No run of these passes L = 0."
    : `At L = 0 adhesion alone holds with ${withUnit("F", held)}: friction is not proportional to load.`
  by("load-law").textContent = enough ? `${first} ${line}` : "Friction over load of this interface, in twelve runs."
}

const columns = (list) => ({ L: list.map(({ L }) => L), F: list.map(({ F }) => F) })
const show = (label, list) => fill("load_slips", label, { ...columns(list), label: list.map(labelOf) })

function axis(range, name) {
  const [low, high] = extent(points.map((point) => point[name]))
  const largest = Math.max(...points.flatMap(({ L, F }) => [Math.abs(L), Math.abs(F)]))
  const room = points.length ? Math.max(ROOM * (high - low), ALONE * largest) : EMPTY
  set(figures.load_slips[range], { start: low - room, end: high + room })
}

// The parameter that changed, and those with a slider; of a path through points also the stage of the slip
const labelOf = ({ changed, scene, stage }) => [stage ? `first slip of the path, in stage ${stage}` : [],
  ...[...new Set([changed ?? [], NAMED].flat())].map((name) => named(name, scene[name]))].flat().join(", ")

const cell = (given) => (typeof given === "number" ? given : `"${`${given ?? ""}`.replaceAll('"', '""')}"`)

function csv() {
  const names = Object.keys(points[0]?.scene ?? {})
  const rows = points.map(({ L, F, U, changed, scene }) => (
    [L, F, U, changed ?? "", ...names.map((name) => scene[name])].map(cell).join(",")))
  return [["L (N/m)", "F_s (N/m)", "U_s (nm)", "changed", ...names].join(","), ...rows, ""].join("\n")
}
