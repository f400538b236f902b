// The charts of the experiment: the punch, forces and area over the path. Features add theirs.

import { Chart } from "./chart.js"
import { isShown, readAgain } from "./colours.js"
import { by, one, root } from "./dom.js"

export const CURVES = ["forces", "area"] // over the path; features may add one
export const charts = {} // {name: Chart}
globalThis.charts ??= charts // for the console, and for tests
root.charts = charts
export const DASHED = [6, 4]
const SLIP = { kind: "marks", marker: "diamond", size: 9, ink: "--slip", hollow: true } // hollow: peaks stay visible
export const none = { x: [], y: [] }
// A further part of a chart, painted before the one named `before`, else last
export function addPart(chart, name, part, before = null) {
  const parts = Object.entries(charts[chart].parts), at = parts.findIndex(([other]) => other === before)
  parts.splice(at < 0 ? parts.length : at, 0, [name, part])
  charts[chart].parts = Object.fromEntries(parts)
}
export const line = (ink, more) => ({ kind: "line", ink, ...none, ...more })
const cursor = () => ({ kind: "upright", at: 0, ink: "--cursor", width: 1.5 })
const drawing = () => ({ kind: "drawing", draw: () => {} })
const ways = () => ({ kind: "marks", marker: "right", size: 11, ink: "--text", ...none }) // heads along a curve

// {name: marks, which are none yet} of declared ones, the most important of which is first there, and painted last
export const marksOf = (declared) => Object.fromEntries(Object.entries(declared).toReversed().map(
  ([name, { mark, marker, size, colour }]) => (
    [name, { kind: "marks", marker, size, hollow: mark === "slip", ink: colour, ...none }])))

export function addChart(name, made) {
  charts[name] = new Chart(one(`.view[data-view="${name}"]`), made)
}

// nodes: {state: how it is drawn}
export function makeCharts(nodes) {
  const place = { start: -250, end: 250 }, path = { start: 0, end: 40 }
  addChart("punch", { x: { ...place }, y: { start: -1.2, end: 7 },
    across: "x on the substrate, from the middle (nm)", up: "height (nm)", parts: {
      substrate: { kind: "below", ink: "--text", alpha: 0.12 },
      body: { kind: "body", ink: "--body", alpha: 0.25, ...none }, surface: line("--body"),
      sites: line("--text", { width: 2.5 }), ...marksOf(nodes),
      story: drawing(),
    } })
  addChart("forces", { x: { ...path }, y: { start: -1, end: 2 },
    across: "", up: "F, L (N/m)", parts: {
      zero: { kind: "across", ink: "--grid" },
      ghost_F: line("--ghost", { width: 3 }), ghost_L: line("--ghost", { width: 3, dash: DASHED }),
      F: line("--shear", { width: 2 }), L: line("--normal", { width: 2, dash: DASHED }),
      slips: { ...SLIP, ...none }, ways: ways(), cursor: cursor(),
    } })
  addChart("area", { x: { ...path }, y: { start: 0, end: 100 }, across: "", up: "A (nm)", parts: {
    ghost_A: line("--ghost", { width: 3 }), A: line("--area", { width: 2 }),
    slips: { ...SLIP, ...none }, ways: ways(), cursor: cursor(),
  } })
}

// Whether one that is in sight is to be painted
export const chartsWait = () => Object.values(charts).some(({ changed, view: of }) => changed && isShown(of))

export const paintCharts = () => { for (const name in charts) charts[name].paint() }

// What is not in sight is not drawn
export const chartShown = (name) => isShown(charts[name].view)

// All charts again: colours, sizes or what is in sight have changed. Curves that stand above each other share the
// lowest's axis; the punch that of the tractions under it
export function change() {
  readAgain()
  const stacked = CURVES.filter(chartShown)
  for (const name of stacked) charts[name].axis = name === stacked.at(-1)
  charts.punch.axis = !isShown(by("bands"))
  for (const name in charts) charts[name].changed = true
}
