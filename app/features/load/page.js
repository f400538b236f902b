// The page "Friction over load": the points of slips.js, coloured by the one parameter that changed before each.

import { addChart, charts, line, marksOf } from "../../static/js/charts.js"
import { by, download, on } from "../../static/js/dom.js"
import { extent } from "../../static/js/curves.js"
import { digits, named, withUnit } from "../../static/js/quantities.js"
import { addSwept, clear, points } from "./slips.js"
import { declared, me, memory, redrawPunch } from "../../static/js/store.js"
import { ask } from "../pages/index.js"

const NAMED = ["delta_bar", "phi_ratio", "E"] // parameters that have a colour of their own, and name every point
const ROOM = 0.12 // of an axis, beyond the points
const ALONE = 0.05 // of the largest force of all points: the least room, also around one point
const FEWEST = 3 // points of one interface that have a line
const EMPTY = 100 // N/m, either way of an axis without points

const NEAR = 14 // px, from the mouse to a point that it points at

const groupOf = ({ changed }) => (changed === null ? "several" : NAMED.includes(changed) ? changed : "another")

export function connect() {
  addChart("load_slips", { x: { start: -EMPTY, end: EMPTY }, y: { start: -EMPTY, end: EMPTY }, across: "load L (N/m)",
    up: "friction Fₛ (N/m)", parts: {
      zero: { kind: "across", ink: "--grid" },
      unloaded: { kind: "upright", at: 0, ink: "--text", width: 2, dash: [6, 4] },
      runs: line("--repulsive", { width: 1.5 }), law: line("--text", { width: 2, dash: [2, 4] }),
      now: { kind: "marks", marker: "circle", size: 18, hollow: true, ink: "--cursor", x: [], y: [] },
      ...marksOf(declared.changes),
    } })
  charts.load_slips.says = says
  on("load-csv", "click", () => download(new Blob([csv()], { type: "text/csv" }), "-friction-over-load.csv"))
  on("load-clear", "click", () => {
    clear()
    cleared = sweep
    ask({ what: "clear" })
    draw()
    redrawPunch()
  })
}

let sweep = null, cleared = null // numbers of the sweep on its way, and of one whose points are not wanted any more

export function receive(news) {
  sweep = news.sweep ?? null
  if (sweep === null || sweep !== cleared) (news.swept ?? []).forEach(addSwept)
  if (sweep !== cleared) cleared = null
  draw()
}

const drawn = memory() // what the chart shows
export const frame = () => draw()
function draw() {
  const key = JSON.stringify(me.run?.head.scene), now = points.find((point) => point.key === key)
  if (!drawn(`${points.map((point) => point.key)} ${key}`)) return
  const groups = Object.groupBy(points, groupOf)
  for (const name in declared.changes) show(name, groups[name] ?? [])
  show("now", now ? [now] : [])
  showLaw(me.run ? ofInterface(me.run.head.scene) : [])
  fit("x", "L")
  fit("y", "F")
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
  show("runs", enough ? list : [])
  charts.load_slips.fill("law", { x: ends, y: ends.map((L) => offset + slope * L) })
  const law = `The straight line through ${list.length} runs, F = ${digits(slope)} L ${offset < 0 ? "−" : "+"} ${
    withUnit("F", Math.abs(offset))} (dotted), misses them by up to ${withUnit("F", miss)}.`
  const first = held === null ? "No run of these passes L = 0."
    : `At L = 0 adhesion alone holds with ${withUnit("F", held)}: friction is not proportional to load.`
  by("load-law").textContent = enough ? `${first} ${law}` : "Friction over load of this interface, in twelve runs."
}

const show = (part, list) => charts.load_slips.fill(part, { x: list.map(({ L }) => L), y: list.map(({ F }) => F) })

// The point that the mouse points at
function says(_, { x, y }) {
  const { X, Y } = charts.load_slips.box, away = points.map(({ L, F }) => Math.hypot(X(L) - x, Y(F) - y))
  const i = away.indexOf(Math.min(...away))
  if (!(away[i] < NEAR)) return null
  return [...labelOf(points[i]).split(", "), named("L", points[i].L), named("F_s", points[i].F)]
}

function fit(axis, name) {
  const [low, high] = extent(points.map((point) => point[name]))
  const largest = Math.max(...points.flatMap(({ L, F }) => [Math.abs(L), Math.abs(F)]))
  const room = points.length ? Math.max(ROOM * (high - low), ALONE * largest) : EMPTY
  charts.load_slips.range(axis, { start: low - room, end: high + room })
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
