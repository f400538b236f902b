// The page "Inside the solid": stress in the layer at the increment shown, summed here (inside.js).

import { set } from "../../static/js/bokeh.js"
import { nice, rampIn, shades } from "../../static/js/colours.js"
import { by, on } from "../../static/js/dom.js"
import { extent, figures, fill, fillImage, painted as together, parts, tellLimits, tellStretch } from "../../static/js/figures.js"
import { APART, mean, middles, moved, SHEARED, sumsIn, tableFor, XX, XZ, ZZ } from "../../static/js/inside.js"
import { me } from "../../static/js/state.js"

const COLUMNS = 400, ROWS = 100 // of the picture
const MODES = 1024 // at most: of more nodes than twice that the finest waves are left out
const RESOLVED = 0.5 // fringe orders from one value to the next: with more, a picture shows fringes that are none
const MESH = [20, 10] // columns and rows of the picture from one line of the mesh to the next
const SEEN = 0.06 // of the width shown: the largest displacement in the mesh
const WIDER = 1.15 // times the width shown: displaced, the mesh still reaches both edges
const BENEATH = 0.06 // of the depth, below the picture, for the deformed surface
const GREYS = Array.from({ length: 256 }, (_, i) => `#${i.toString(16).padStart(2, "0").repeat(3)}`)

let palette = [], stresses = {} // colours of a quantity without sign; all quantities (app/schema.py)
let drawn = "", limits = {} // what is on screen; of a quantity of a run

const apart = (of) => { const [a, b] = of([APART, SHEARED]); return a.map((value, i) => Math.hypot(value, b[i])) }
const FIELDS = { // of sums over weights, and the scene; GPa, fringes: brightness
  fringes: (of) => seen(apart(of).map((value) => value / Number(by("solid-fringe").value))),
  largest: (of) => apart(of).map((value) => value / 2),
  normal: (of) => of([ZZ])[0],
  lateral: (of) => of([XX])[0],
  shear: (of) => of([XZ])[0],
  mean: (of, scene) => of([mean(scene)])[0],
}

// Brightness of fringe orders in a dark field: mid grey where they change by RESOLVED from one value to the next
export function seen(orders, columns = COLUMNS) {
  const steep = (i, j) => Math.abs((orders[j] ?? orders[i]) - orders[i])
  return orders.map((order, i) => {
    const across = Math.max(i % columns ? steep(i, i - 1) : 0, (i + 1) % columns ? steep(i, i + 1) : 0)
    const contrast = Math.cos((Math.PI / 2) * Math.min(Math.max(across, steep(i, i - columns), steep(i, i + columns)) / RESOLVED, 1)) ** 2
    return 0.5 + contrast * (Math.sin(Math.PI * order) ** 2 - 0.5)
  })
}

export function frame(run, k) {
  const scene = run.headOf(k).scene, layer = scene.height * scene.width, whole = by("solid-whole").checked
  const half = whole ? scene.width / 2 : figures.punch.x_range.end, depth = whole ? layer : Math.min(half, layer)
  const quantity = by("solid-quantity").value, mesh = by("solid-mesh").checked
  const key = [run.number, k, half, quantity, mesh, by("solid-fringe").value].join()
  const table = key !== drawn && tableFor(scene, { rows: ROWS, modes: Math.min(MODES, scene.nodes >> 1), depth })
  if (!table) return
  drawn = key
  const sums = (x) => (weights) => sumsIn(run, k, table, x, weights), wide = middles(COLUMNS, WIDER * half)
  const image = FIELDS[quantity](sums(middles(COLUMNS, half)), scene)
  const lines = mesh ? meshOf(sums(wide)(moved(scene)), wide, depth) : { x: [], z: [], factor: 0 }
  fillImage("solid_field", "field", image, [ROWS, COLUMNS], { x: [-half], y: [0], dw: [2 * half], dh: [depth] })
  fill("solid_field", "mesh", { x: lines.x, z: lines.z })
  set(figures.solid_field.x_range, { start: -half, end: half })
  set(figures.solid_field.y_range, { start: mesh ? -BENEATH * depth : 0, end: depth })
  shade(quantity, run.number, image)
  nameQuantity(quantity)
  tellStretch()
  const largest = quantity === "fringes" ? "" : `largest ${Math.max(...extent(image).map(Math.abs)).toPrecision(3)} GPa`
  by("solid-said").textContent = [largest, mesh ? `mesh: displacements × ${lines.factor}, the top at rest; stress over the undeformed layer` : ""].filter(Boolean).join("; ")
}

// Lines that deform with the layer, NaN between them, and the factor on displacements, a round number
function meshOf([u_x, u_z], x, depth) {
  const most = Math.max(...extent(u_x, u_z).map(Math.abs)), lines = { x: [], z: [] }
  const factor = most ? Number(((SEEN * 2 * x.at(-1)) / most).toPrecision(1)) : 1
  const point = (r, c) => {
    const i = r * COLUMNS + c
    lines.x.push(x[c] + factor * u_x[i])
    lines.z.push(((r + 0.5) * depth) / ROWS + factor * u_z[i])
  }
  const end = () => { lines.x.push(NaN); lines.z.push(NaN) }
  for (let r = 0; r < ROWS; r += MESH[1], end()) for (let c = 0; c < COLUMNS; c++) point(r, c)
  for (let c = MESH[0] / 2; c < COLUMNS; c += MESH[0], end()) for (let r = 0; r < ROWS; r++) point(r, c)
  return { ...lines, factor }
}

// What the view shows now, and the key of its colours
function nameQuantity(quantity) {
  const { name, below: [low, , less], above: [high, , more] } = stresses[quantity]
  by("solid-name").innerHTML = name
  by("solid-fringes").hidden = Boolean(high)
  by("solid-scale").hidden = !high
  by("solid-below").textContent = less
  by("solid-above").textContent = more
  const bars = by("solid-scale").querySelectorAll(".bar")
  by("solid_field-low").hidden = bars[0].hidden = !low
  bars[0].className = `bar ${low}`
  bars[1].className = `bar ${high}`
}

// Limits grow with the run, so that colours keep their meaning while it is played
function shade(quantity, run, image) {
  const mapper = parts.solid_field.field.glyph.color_mapper
  if (quantity === "fringes") return set(mapper, { low: 0, high: 1, palette: GREYS })
  const key = `${quantity} ${run} ${by("solid-whole").checked}`
  const [low, high] = extent(limits[key] ?? [0, 0], image)
  limits = { [key]: [low, high] }
  const top = nice(Math.max(-low, high)), { below: [, less], above: [, more] } = stresses[quantity]
  set(mapper, less ? shades(-top, top, [less, more], rampIn(by("solid"))) : { low: 0, high: top, palette })
  tellLimits("solid_field", -top, top)
}

function anew() {
  drawn = ""
  if (me.run?.length && me.drawn >= 0) together(() => frame(me.run, Math.min(me.drawn, me.run.length - 1)))
}

export function told(news) {
  if (news.palette) ({ palette, stresses } = news)
}

export const painted = anew

export const opened = () => { drawn = "" }

export function connect() {
  for (const id of ["solid-quantity", "solid-fringe", "solid-mesh", "solid-whole"]) on(id, "input", () => {
    by("solid-fringe-row").hidden = by("solid-quantity").value !== "fringes"
    by("solid-fringe-value").textContent = `${Number(by("solid-fringe").value).toFixed(2)} GPa`
    anew()
  })
}
