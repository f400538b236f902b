// The page "Friction over load": the points of slips.js, coloured by the one parameter that changed before each.

import { set } from "../../static/js/bokeh.js"
import { by, on } from "../../static/js/dom.js"
import { extent, figures, fill } from "../../static/js/figures.js"
import { named } from "../../static/js/quantities.js"
import { download } from "../../static/js/share.js"
import { clear, collect, points } from "../../static/js/slips.js"
import { me } from "../../static/js/store.js"

const NAMED = ["delta_bar", "phi_ratio", "E"] // parameters that have a colour of their own, and name every point
const ROOM = 0.08 // of an axis, beyond the points
const ALONE = 0.05 // of the largest force of all points: the least room, also around one point
const EMPTY = 100 // N/m, either way of an axis without points

const groupOf = ({ changed }) => (changed === null ? "several" : NAMED.includes(changed) ? changed : "another")

export function connect() {
  on("load-csv", "click", () => download(new Blob([csv()], { type: "text/csv" }), "-friction-over-load.csv"))
  on("load-clear", "click", () => { clear(); draw() })
}

export const opened = draw

export function frame(run) {
  collect(run)
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
  axis("x_range", "L")
  axis("y_range", "F")
  by("load-count").textContent = `${points.length} point${points.length === 1 ? "" : "s"}`
}

const show = (label, list) => fill("load_slips", label,
  { L: list.map(({ L }) => L), F: list.map(({ F }) => F), label: list.map(labelOf) })

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
