// The figures: frames and curves into their sources. Nothing here reaches the server.

import {
  fill as fillRenderer, image as imageFor, isDrawn, namedParts, set, thicken, tint, viewOf,
} from "./bokeh.js"
import { colour, isShown, nice, readAgain, shades, textSize, theme } from "./colours.js"
import { by, tell } from "./dom.js"
import { digits, named } from "./quantities.js"
import { me } from "./store.js"
import { tellStart } from "./words.js"

export const figures = {} // name: Bokeh figure, also those of a page that is open
export const parts = {} // figure: {label: what is drawn in it}
export const CURVES = ["forces", "area", "map"]
const LEAST = 0.05 // GPa; weaker traction is not blown up to fill a view
const NARROW = 0.5 // of the largest area: where it stays above, the axis does not begin at zero
const EDGE = 0.02 // of a curve, that an axis keeps beyond it, so that marks at its ends are whole
const ROOM = 0.3 // of a curve, that an axis which cannot stay gets beyond it in a drag, so that it stays for a while
const SPARE = 0.08 // of a curve, on either side of it on a new axis
const FAR_LESS = 0.6 // of an axis: where no more of it is needed, the axis shrinks
const THICK = 2.5 // times, for a projector
export function adopt(name, figure) {
  figures[name] = figure
  parts[name] = namedParts(figure)
}

export function forget(name) {
  delete figures[name]
  delete parts[name]
}

export const fill = (view, label, columns) => fillRenderer(parts[view][label], columns)

export const fillImage = (view, label, values, shape, place) => (
  fill(view, label, { image: imageFor(parts[view][label], values, shape), ...place }))

export const drawn = (names) => names.every((name) => isDrawn(figures[name]))

// A range that holds low..high. It grows at once when too small. It shrinks when far too large, and no slider is held
export function fit(range, low, high) {
  const { start, end } = range, size = Math.max(high - low, 1e-9)
  const below = low - EDGE * size < start, above = high + EDGE * size > end
  const least = low < 0 ? -Infinity : -SPARE * size // what is never negative has no axis below zero
  if (me.dragging)
    set(range, { start: below ? Math.max(low - ROOM * size, least) : start, end: above ? high + ROOM * size : end })
  else if (below || above || size < FAR_LESS * (end - start))
    set(range, { start: low - SPARE * size, end: high + SPARE * size })
}

// The end of an axis, where a run needs `needed`, with `spare` of it without harm out of sight
export const settled = (end, needed, spare = 0) =>
  (needed <= (1 + spare) * end && needed > FAR_LESS * end ? end : needed)

// [lowest, highest] of all numbers, and zero
export const extent = (...lists) => lists.reduce(([a, b], list) => {
  for (const v of list) { if (v < a) a = v; if (v > b) b = v }
  return [a, b]
}, [0, 0])

// Pins whose runs are drawn along the same path as a run
export const beside = (run) => me.pins.filter(({ shown, run: pinned }) => (
  shown && pinned.sheared >= 0 && pinned.head.abscissa === run.head.abscissa))

let curvesDrawn = {} // {ghost, approach, look} as they were drawn
const NOTHING = { along: [], value: [] }
export function drawCurves(run, ghost, approach) {
  // along something else, or drawn already
  const pinned = me.pins.some(({ shown, run: of }) => shown && of === ghost)
  if (pinned || ghost?.head.abscissa !== run.head.abscissa) ghost = null
  const known = new Map([run, ghost, ...beside(run).map((pin) => pin.run)].map((of) => [of, {}])) // made once
  const part = (of, name) => (of ? (known.get(of)[name] ??= of.drawn(name, approach)) : NOTHING)
  const { look } = me, was = curvesDrawn
  const same = ghost === was.ghost && approach === was.approach && look === was.look
  for (const [figure, name] of [["forces", "F"], ["forces", "L"], ["area", "A"]]) {
    if (!figureShown(figure)) continue
    for (const [prefix, of] of same ? [["", run]] : [["ghost_", ghost], ["", run]]) {
      const { along, value } = part(of, name)
      fill(figure, `${prefix}${name}`, { U_x: along, value })
    }
  }
  document.querySelector(".page").dataset.ghost = ghost !== null
  nameGhost(run, ghost)
  curvesDrawn = { ghost, approach, look }
  nameAxis(approach ? "delta" : run.head.abscissa)
  markSlips(run, approach)
  const values = (name) => [...known.keys()].map((of) => part(of, name).value)
  fitCurves(run, approach, ["F", "L"].map(values), values("A"))
}

// Slips, and which way each part of a loop is walked
function markSlips(run, approach) {
  const along = run.normal || approach
  const marked = [["forces", along ? "L" : "F", run.normal ? "L" : "F"], ["area", "A", "A"]]
  for (const [figure, name, way] of marked.filter(([each]) => figureShown(each))) {
    const [U_x, value] = run.slips(name, 1, null, approach)
    fill(figure, `slips_${figure === "area" ? "A" : "F"}`, { U_x, value })
    pointAlong(run, figure, run.curves[way])
  }
}

// Axes that hold the forces and areas of all runs drawn
function fitCurves(run, approach, forces, areas) {
  const [start, end] = run.extent(approach), room = start < end ? 0 : 1 // nm, where nothing is walked
  set(figures.forces.x_range, { start: start - room, end: end + room })
  fit(figures.forces.y_range, ...extent([-0.01, 0.02], ...forces.flat()))
  const all = areas.flatMap((list) => [...list]), least = Math.min(...all), most = Math.max(...all, run.head.spacing)
  const from = least > NARROW * most ? least : 0 // a few per cent of peeling must be seen
  fit(figures.area.y_range, from, most)
  tellStart(from && figures.area.y_range.start)
}

const NAMED = 2 // parameters at most

// What the run before was computed with, where that is another scene
function nameGhost({ scene }, ghost) {
  const names = scene && ghost?.scene ? Object.keys(scene).filter((name) => scene[name] !== ghost.scene[name]) : []
  const values = names.map((name) => named(name, ghost.scene[name])).join(", ")
  const text = names.length && names.length <= NAMED ? `: ${values}` : ""
  for (const key of document.querySelectorAll(".key .ghost .of")) tell(key, text)
}

// Which way each part of a loop is walked: heads of arrows, those of its ways at other places
const HEADS = [[0.25, 0.55], [0.2, 0.65], [0.4, 0.9]] // parts of a way
function pointAlong(run, view, value) {
  const { along, curves: { stage: stages } } = run, loops = run.normal || run.head.span[0] < 0
  const heads = [...new Set(loops ? stages : [])].filter((stage) => stage > 0).flatMap((stage, i) => {
    const first = stages.indexOf(stage), last = stages.lastIndexOf(stage), way = Math.sign(along[last] - along[first])
    return way ? HEADS[i % HEADS.length].map((part) => [Math.round(first + part * (last - first)), way]) : []
  })
  fill(view, "ways", { U_x: heads.map(([k]) => along[k]), value: heads.map(([k]) => value[k]),
    angle: heads.map(([, way]) => (-way * Math.PI) / 2) })
}

// The text beside the mouse on a curve: change(where, what) makes it from the previous, [symbol, value] each
function retell(view, change) {
  const tools = figures[view].toolbar.tools.filter(({ tooltips }) => tooltips?.[0])
  for (const tool of tools) set(tool, { tooltips: change(...tool.tooltips) })
}

// What curves are drawn along
const AXES = {
  U_x: ["Uₓ", "displacement Uₓ (nm)"], delta: ["δ", "indentation δ (nm)"], path: ["path", "length of the path (nm)"],
}
let abscissaNamed = "U_x"
function nameAxis(abscissa) {
  if (abscissa === abscissaNamed) return
  abscissaNamed = abscissa
  const event = abscissa === "delta" ? "jump" : "slip"
  for (const word of document.querySelectorAll(".slips")) word.textContent = event
  const back = abscissa === "delta" // over the same indentation: dashes of both ways would fill each other's gaps
  for (const line of ["L", "ghost_L"]) set(parts.forces[line].glyph, { line_dash: back ? "solid" : "dashed" })
  document.querySelector("main .forces .key > :nth-child(2) .line").classList.toggle("dashed", !back)
  const [symbol, label] = AXES[abscissa]
  for (const view of CURVES) {
    set(figures[view].below[0], { axis_label: label })
    retell(view, ([, value], ...rest) => [[symbol, value], ...rest])
  }
}

// The limits of the colours of a view, in its key
export function tellLimits(view, low, high) {
  tell(by(`${view}-low`), digits(low, 2))
  tell(by(`${view}-high`), `+${digits(high, 2)} GPa`)
}

export function drawMap(run, shown) {
  if (run.sheared < 0 || !figureShown("map")) return
  const { image, rows, columns, start, low, step, unrested } = run.map(shown), { spacing } = run.head
  fillImage("map", "map", image, [rows, columns],
    { x: [start - step / 2], y: [low], dw: [columns * step], dh: [rows * spacing] })
  shadeMap(run)
  const bottom = unrested.map(() => low), top = unrested.map(() => low + rows * spacing)
  fill("map", "unrested", { x: unrested.map(([x]) => x), width: unrested.map(([, width]) => width), bottom, top })
  by("unrested").hidden = !unrested.length
  const edges = run.otherEdges(shown)
  fill("map", "branch", edges)
  by("branch").hidden = !edges.x.some((x) => x === x)
  const [U_x] = run.slips("F_bar", 1, run.stageOfMap(shown), run.approaching(shown))
  fill("map", "slips_map", { U_x, x: U_x.map(() => 0.94 * figures.map.y_range.start) })
}

const ends = [0, 0] // GPa, at which the colours of the map end
function shadeMap(run) {
  if (!(run?.sheared >= 0)) return
  const needed = [-run.T_low, run.T_high].map((T) => nice(Math.max(T, LEAST)))
  needed.forEach((GPa, i) => { ends[i] = settled(ends[i], GPa) })
  shade("map", "map", -ends[0], ends[1])
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

// What is not in sight is not drawn
export const figureShown = (view) => isShown(document.querySelector(`.view[data-view="${view}"]`))

// Figures are drawn on a canvas and need the colours: of what is drawn, the one its tag names
export function paint() {
  readAgain()
  const text = colour("--text"), soft = colour("--soft"), grid = colour("--grid")
  const size = textSize(), large = size > 15 // for a projector
  for (const name in figures) {
    const figure = figures[name]
    viewOf(figure) // the Tab key passes it
    set(figure, { outline_line_color: grid, min_border_right: large ? 34 : 14 })
    for (const axis of [...figure.below, ...figure.left]) {
      set(axis, {
        axis_label_text_color: text, major_label_text_color: soft, axis_line_color: soft, major_tick_line_color: soft,
        axis_label_text_font_size: `${large ? size : size + 1}px`, major_label_text_font_size: `${size}px`,
      })
    }
    for (const line of figure.center) if ("grid_line_color" in line)
      set(line, { grid_line_color: grid, grid_line_alpha: 0.5 })
    for (const part of Object.values(parts[name])) {
      if (part.tags[0]) tint(part, colour(part.tags[0]))
      thicken(part, large ? THICK : 1)
    }
  }
  shareAxis()
}

// Curves that stand above each other share the lowest's axis; the punch that of the tractions under it
export function shareAxis() {
  const stacked = CURVES.filter(figureShown)
  for (const view of stacked) set(figures[view].below[0], { visible: view === stacked.at(-1) })
  set(figures.punch.below[0], { visible: !isShown(by("bands")) })
}
