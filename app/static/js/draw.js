// Drawing: frames and curves into the sources of the Bokeh figures. Nothing here reaches the server (sync: false).

const here = { sync: false }
const figure = plain(figures), part = plain(parts)
for (const name in part) part[name] = plain(part[name])
const THOUSAND = 1000
const tints = plain(colours)
for (const name in tints) tints[name] = plain(tints[name])
const BELOW = -1.2 // nm; a punch that goes deeper has a deeper view
const LEAST = 0.05 // GPa; weaker traction is not blown up to fill a view

// The views of all figures, those of a page as soon as they are made
const found = new Map()
function canvases() {
  for (const name in figure) {
    if (found.get(name)?.model === figure[name]) continue
    const view = Bokeh.index.find_one(figure[name])
    if (view?.canvas_view) {
      view.canvas_view.events_el.tabIndex = -1 // nothing to be done there with keys
      found.set(name, view)
    } else found.delete(name)
  }
  return [...found].filter(([name]) => name in figure).map(([, view]) => view)
}

// Make several changes, then paint each figure that has any: once, and before the next frame instead of after it.
// Bokeh takes new data in through a short chain of promises, which must have come to its end.
const CHAIN = 64
async function painted(change) {
  const views = canvases()
  for (const view of views) view.pause()
  try {
    change()
    for (let i = 0; i < CHAIN; i++) await null
  } finally {
    for (const view of views) view.unpause(true)
    for (const view of views) view.repaint()
  }
}

function fill(view, label, columns) {
  const source = part[view][label].data_source
  Object.assign(plainData(source), columns)
  source.change.emit()
}

function plainData(source) {
  if (source.data instanceof Map) source.setv({ data: Object.fromEntries(source.data) }, { ...here, silent: true })
  return source.data
}

// A range that holds low..high with room; it follows at once when too small, and shrinks only when far too large
function fit(range, low, high, room = 0.08) {
  const size = Math.max(high - low, 1e-9)
  const inside = low >= range.start && high <= range.end
  if (inside && size > 0.6 * (range.end - range.start)) return
  range.setv({ start: low - room * size, end: high + room * size }, here)
}

const extent = (...lists) => lists.reduce(([a, b], list) => {
  for (const v of list) { if (v < a) a = v; if (v > b) b = v }
  return [a, b]
}, [0, 0])

function drawCurves(run, ghost) {
  if (ghost?.head.abscissa !== run.head.abscissa) ghost = null // drawn along something else
  if (ghost !== drawnGhost) drawGhost(ghost)
  const U_x = run.shear(run.head.abscissa), F = run.shear("F", THOUSAND), L = run.shear("L", THOUSAND), A = run.shear("A", THOUSAND)
  fill("forces", "F", { U_x, value: F })
  fill("forces", "L", { U_x, value: L })
  fill("area", "A", { U_x, value: A })
  drawSlips(run)
  const [start, end] = run.extent
  figure.forces.x_range.setv({ start, end }, here)
  nameAxis(run.head.abscissa)
  const old = (name) => ghost?.shear(name, THOUSAND) ?? []
  fit(figure.forces.y_range, ...extent([-0.01, 0.02], F, L, old("F"), old("L")))
  const areas = [...A, ...old("A")], least = Math.min(...areas), most = Math.max(...areas, 5)
  fit(figure.area.y_range, least > NARROW * most ? least : 0, most) // a few per cent of peeling must be seen
}

// Curves are drawn along U_x, or along delta
let named = "U_x"
function nameAxis(abscissa) {
  if (abscissa === named) return
  named = abscissa
  for (const said of document.querySelectorAll(".slips")) said.textContent = abscissa === "delta" ? "jump" : "slip"
  const [symbol, label] = abscissa === "delta" ? ["δ", "indentation δ (nm)"] : ["Uₓ", "displacement of the top Uₓ (nm)"]
  for (const view of ["forces", "area", "map"]) {
    figure[view].below[0].setv({ axis_label: label }, here)
    for (const tool of figure[view].toolbar.tools) {
      if (tool.tooltips?.[0]) tool.setv({ tooltips: [[symbol, tool.tooltips[0][1]], ...tool.tooltips.slice(1)] }, here)
    }
  }
}

const NARROW = 0.5 // of the largest area: where it stays above, the axis does not begin at zero
let drawnGhost = null
function drawGhost(ghost) {
  drawnGhost = ghost
  for (const [view, name] of [["forces", "F"], ["forces", "L"], ["area", "A"]]) {
    fill(view, `ghost_${name}`, { U_x: ghost?.shear(ghost.head.abscissa) ?? [], value: ghost?.shear(name, THOUSAND) ?? [] })
  }
}

function drawSlips(run) {
  for (const [view, name] of [["forces", run.head.abscissa === "delta" ? "L" : "F"], ["area", "A"]]) {
    const [U_x, value] = run.slips(name, THOUSAND)
    fill(view, view === "area" ? "slips_A" : "slips_F", { U_x, value })
  }
}

// Shades by the sign: two ramps that meet at zero, so that the sign is never in doubt. They are steps of one size, a whole
// number of them on either side of zero, hence the limits of the mapper lie up to a step beyond low and high.
function shades(low, high, [below, above] = ["pull", "push"]) {
  const step = Math.max(Math.min(-low, high) / SHADES, (high - low) / MOST)
  const digits = (text) => [1, 3, 5].map((i) => parseInt(text.slice(i, i + 2), 16))
  const ramp = (name, end) => {
    const from = digits(colour(`--${name}-0`)), to = digits(colour(`--${name}-1`))
    const mixed = (t) => from.map((v, i) => Math.round(v * (1 - t) + to[i] * t).toString(16).padStart(2, "0")).join("")
    const mixtures = Array.from({ length: SHADES }, (_, i) => `#${mixed(i / (SHADES - 1))}`)
    return Array.from({ length: Math.ceil(end / step - 1e-9) }, (_, i) => mixtures[Math.min(SHADES - 1, Math.floor(((i + 0.5) * step * SHADES) / end))])
  }
  const under = ramp(below, -low), over = ramp(above, high)
  return { low: -step * under.length, high: step * over.length, palette: [...under.reverse(), ...over], nan_color: "rgba(0,0,0,0)" }
}
const SHADES = 128, MOST = 4096 // of one sign, at least where the limits are not too different; steps in all

// The limits of the colours of a view, in its key
function tellLimits(view, low, high) {
  by(`${view}-low`).textContent = `${Number(low.toPrecision(2))}`.replace("-", "−")
  by(`${view}-high`).textContent = `+${Number(high.toPrecision(2))} GPa`
}

const nice = (value) => {
  const ten = 10 ** Math.floor(Math.log10(Math.max(value, 1e-6)))
  return [1, 1.5, 2, 3, 4, 5, 6, 8, 10].map((m) => m * ten).find((v) => v >= value * 0.999)?.toPrecision(3) * 1
}

function drawMap(run, shown) {
  if (run.sheared < 0) return
  const { image, rows, columns, start, low } = run.map(shown)
  const array = plainData(part.map.map.data_source).image[0].constructor
  const { spacing, step } = run.head
  fill("map", "map", { image: [new array(image, [rows, columns])], x: [start - step / 2], y: [low], dw: [columns * step], dh: [rows * spacing] })
  shadeMap(run)
  const [U_x] = run.slips("F", 1, run.stageOfMap(shown))
  fill("map", "slips_map", { U_x, x: U_x.map(() => 0.94 * figure.map.y_range.start) })
}

let shaded = "" // for which limits and theme the map has its shades
function shadeMap(run) {
  const low = -nice(Math.max(-run.T_low, LEAST)), high = nice(Math.max(run.T_high, LEAST))
  const mapper = part.map.map.glyph.color_mapper
  const key = [low, high, document.documentElement.dataset.theme].join()
  if (key === shaded) return
  shaded = key
  mapper.setv(shades(low, high), here)
  tellLimits("map", low, high)
}

function drawFrame(run, k) {
  const { x, gap, T_n, T_t } = run.frame(k)
  const n = x.length
  const top = Math.max(7, gap.reduce((a, b) => Math.min(a, b)) + 3) // a punch still far away must be in view as well
  figure.punch.y_range.setv({ end: top }, here)
  const outline = { x: new Float32Array(2 * n), y: new Float32Array(2 * n) }
  for (let i = 0; i < n; i++) {
    outline.x[i] = outline.x[2 * n - 1 - i] = x[i]
    outline.y[i] = gap[i]
    outline.y[2 * n - 1 - i] = Math.max(top + 1, gap[i])
  }
  fill("punch", "body", outline)
  fill("punch", "surface", { x, gap })
  const nodes = { repulsive: [], adhering: [], free: [], contact: [] }
  for (let i = 0; i < n; i++) nodes[run.state(T_n[i], gap[i])].push(i)
  if (run.head.flat) tellFlat(run.state(T_n[0], gap[0]))
  for (const label in nodes) {
    const pick = (list) => Float32Array.from(nodes[label], (i) => list[i])
    fill("punch", label, { x: pick(x), gap: pick(gap), T_n: pick(T_n), T_t: pick(T_t) })
  }
  fill("traction", "T_n", { x, T: T_n })
  fill("traction", "T_t", { x, T: T_t })
  drawCursor(run.along[k])
}

// The key of the nodes of a flat surface, which are all alike
const FLAT_KEYS = { repulsive: ["dot repulsive", "repulsive"], adhering: ["wedge", "adhering"], free: ["dot free", "free"], contact: ["dot contact", "in contact, Tₙ = 0"] }
function tellFlat(state) {
  const [mark, said] = FLAT_KEYS[state]
  by("flat-mark").className = mark
  by("flat-state").textContent = said
}

function drawCursor(location) {
  for (const view of ["forces", "area", "map"]) part[view].cursor.setv({ location }, here)
}

let sites = 0 // how many are drawn on either side of the middle
function drawSites({ spacing, middle }) {
  const half = Math.ceil(figure.punch.x_range.end / spacing) + 2
  if (half === sites) return
  sites = half
  const first = Math.round(middle / spacing)
  const x = Float32Array.from({ length: 2 * half + 1 }, (_, j) => (first - half + j) * spacing - middle)
  fill("punch", "sites", { x, gap: x.map(() => 0) })
}

// What stays the same while a run is played: ranges that hold all of its frames
function fitFrames(run) {
  const { flat, nodes, spacing } = run.head
  const half = flat ? Math.min(100, (nodes / 2 - 1) * spacing) : Math.max(100, 50 * Math.ceil((run.reach * 1.05) / 50))
  document.querySelector(".page").dataset.flat = flat
  figure.map.y_range.setv({ start: -half, end: half }, here)
  figure.punch.x_range.setv({ start: -half, end: half }, here)
  figure.punch.y_range.setv({ start: Math.min(BELOW, 1.15 * run.lowest) }, here)
  fit(figure.traction.y_range, Math.min(run.T_least, -LEAST), Math.max(run.T_most, LEAST))
  drawSites(run.head)
}

// The vertical exaggerations as it is on this screen now
function stateStretch() {
  for (const view of ["punch", "solid_field"]) {
    const { inner_width, inner_height, x_range, y_range } = figure[view] ?? {}
    if (!inner_width || !inner_height) continue
    const times = (inner_height / (y_range.end - y_range.start)) / (inner_width / (x_range.end - x_range.start))
    const said = by(`${view}-stretch`), text = Math.abs(times - 1) < TO_SCALE ? "to scale" : `vertical ×${Number(times.toPrecision(2))}`
    if (said.textContent !== text) said.textContent = text
  }
}
const TO_SCALE = 0.02 // a difference that nobody sees

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim()

// Colours come from style.css; figures are drawn on a canvas and must be told
function paint() {
  const text = colour("--text"), soft = colour("--soft"), grid = colour("--grid")
  for (const name in figure) {
    const plot = figure[name]
    plot.setv({ outline_line_color: grid }, here)
    for (const axis of [...plot.below, ...plot.left]) {
      axis.setv({ axis_label_text_color: text, major_label_text_color: soft, axis_line_color: soft, major_tick_line_color: soft,
        axis_label_text_font_size: "14px", major_label_text_font_size: "13px" }, here)
    }
    for (const line of plot.center) if ("grid_line_color" in line) line.setv({ grid_line_color: grid, grid_line_alpha: 0.5 }, here)
    for (const label in tints[name]) tint(part[name][label], colour(tints[name][label]))
  }
}

function tint(item, value) {
  for (const model of [item.glyph ?? item, item.nonselection_glyph, item.muted_glyph]) {
    if (!model || typeof model !== "object") continue
    for (const key of ["line_color", "fill_color"]) if (key in model) model.setv({ [key]: value }, here)
  }
}
