// The page "Inside the solid": stress in the layer at the increment shown, summed here (inside.js).

import { set } from "../../static/js/bokeh.js"
import { nice, rampIn, shades, theme } from "../../static/js/colours.js"
import { by, on } from "../../static/js/dom.js"
import { extent, figures, fillImage, parts, stretchText, tellLimits } from "../../static/js/figures.js"
import { APART, mean, middles, SHEARED, sumsIn, tableFor, XX, XZ, ZZ } from "../../static/js/inside.js"
import { redrawCanvases } from "../../static/js/store.js"

const COLUMNS = 400, ROWS = 100 // of the picture
const MODES = 1024 // at most: of more nodes than twice that the finest waves are left out

let palette = [], stresses = {} // colours of a quantity without sign; all quantities (app/schema.py)
let drawn = "", limits = {} // what is on screen; of a quantity of a run

const FIELDS = { // of sums over weights, and the scene; GPa
  largest: (of) => { const [a, b] = of([APART, SHEARED]); return a.map((value, i) => Math.hypot(value, b[i]) / 2) },
  normal: (of) => of([ZZ])[0],
  lateral: (of) => of([XX])[0],
  shear: (of) => of([XZ])[0],
  mean: (of, scene) => of([mean(scene)])[0],
}

export function frame(run, k) {
  const stretch = stretchText("solid_field")
  if (stretch) by("solid_field-stretch").textContent = stretch === "to scale" ? stretch : `vertical ${stretch}`
  const scene = run.headOf(k).scene, half = figures.punch.x_range.end
  const depth = Math.min(half, scene.height * scene.width)
  const quantity = by("solid-quantity").value, key = [run.number, k, half, quantity, theme()].join()
  const table = key !== drawn && tableFor(scene, { rows: ROWS, modes: Math.min(MODES, scene.nodes >> 1), depth }, k)
  if (!table) return
  drawn = key
  const image = FIELDS[quantity]((weights) => sumsIn(run, k, table, middles(COLUMNS, half), weights), scene)
  fillImage("solid_field", "field", image, [ROWS, COLUMNS], { x: [-half], y: [0], dw: [2 * half], dh: [depth] })
  set(figures.solid_field.x_range, { start: -half, end: half })
  set(figures.solid_field.y_range, { start: 0, end: depth })
  shade(quantity, run.number, image)
  nameQuantity(quantity)
  by("solid-extent").textContent = `largest ${Math.max(...extent(image).map(Math.abs)).toPrecision(3)} GPa`
}

// What the view shows now, and the key of its colours
function nameQuantity(quantity) {
  const { name, below: [low, , less], above: [high, , more] } = stresses[quantity]
  by("solid-name").innerHTML = name
  by("solid-below").textContent = less
  by("solid-above").textContent = more
  const bars = by("solid-scale").querySelectorAll(".bar")
  by("solid_field-low").hidden = bars[0].hidden = !low
  bars[0].className = `bar ${low}`
  bars[1].className = `bar ${high}`
}

// Limits grow with the run, so that colours keep their meaning while it is played
function shade(quantity, run, image) {
  const mapper = parts.solid_field.field.glyph.color_mapper, key = `${quantity} ${run}`
  const [low, high] = extent(limits[key] ?? [0, 0], image)
  limits = { [key]: [low, high] }
  const top = nice(Math.max(-low, high)), { below: [, less], above: [, more] } = stresses[quantity]
  set(mapper, less ? shades(-top, top, [less, more], rampIn(by("solid"))) : { low: 0, high: top, palette })
  tellLimits("solid_field", -top, top)
}

export function receive(news) {
  if (news.palette) ({ palette, stresses } = news)
}

export const opened = () => { drawn = "" }

export const connect = () => on("solid-quantity", "input", redrawCanvases)
