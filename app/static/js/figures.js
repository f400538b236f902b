// The figures: frames and curves into their sources. Nothing here reaches the server.

import { fill as fillRenderer, image as imageFor, isDrawn, namedParts, paintedTogether, plain, set, stretch, thicken, tint } from "./bokeh.js"
import { colour, nice, shades, theme } from "./colours.js"
import { by, minus, say } from "./dom.js"
import { drawSketches, put, wipe } from "./sketch.js"
import { me } from "./state.js"
import { explain } from "./terms.js"
import { symbol as symbolOf } from "./truth.js"
import { forceUnit, tellStart } from "./units.js"

export const figures = {} // name: Bokeh figure, also those of a page that is open
export const parts = {} // figure: {label: what is drawn in it}
let states = {} // state of a node: {mark, said} (app/schema.py)
const BELOW = -1.2 // nm; a punch that goes deeper has a deeper view
const LEAST = 0.05 // GPa; weaker traction is not blown up to fill a view
const NARROW = 0.5 // of the largest area: where it stays above, the axis does not begin at zero
const SIGHT = 0.5 // of a curve must be in sight while a slider is held; an axis that cannot stay gets room for as much again
const TO_SCALE = 0.02 // a difference that nobody sees
const SITES = 5 // of a flat surface on either side of the middle: it is all alike
const THICK = 2.5 // times, for a projector
const LONG = 11 // times the size of the text: as high as a view must be for a long title of its axis
const STRETCHED = ["punch", "solid_field"] // whose vertical exaggeration is told

export function adopt(name, figure) {
  figures[name] = figure
  parts[name] = namedParts(figure)
}

export function useNodes(given) {
  states = Object.fromEntries(Object.entries(plain(given)).map(([state, node]) => [state, plain(node)]))
}

export function forget(name) {
  delete figures[name]
  delete parts[name]
}

// While a hand moves a slider: of these views what changes is sketched, the run before stays, and the rest is not drawn
const SKETCHED = ["forces", "area", "map", "traction", "punch"]
const STAYS = /^(ghost_|pins$|sites$)/, GOES = /^(ways|unrested|branch)$/ // of these, what stays; what no picture has
let sketching = false, hidden = false
const fresh = new Set() // views whose sketches are over

export function fill(view, label, columns) {
  const part = parts[view][label], sketched = SKETCHED.includes(view)
  if (sketching && sketched && !label.startsWith("ghost_")) {
    if (!STAYS.test(label) && !GOES.test(label)) put(view, label, columns)
    return
  }
  if (sketched && part.visible === false) {
    set(part, { visible: true })
    fresh.add(view)
  }
  fillRenderer(part, columns)
}

// Sketch from now on, or let Bokeh draw again
export function sketch(on) {
  sketching = on
  hidden = hidden && on
}

function hide() {
  hidden = true
  for (const view of SKETCHED) {
    for (const label in parts[view]) if (parts[view][label].glyph && !STAYS.test(label)) set(parts[view][label], { visible: false })
  }
}

export const fillImage = (view, label, values, shape, place) => {
  fill(view, label, { image: imageFor(parts[view][label], values, shape), ...place })
}
export async function painted(change) {
  if (sketching && hidden) change()
  else await paintedTogether(Object.values(figures), () => { if (sketching) hide(); change() })
  drawSketches(figures, parts)
  for (const view of fresh) wipe(view)
  fresh.clear()
}
export const drawn = (names) => names.every((name) => isDrawn(figures[name]))

// A range that holds low..high with room, half of it at least, so that marks at the ends are whole; it follows at once when
// too small, and shrinks only when far too large
function fit(range, low, high, curves = [[low, high]], room = 0.08) {
  const size = Math.max(high - low, 1e-9), least = 0.5 * room * size
  if (me.dragging) { // what moves is seen against what stays, unless most of a curve is out of sight
    const { start, end } = range, lost = ([a, b]) => Math.min(b, end) - Math.max(a, start) < SIGHT * (b - a)
    if (curves.some(lost)) set(range, { start: Math.min(start, low - SIGHT * size), end: Math.max(end, high + SIGHT * size) })
    return
  }
  const inside = low - least >= range.start && high + least <= range.end
  if (inside && size > 0.6 * (range.end - range.start)) return
  set(range, { start: low - room * size, end: high + room * size })
}

// [lowest, highest] of all numbers, and zero
export const extent = (...lists) => lists.reduce(([a, b], list) => {
  for (const v of list) { if (v < a) a = v; if (v > b) b = v }
  return [a, b]
}, [0, 0])

// What is drawn of other runs: values of their curves, for the ranges; what draws these; punches as [figure, run, frame];
// whether a run is among these
export const overlays = { curves: () => [], drawn: () => {}, punches: () => [], has: () => false }
let drawnGhost = null, drawnUnit = "F, L (N/m)", drawnApproach = false
const NOTHING = { along: [], value: [] }
export function drawCurves(run, ghost, approach) {
  const part = (of, name, factor) => of?.drawn(name, approach, factor) ?? NOTHING
  const curve = (...asked) => { const { along, value } = part(...asked); return { U_x: along, value } }
  if (ghost?.head.abscissa !== run.head.abscissa || overlays.has(ghost)) ghost = null // along something else, or drawn already
  const unit = forceUnit([run, ghost]), { F, L } = unit.names
  const same = ghost === drawnGhost && labelOf(unit) === drawnUnit && approach === drawnApproach
  for (const [view, label, name, factor] of [["forces", "F", F, unit.factor], ["forces", "L", L, unit.factor], ["area", "A", "A", 1]]) {
    if (!same) fill(view, `ghost_${label}`, curve(ghost, name, factor))
    fill(view, label, curve(run, name, factor))
  }
  if (labelOf(unit) !== drawnUnit) nameForces(unit)
  drawnGhost = ghost
  document.querySelector(".page").dataset.ghost = ghost !== null
  nameGhost(run, ghost)
  drawnUnit = labelOf(unit)
  drawnApproach = approach
  for (const [view, label, name, factor] of [["forces", "slips_F", run.normal || approach ? L : F, unit.factor], ["area", "slips_A", "A", 1]]) {
    const [U_x, value] = run.slips(name, factor, null, approach)
    fill(view, label, { U_x, value })
  }
  const [start, end] = run.extent(approach), room = start < end ? 0 : 1 // nm, where nothing is walked
  set(figures.forces.x_range, { start: start - room, end: end + room })
  nameAxis(run.normal || approach)
  pointAlong(run, "forces", run.curves[run.normal ? L : F], unit.factor)
  pointAlong(run, "area", run.curves.A, 1)
  say("apart", run.apart ? "Too far apart to hold on: what still acts is less than a tenth of the strongest attraction. Press the punch farther down." : "")
  const shown = (name, factor) => [...[run, ghost].map((of) => part(of, name, factor).value), ...overlays.curves(run, part, name, factor)]
  const moving = [[F, unit.factor], [L, unit.factor]].map(([name, factor]) => Array.from(part(run, name, factor).value))
  const bounds = moving.filter((list) => list.length).map((list) => [Math.min(...list), Math.max(...list)])
  fit(figures.forces.y_range, ...extent([-0.01, 0.02], ...shown(F, unit.factor), ...shown(L, unit.factor)), bounds)
  const areas = shown("A", 1).flatMap((list) => [...list]), least = Math.min(...areas), most = Math.max(...areas, run.head.spacing)
  const from = least > NARROW * most ? least : 0 // a few per cent of peeling must be seen
  overlays.drawn(run, part, unit, approach)
  fit(figures.area.y_range, from, most)
  tellStart(from && figures.area.y_range.start)
}

const NAMED = 2 // parameters at most

// What the run before was computed with, where that is another scene
function nameGhost({ scene }, ghost) {
  const names = scene && ghost?.scene ? Object.keys(scene).filter((name) => scene[name] !== ghost.scene[name]) : []
  const values = names.map((name) => `${symbolOf(name)} = ${minus(ghost.scene[name])}`).join(", ")
  const text = names.length && names.length <= NAMED ? `before: ${values}` : "before"
  for (const key of document.querySelectorAll(".key .ghost span")) if (key.textContent !== text) key.textContent = text
}

// Which way each part of a loop is walked: heads of arrows at its thirds
function pointAlong(run, view, value, factor) {
  const heads = { U_x: [], value: [], angle: [] }, along = run.along
  const stages = run.normal || run.head.span[0] < 0 ? [...new Set(run.curves.stage)].filter((stage) => stage > 0) : []
  for (const stage of stages) {
    const first = run.curves.stage.indexOf(stage), last = run.curves.stage.lastIndexOf(stage)
    for (const part of [1 / 3, 2 / 3]) {
      const k = Math.round(first + part * (last - first))
      if (along[last] === along[first]) continue
      heads.U_x.push(along[k])
      heads.value.push(value[k] * factor)
      heads.angle.push(along[last] > along[first] ? -Math.PI / 2 : Math.PI / 2)
    }
  }
  fill(view, "ways", heads)
}

// The unit of forces, on the axis and beside the mouse
const labelOf = ({ symbols, text, over = "" }) => `${symbols.F}, ${symbols.L} (${text}${over})`
function nameForces(unit) {
  const { symbols, text } = unit
  set(figures.forces.left[0], { axis_label: labelOf(unit) })
  for (const tool of figures.forces.toolbar.tools) {
    const [where, [symbol]] = tool.tooltips, name = symbol.startsWith("F") ? "F" : "L"
    set(tool, { tooltips: [where, [symbols[name], `@value{0.000} ${text}`]] })
  }
}

// Curves are drawn along U_x, or along delta
let named = false
function nameAxis(normal) {
  if (normal === named) return
  named = normal
  const [first, second] = document.querySelectorAll(".slips"), event = normal ? "jump" : "slip"
  explain(first, event)
  second.textContent = event
  const [symbol, label] = normal ? ["δ", "indentation δ (nm)"] : ["Uₓ", "displacement of the top Uₓ (nm)"]
  for (const view of ["forces", "area", "map"]) {
    set(figures[view].below[0], { axis_label: label })
    for (const tool of figures[view].toolbar.tools) {
      if (tool.tooltips?.[0]) set(tool, { tooltips: [[symbol, tool.tooltips[0][1]], ...tool.tooltips.slice(1)] })
    }
  }
}

// The limits of the colours of a view, in its key
export function tellLimits(view, low, high) {
  by(`${view}-low`).textContent = minus(Number(low.toPrecision(2)))
  by(`${view}-high`).textContent = `+${Number(high.toPrecision(2))} GPa`
}

export function drawMap(run, shown) {
  if (run.sheared < 0) return
  const { image, rows, columns, start, low, step, unrested } = run.map(shown), { spacing } = run.head
  fillImage("map", "map", image, [rows, columns],
    { x: [start - step / 2], y: [low], dw: [columns * step], dh: [rows * spacing] })
  shadeMap(run)
  const bottom = unrested.map(() => low), top = unrested.map(() => low + rows * spacing)
  fill("map", "unrested", { x: unrested.map(([x]) => x), width: unrested.map(([, width]) => width), bottom, top })
  by("unrested").hidden = !unrested.length
  fill("map", "branch", run.otherEdges(shown))
  const [U_x] = run.slips("F_bar", 1, run.stageOfMap(shown), run.approaching(shown))
  fill("map", "slips_map", { U_x, x: U_x.map(() => 0.94 * figures.map.y_range.start) })
}

export function shadeMap(run) {
  if (run?.sheared >= 0) shade("map", "map", -nice(Math.max(-run.T_low, LEAST)), nice(Math.max(run.T_high, LEAST)))
}

// Colours of an image for its limits, unless it has them
const shaded = {} // "view.label": for which limits, theme and mapper it has its shades
export function shade(view, label, low, high) {
  const mapper = parts[view]?.[label]?.glyph.color_mapper
  const key = [low, high, theme(), mapper?.id].join()
  if (!mapper || shaded[`${view}.${label}`] === key) return
  shaded[`${view}.${label}`] = key
  set(mapper, shades(low, high))
  tellLimits(view, low, high)
}

// Ranges of all punches, which are the same
const setPunches = (which, values) => {
  for (const view of ["punch", "twin"]) if (figures[view]) set(figures[view][which], values)
}

export function drawFrame(run, k) {
  const { x, T_n, T_t } = run.frame(k)
  const punches = [["punch", run, k], ...overlays.punches(run, k)].map(([view, of, at]) => ({ view, run: of, frame: of.frame(at) }))
  const lowest = punches.map(({ frame }) => frame.gap.reduce((a, b) => Math.min(a, b)))
  const top = Math.max(7, ...lowest.map((least) => least + 3)) // a punch still far away must be in view as well
  if (!me.dragging) setPunches("y_range", { end: top })
  for (const punch of punches) drawPunch(punch, top)
  if (figureShown("traction")) {
    fill("traction", "T_n", { x, T: T_n })
    fill("traction", "T_t", { x, T: T_t })
  }
  for (const view of ["forces", "area", "map"]) set(parts[view].cursor, { location: run.curves[run.part(run.approaching(k)).abscissa][k] })
}

// What is not in sight is not drawn
const figureShown = (view) => document.querySelector(`.view[data-view="${view}"]`).checkVisibility()

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
  const found = Object.fromEntries(Object.keys(states).map((state) => [state, []]))
  for (let i = 0; i < n; i++) found[frame.state(i)].push(i)
  if (run.head.flat && view === "punch") tellFlat(states[frame.state(0)])
  for (const label in found) {
    const pick = (list) => Float32Array.from(found[label], (i) => list[i])
    fill(view, label, { x: pick(x), gap: pick(gap), T_n: pick(T_n), T_t: pick(T_t) })
  }
}

// The key of the nodes of a flat surface, which are all alike
function tellFlat({ mark, said }) {
  by("flat-mark").className = mark
  by("flat-state").textContent = said
}

let sites = "" // how many are drawn on either side of the middle, and whether in two figures
function drawSites({ spacing, middle }) {
  const half = Math.ceil(figures.punch.x_range.end / spacing) + 2
  if (`${half} ${"twin" in figures}` === sites) return
  sites = `${half} ${"twin" in figures}`
  const first = Math.round(middle / spacing)
  const x = Float32Array.from({ length: 2 * half + 1 }, (_, j) => (first - half + j) * spacing - middle)
  for (const view of ["punch", "twin"]) if (figures[view]) fill(view, "sites", { x, gap: x.map(() => 0) })
}

// How far from the middle the map of a run reaches, and its punch is seen, nm
const reach = ({ head: { flat, nodes, spacing }, reach: acting }) => (flat ? Math.min(100, (nodes / 2 - 1) * spacing) : Math.max(100, 50 * Math.ceil((acting * 1.05) / 50)))
const seen = (run) => (run.head.flat ? Math.min(reach(run), SITES * run.head.spacing) : reach(run))

// What stays the same while a run is played: ranges that hold all of its frames
export function fitFrames(run) {
  if (me.dragging || run.followed) return
  const { flat } = run.head, half = reach(run)
  document.querySelector(".page").dataset.flat = flat
  set(figures.map.y_range, { start: -half, end: half })
  const punches = [run, ...overlays.punches(run, 0).map(([, of]) => of)]
  const wide = Math.max(...punches.map(seen))
  setPunches("x_range", { start: -wide, end: wide })
  setPunches("y_range", { start: Math.min(BELOW, ...punches.map((of) => 1.15 * of.lowest)) })
  fit(figures.traction.y_range, Math.min(run.T_least, -LEAST), Math.max(run.T_most, LEAST))
  drawSites(run.head)
}

// The vertical exaggerations as they are on this screen now
export function tellStretch() {
  for (const view of STRETCHED) {
    const times = stretch(figures[view])
    if (times === null) continue
    const text = Math.abs(times - 1) < TO_SCALE ? "to scale" : `vertical ×${Number(times.toPrecision(2))}`
    if (by(`${view}-stretch`).textContent !== text) by(`${view}-stretch`).textContent = text
  }
}

let written = 0 // px of the text in figures, as it was told
export function rewrite() { // another size of screen, another size of text
  if (parseFloat(colour("--plot-text")) !== written) paint()
  else { namePlace(); shareAxis() }
}

// Figures are drawn on a canvas and must be told the colours: of what is drawn, the one its tag names
export function paint() {
  const text = colour("--text"), soft = colour("--soft"), grid = colour("--grid")
  const size = written = parseFloat(colour("--plot-text")), large = size > 15 // for a projector
  for (const name in figures) {
    const figure = figures[name]
    set(figure, { outline_line_color: grid, min_border_right: large ? 34 : 14 })
    for (const axis of [...figure.below, ...figure.left]) {
      set(axis, { axis_label_text_color: text, major_label_text_color: soft, axis_line_color: soft, major_tick_line_color: soft,
        axis_label_text_font_size: `${large ? size : size + 1}px`, major_label_text_font_size: `${size}px` })
    }
    for (const line of figure.center) if ("grid_line_color" in line) set(line, { grid_line_color: grid, grid_line_alpha: 0.5 })
    for (const part of Object.values(parts[name])) {
      if (part.tags[0]) tint(part, colour(part.tags[0]))
      thicken(part, large ? THICK : 1)
    }
  }
  namePlace()
  shareAxis()
}

// Curves that stand above each other share the lowest's axis; the punch that of the tractions under it
function shareAxis() {
  const lab = document.documentElement.dataset.view === "lab"
  const stacked = ["forces", "area", "map"].filter((view) => document.querySelector(`.view[data-view="${view}"]`).checkVisibility())
  for (const view of stacked) set(figures[view].below[0], { visible: lab || view === stacked.at(-1) })
  for (const view of ["punch", "twin"]) if (figures[view]) set(figures[view].below[0], { visible: lab || !document.getElementById("bands").checkVisibility() })
}

// In full where there is room
const namePlace = () => set(figures.map.left[0], { axis_label: figures.map.inner_height > LONG * written ? "x, undeformed (nm)" : "x (nm)" })
