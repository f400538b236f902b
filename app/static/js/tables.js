// What a plot shows as a table, built from the frames that are here; loaded when one is opened.

import { drawnBy } from "./bokeh.js"
import { by, make, makeRow } from "./dom.js"
import { figures, parts } from "./figures.js"
import { digits, fixed } from "./quantities.js"
import { me } from "./store.js"

// A number in some four digits
const short = (value) => (Number.isFinite(value) ? digits(value, 4) : "–")

// title, headings and rows of a plot of a run, at frame k where it shows one
const TABLES = {
  punch: (run, k) => nodes(run, k),
  forces: (run) => increments(run, "Forces", ["friction F (N/m)", "load L (N/m)"],
    ({ F, L }) => [short(F), short(L)]),
  area: (run) => increments(run, "Contact area", ["A (nm)", "A / w (10⁻³)"],
    ({ A, A_bar }) => [short(A), short(A_bar * 1000)]),
  map: (run) =>
  increments(run, "Contact map", ["acts from x (nm)", "to (nm)", "repulsive nodes", "adhering nodes"], acting),
}

function nodes(run, k) {
  const { x, gap, T_n, T_t, state } = run.frame(k)
  return {
    title: `Surface nodes at Uₓ = ${fixed(run.values(k).U_x, 1)} nm`,
    headings: ["x (nm)", "height (nm)", "state", "normal Tₙ (GPa)", "tangential Tₜ (GPa)"],
    rows: Array.from(x, (at, i) => [fixed(at, 1), fixed(gap[i], 3), state(i), fixed(T_n[i], 4), fixed(T_t[i], 4)]),
  }
}

function increments(run, title, headings, cells) {
  const rows = [], driven = run.driven && !run.normal
  for (let k = Math.max(0, run.sheared); k < run.length; k++) {
    const v = run.values(k)
    const top = driven ? [fixed(run.top(k), 2)] : []
    rows.push([run.leg(k), fixed(run.along[k], 2), ...top, ...cells(v, run, k), v.slip ? "slip" : ""])
  }
  const path = { delta: "δ (nm)", U_x: "Uₓ (nm)", path: "path (nm)" }[run.head.abscissa]
  const along = [path, ...(driven ? ["Uₓ of the top (nm)"] : [])]
  return { title, headings: ["stage", ...along, ...headings, "slip"], rows }
}

// Where anything acts in a frame, in places of the undeformed punch
function acting(values, run, k) {
  const { first, spacing, middle } = run.headOf(k), frame = run.frame(k)
  const states = Array.from(frame.gap, (_, i) => frame.state(i))
  const count = (...of) => states.filter((state) => of.includes(state)).length
  const ends = [states.findIndex((state) => state !== "free"), states.findLastIndex((state) => state !== "free")]
  const places = ends.map((i) => (i < 0 ? "–" : fixed((first + i) * spacing - middle, 1)))
  return [...places, count("repulsive", "contact"), count("adhering")]
}

// Opened with a button in the caption of the plot
export function openTable({ dataset: { view }, parentElement: caption }) {
  if (!(view in TABLES)) openData(view, caption.querySelector("b").textContent)
  else if (me.run?.length)
    open(TABLES[view](me.run, Math.max(0, Math.min(me.drawn, me.run.length - 1))))
}

const GRID = [9, 9] // values of an image in its table, across and down
const UNSAID = /^(zero$|way |mark )/ // lines that only guide the eye, and dots that are named beside them
const SAID = { // what is drawn on a page, where its label is not what it is called
  own: "on screen", stick: "nodes that stick", slip: "nodes past the peak",
  open: "free nodes",
  delta_bar: "press depth", phi_ratio: "friction to adhesion", E: "stiffness", another: "another parameter",
  several: "another experiment", law: "all sites", spring: "one spring", field: "stress",
}
const called = (label) => SAID[label] ?? label

// All that a figure of a page shows: points of curves and dots, and of an image values on a grid
function openData(name, title) {
  if (!(name in figures)) return
  const { below: [across], left: [up] } = figures[name], rows = []
  for (const [label, part] of Object.entries(parts[name])) {
    const drawn = UNSAID.test(label) ? null : drawnBy(part)
    if (drawn?.image) rows.push(...grid(drawn).map((cells) => [called(label), ...cells]))
    else for (let i = 0; i < (drawn?.x.length ?? 0); i++)
      rows.push([called(label), short(drawn.x[i]), short(drawn.y[i]), drawn.labels?.[i] ?? ""])
  }
  const valued = rows.some((cells) => cells[3])
  const headings = ["what", across.axis_label, up.axis_label, ...(valued ? ["value"] : [])]
  open({ title, headings, rows: valued ? rows : rows.map((cells) => cells.slice(0, 3)) })
}

function grid({ image, rows, columns, x, y, dw, dh }) {
  const cells = []
  for (let r = 0; r < GRID[1]; r++) {
    for (let c = 0; c < GRID[0]; c++) {
      const i = Math.floor(((r + 0.5) * rows) / GRID[1]), j = Math.floor(((c + 0.5) * columns) / GRID[0])
      cells.push([short(x + ((j + 0.5) * dw) / columns), short(y + ((i + 0.5) * dh) / rows),
        short(image[i * columns + j])])
    }
  }
  return cells
}

function open({ title, headings, rows }) {
  const head = make("tr", {}, ...headings.map((text) => make("th", { scope: "col" }, text)))
  const table = make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows.map(makeRow)))
  by("table-title").textContent = title
  by("table").querySelector(".rows").replaceChildren(table)
  by("table").showModal()
}
