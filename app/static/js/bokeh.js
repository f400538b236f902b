// Every use of BokehJS that its documentation does not promise, checked against Bokeh 3.9.2, with tests in
// tests/browser/test_bokeh.py that say by their names what broke.

const here = { sync: false }
let index = null // of the views of all models

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
  if (view?.canvas_view) skip(view)
  return view
}
export const isDrawn = (model) => Boolean(viewOf(model)?.has_finished())

// Change properties in this browser only
export function set(model, values) {
  model.setv(values, here)
}
// Each figure listens to the size of the visual viewport and never stops, which keeps all of it in memory: what listens
// belongs to the page that is open
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

// No key does anything in a figure, so that the Tab key passes it; a canvas of a new size is a stop again
function skip(view) {
  const events = view.canvas_view?.events_el
  if (events && events.tabIndex !== -1) events.tabIndex = -1
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

// A canvas with a figure as it is drawn now, in pixels of the screen
export const pictureOf = (figure) => viewOf(figure).export("png").canvas

// The element of the page that holds a figure: from shadow root to shadow root
export function holderOf(figure) {
  let element = viewOf(figure)?.el
  while (element && !element.closest(".view")) element = element.getRootNode().host
  return element?.closest(".view")
}
