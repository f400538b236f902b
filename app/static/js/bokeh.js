// Every use of BokehJS that its documentation does not promise, checked against Bokeh 3.9.2, with tests in
// tests/browser/test_bokeh.py that say by their names what broke.

const here = { sync: false }
let index = null // of the views of all models
let changed = false // whether Bokeh has something to paint

export const plain = (value) => (value instanceof Map ? Object.fromEntries(value) : value)
export const useIndex = (given) => { index = given }
const known = new WeakMap() // model: its view, as Bokeh looks through all of them each time
export function viewOf(model) {
  let view = known.get(model)
  if (view?.el?.isConnected) {
    skip(view)
    return view
  }
  view = index.find_one(model)
  known.set(model, view)
  if (view?.canvas_view) prepare(view)
  return view
}
export const isDrawn = (model) => Boolean(viewOf(model)?.has_finished())

// Change properties in this browser only
export function set(model, values) {
  changed = true
  model.setv(values, here)
}
// Each figure listens to the size of the visual viewport and never stops, which keeps all of it in memory. The figures
// of the experiment are there when this script is loaded; what listens later belongs to the page that is open
const listeners = []
const { addEventListener } = globalThis.visualViewport
visualViewport.addEventListener = function (type, call, ...options) {
  listeners.push([type, call])
  addEventListener.call(this, type, call, ...options)
}

// Let go of what a closed page leaves behind: listeners, and models that nothing refers to any more
export function release(document) {
  for (const [type, call] of listeners.splice(0)) visualViewport.removeEventListener(type, call)
  document.freeze_all_models(() => {})
}
// A figure waits for the end of a pointer that another element has captured, and takes the next finger for a second one
export const dropPointer = (figure, pointerId) =>
  viewOf(figure).canvas_view.events_el.dispatchEvent(new PointerEvent("pointercancel", { pointerId }))
export const onChange = (model, property, call) => model.properties[property].change.connect(call)
export const onMessage = (model, call) => model.document.on_message("message", call)
export const onEvent = (model, name, call) => model.on_event(name, call)

// {label: renderer, band or line} of a figure: what has a name "figure.label"
export function namedParts(figure) {
  const named = [...figure.renderers, ...figure.center].filter((part) => part.name?.startsWith(`${figure.name}.`))
  return Object.fromEntries(named.map((part) => [part.name.slice(figure.name.length + 1), part]))
}

// Columns of a renderer's data, in this browser only; what is empty and stays so is not painted again
export function fill(renderer, columns) {
  const data = dataOf(renderer.data_source)
  if (Object.keys(columns).every((name) => columns[name].length === 0 && data[name]?.length === 0)) return
  changed = true
  Object.assign(data, columns)
  renderer.data_source.change.emit()
}

function dataOf(source) {
  if (source.data instanceof Map) source.setv({ data: Object.fromEntries(source.data) }, { ...here, silent: true })
  return source.data
}

// {x, y} of the points of a curve or of dots, or {image, rows, columns} of an image; null of anything else
export function drawnBy(renderer) {
  if (!renderer.data_source) return null
  const data = dataOf(renderer.data_source), { x, y } = renderer.glyph
  if (data.image) {
    const { shape: [rows, columns] } = data.image[0]
    return { image: data.image[0], rows, columns }
  }
  return x?.field && y?.field ? { x: data[x.field], y: data[y.field] } : null
}

// Values (rows, columns) as an image wants them: of the kind that came from the server
export function image(renderer, values, shape) {
  const array = dataOf(renderer.data_source).image[0].constructor
  return [new array(values, shape)]
}

// At every painting Bokeh does work that changes nothing here. For each colour, font and width it looks for a style
// --bk-* of the page, but this page has none. For each thing drawn it places an element that holds nothing. For each
// axis it asks for a size of the page's text, which only sizes in em need. Together that was most of a painting. Bokeh
// also leaves half a pixel at the top and the left as it was, and strokes the ticks painted last with the outline.
// methods of a visual, a plot
const STYLES = "_get_css_value", ALL = "_paint_primary", SIZE = "base_font_size"
// of anything drawn, of a glyph
const PAINT = "_paint", MASK = "_mask_data", INDEX = "_index"
let unburdened = false
function prepare(view) {
  skip(view)
  if (!unburdened) unburden(view)
  keepRanges(view)
  for (const renderer of view.renderer_views.values()) {
    renderer.update_position = idle
    renderer.el.style.display = "none"
    if (renderer.glyph) lighten(renderer)
    if (renderer.model.ticker && renderer.model.formatter) keepAxis(renderer)
  }
  // an empty canvas over a figure is a layer that the browser puts together with all others for every picture
  const overlaid = [...view.renderer_views.keys()].some(({ level }) => level === "overlay")
  if (!overlaid) view.canvas_view.overlays.el.style.display = "none"
}

// Of each glyph Bokeh keeps four more: decimated, muted, selected and not selected. It computes all of them with new
// data and in each painting, but here they are never painted
const LOOKS = ["decimated_glyph", "muted_glyph", "selection_glyph", "nonselection_glyph"]
const idle = () => {}
function lighten(renderer) {
  for (const look of LOOKS.filter((name) => renderer[name]))
    Object.assign(renderer[look], { set_data: idle, set_visuals: idle, after_visuals: idle, map_data: idle })
  indexLate(renderer.glyph)
  if (renderer.glyph.model.type === "Scatter") paintTogether(renderer.glyph)
}

// Marks of one colour are painted as one path: one by one they are the most expensive part of a painting
const STEPS = ["beginPath", "fill", "stroke"]
function paintTogether(glyph) {
  const { [PAINT]: paint } = glyph
  glyph[PAINT] = (pen, ...what) => {
    if (!glyph.fill_color.is_scalar || !glyph.line_color.is_scalar) return paint.call(glyph, pen, ...what)
    const asked = new Set()
    pen.beginPath()
    for (const step of STEPS) pen[step] = () => { asked.add(step) }
    pen.arc = (x, y, r, ...angles) => { // no line leads to it from the mark before
      pen.moveTo(x + r, y)
      CanvasRenderingContext2D.prototype.arc.call(pen, x, y, r, ...angles)
    }
    paint.call(glyph, pen, ...what)
    for (const step of [...STEPS, "arc"]) delete pen[step]
    for (const step of STEPS.slice(1)) if (asked.has(step)) pen[step]()
  }
}

// With new data Bokeh sorts all points into a tree of places, to find those in the frame. All are: the tree is made
// when the mouse asks for it
function indexLate(glyph) {
  const { index_data: sort } = glyph
  let sorted = null
  glyph[MASK] = null
  glyph.index_data = () => { sorted = null }
  Object.defineProperty(glyph, "index", { get() {
    if (!sorted) sort.call(glyph)
    return (sorted ??= glyph[INDEX])
  } })
}

// Before each painting Bokeh computes what all data extend over, for ranges that follow it. Fixed ones do not
function keepRanges({ frame: { x_ranges, y_ranges }, _range_manager: manager }) {
  const fixed = [...x_ranges.values(), ...y_ranges.values()].every(({ type }) => type === "Range1d")
  if (fixed) manager.update_dataranges = () => { manager.invalidate_dataranges = false }
}

// The texts of axes are half of a painting. An axis is kept as a picture until its range, its place or its look changes
const BEYOND = 40 // px around an axis that its outermost texts reach
function keepAxis(view) {
  const { [PAINT]: paint, model } = view
  const { get: measure } = Object.getOwnPropertyDescriptor(own(view, "extents"), "extents")
  let looks = 0, shown = "", measured = "", picture = null, extents = null
  for (const part of [model, model.ticker, model.formatter]) part.change.connect(() => { looks++ })
  const now = () => [view.ranges[0].start, view.ranges[0].end, looks, ...view.plot_view.frame.bbox.args].join()
  view[PAINT] = (pen) => {
    const { a: scale, e, f } = pen.getTransform?.() ?? {}, { x, y, width, height } = view.bbox
    if (!(scale > 0)) return paint.call(view, pen)
    const key = [now(), x, y, width, height, scale, e, f].join()
    const [left, top] = [x, y].map((at) => Math.floor((at - BEYOND) * scale))
    if (key !== shown) {
      const [wide, high] = [width, height].map((size) => Math.ceil((size + 2 * BEYOND) * scale))
      const canvas = new OffscreenCanvas(wide, high), apart = canvas.getContext("2d")
      apart.setTransform(scale, 0, 0, scale, e - left, f - top)
      paint.call(view, apart)
      shown = key
      picture = canvas.transferToImageBitmap()
    }
    pen.setTransform(1, 0, 0, 1, 0, 0)
    pen.drawImage(picture, left, top)
    pen.setTransform(scale, 0, 0, scale, e, f)
  }
  Object.defineProperty(view, "extents", { get() {
    if (now() !== measured) [measured, extents] = [now(), measure.call(view)]
    return extents
  } })
}

// No key does anything in a figure, so that the Tab key passes it; a canvas of a new size is a stop again
function skip(view) {
  const events = view.canvas_view?.events_el
  if (events && events.tabIndex !== -1) events.tabIndex = -1
}

function unburden(view) {
  const visual = own(view.visuals?.outline_line, STYLES)
  unburdened = true
  if (!visual) return
  visual[STYLES] = () => ""
  const plot = own(view, ALL), paint = plot?.[ALL]
  if (plot) Object.defineProperty(own(plot, SIZE) ?? plot, SIZE, { get: () => 13 }) // px
  if (plot) plot[ALL] = function (pen) {
    pen.beginPath()
    pen.clearRect(-1, -1, this.bbox.width + 2, this.bbox.height + 2)
    paint.call(this, pen)
  }
}

// The prototype of an object that has a method
function own(object, method) {
  while (object && !Object.hasOwn(object, method)) object = Object.getPrototypeOf(object)
  return object
}

// Bokeh paints a change in the next animation frame, once per figure. This resolves in that frame, after Bokeh: a task
// comes after the promises in which Bokeh takes data in. (`view.ready` would do, but it never resolves again once a
// late timer has made Bokeh's throttle drop a promise, as happens on a busy machine.)
export const bokehPainted = () => new Promise((resolve) => setTimeout(() => requestAnimationFrame(resolve)))

// Wait until Bokeh has painted what was changed; when that frame began, ms, or null if nothing was
export async function painted() {
  if (!changed) return null
  changed = false
  return bokehPainted()
}

// The colour of what a renderer, a band or a line draws
export function tint(part, value) {
  const model = part.glyph ?? part
  for (const key of ["line_color", "fill_color", "text_color"]) if (key in model) set(model, { [key]: value })
}

// Lines so many times as thick as they were composed, and marks larger by less: they must not hide what they mark
const composed = new WeakMap() // model: its own line_width and size
export function thicken(item, times) {
  const model = item.glyph ?? item
  if (!composed.has(model)) composed.set(model, { line_width: model.line_width, size: model.size })
  const factors = { line_width: times, size: Math.sqrt(times) }
  for (const [key, given] of Object.entries(composed.get(model))) {
    const value = given?.value ?? given
    if (typeof value === "number") set(model, { [key]: value * factors[key] })
  }
}

// Where the axes of a figure enclose it, px from its corner, and where its places are; nothing before it is laid out
export function frameBox(figure) {
  const { left, top, width, height } = viewOf(figure)?.frame?.bbox ?? {}
  if (!(width > 0 && height > 0)) return null
  const { x_range: { start, end }, y_range } = figure
  const across = width / (end - start), up = height / (y_range.end - y_range.start) // px of a unit
  const X = (x) => left + (x - start) * across, Y = (y) => top + (y_range.end - y) * up
  return { left, top, width, height, across, up, X, Y }
}

// A canvas with a figure as it is drawn now, in pixels of the screen
export const pictureOf = (figure) => viewOf(figure).export("png").canvas

// The element of the page that holds a figure: from shadow root to shadow root
export function holderOf(figure) {
  let element = viewOf(figure)?.el
  while (element && !element.closest(".view")) element = element.getRootNode().host
  return element?.closest(".view")
}
