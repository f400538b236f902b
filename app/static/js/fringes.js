// Photoelastic fringes inside the punch: lines of equal shear stress, summed here from the tractions of the frame on screen
// and a table of how each of their modes reaches into the layer (solver/analysis/interior.py), sent once for a geometry.

import { frameBox } from "./bokeh.js"
import { listen, opened, order } from "./channel.js"
import { by, on } from "./dom.js"
import { figures } from "./figures.js"
import { cleared } from "./pen.js"

const WIDE = 320, HIGH = 180, SHADES = 64 // of the picture in pixels; of a fringe
const COLUMNS = 192, DECAYED = 12 // of the picture; q z from which on a mode is not felt
const WAVES = 9 // of the shortest mode in half of the width shown
const ORDERS = 3 // fringes that the strongest traction of a run makes, in a material chosen for that
const LEAST = 0.02 // GPa a fringe: weaker stress is not blown up
const BAR = 9 // px, as the top is drawn by story.js
const GEOMETRY = ["nu", "height", "width", "nodes"]
const CHANNELS = [1.1, 1, 0.91] // of red, green and blue: orders over that of green, as their waves are longer and shorter

let shown = true, table = null, asked = "", wave = null // wave: cosines and sines of modes over columns, and for which window
const sheet = document.createElement("canvas")
let image = null

export function connectFringes(redraw) {
  shown = localStorage.getItem("fringes") !== "plain"
  by("fringes-on").checked = shown
  on("fringes-on", "change", () => {
    shown = by("fringes-on").checked
    localStorage.setItem("fringes", shown ? "on" : "plain")
    redraw()
  })
  listen("layer", (buffer) => {
    const { head, start } = opened(buffer)
    table = { ...head, key: keyOf(head.geometry, head.asked), factors: new Float32Array(buffer.slice(start)) }
    redraw()
  })
}

const keyOf = (geometry, { modes, depth }) => JSON.stringify([geometry, modes, depth])

// The table for what is shown of a run, once it is there
function tableFor({ head }, half) {
  const { scene } = head, geometry = GEOMETRY.map((name) => scene[name])
  const wanted = { modes: Math.max(32, Math.min(128, Math.ceil((WAVES * scene.width) / half))), depth: Math.min(half, scene.height * scene.width) }
  const key = keyOf(geometry, wanted)
  if (table?.key === key) return table
  if (asked !== key) order("layer", wanted)
  asked = key
  return null
}

export function drawFringes(run, k, canvas = by("fringes"), figure = figures.punch) {
  const box = canvas.checkVisibility() ? frameBox(figure) : null, pen = box && cleared(canvas)
  if (!pen || !shown || run.head.flat || run.apart) return
  const found = tableFor(run, figure.x_range.end)
  if (!found) return
  paintSheet(run, k, found, figure, ordersIn(run, k, found, figure.x_range.end), (box.height - BAR) / box.height)
  pen.drawImage(sheet, box.left, box.top + BAR, box.width, box.height - BAR)
}

// The body in the pixels of a small picture of the view below the top: each column of material from where its surface is
// to where it hangs on the top. part: of the view's height, that is below the top
function paintSheet(run, k, { rows }, { x_range, y_range }, found, part) {
  Object.assign(sheet, sheet.width === WIDE ? {} : { width: WIDE, height: HIGH })
  const pen = sheet.getContext("2d"), pixels = (image ??= pen.createImageData(WIDE, HIGH)), shades = new Uint32Array(pixels.data.buffer)
  const { x, gap } = run.frame(k), { first, spacing, middle } = run.headOf(k), U_x = run.curves.U_x[k], inks = inksOf(document.documentElement.dataset.theme)
  const half = x_range.end, nm = (2 * half) / WIDE, high = y_range.end - (1 - part) * (y_range.end - y_range.start), step = (high - y_range.start) / HIGH
  shades.fill(0)
  for (let c = 0, i = 0; c < WIDE; c++) {
    const at = -half + (c + 0.5) * nm
    while (i < x.length - 2 && x[i + 1] < at) i++
    const between = (at - x[i]) / (x[i + 1] - x[i])
    if (!(between >= 0 && between <= 1)) continue
    const surface = gap[i] + (gap[i + 1] - gap[i]) * between, u = at - ((first + i + between) * spacing - middle), deep = high - surface
    const last = Math.min(HIGH, Math.ceil((high - surface) / step))
    for (let r = 0; r < last; r++) {
      const t = Math.max(0, 1 - ((r + 0.5) * step) / deep), column = (at - u - (U_x - u) * t + half) / nm - 0.5, row = (1 - t) * rows - 0.5
      const j = Math.max(0, Math.min(COLUMNS - 2, Math.floor((column * COLUMNS) / WIDE))), l = Math.max(0, Math.min(rows - 2, Math.floor(row)))
      const p = Math.max(0, Math.min(1, (column * COLUMNS) / WIDE - j)), q = Math.max(0, Math.min(1, row - l)), n = l * COLUMNS + j
      const fringe = (found[n] * (1 - p) + found[n + 1] * p) * (1 - q) + (found[n + COLUMNS] * (1 - p) + found[n + COLUMNS + 1] * p) * q
      shades[r * WIDE + c] = inks[Math.min(inks.length - 1, Math.round(fringe * SHADES))]
    }
  }
  pen.putImageData(pixels, 0, 0)
}

// The colours of fringe orders, as bytes: bright where nothing is sheared on a light page, dark on a dark one
const inked = {}
function inksOf(theme) {
  return (inked[theme] ??= Uint32Array.from({ length: 16 * SHADES }, (_, i) => CHANNELS.reduce((ink, longer, channel) => {
    const light = 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / SHADES / longer)
    return (ink | (Math.round(255 * (theme === "dark" ? light : 1 - light)) << (8 * channel))) >>> 0
  }, 0xff000000)))
}

// Fringe orders (rows, COLUMNS) from the tractions of frame k, the row at the top first
function ordersIn(run, k, { rows, modes, depth, factors }, half) {
  const [{ head, fields }, row] = run.places[k], { nodes, first, scales, scene } = head, step = (2 * Math.PI) / scene.width
  const waves = wavesOver(step, modes, half, head.middle), T_z = modesOf(fields.T_z, scales.T_z), T_x = modesOf(fields.T_x, scales.T_x)
  const out = new Float32Array(rows * COLUMNS), apart = new Float32Array(COLUMNS), sheared = new Float32Array(COLUMNS)
  const per = perFringe(run)
  for (let r = 0; r < rows; r++) {
    const z = ((r + 0.5) * depth) / rows, last = Math.min(modes, Math.ceil(DECAYED / (step * z)) + 1)
    apart.fill(0)
    sheared.fill(0)
    for (let m = 0; m < last; m++) {
      const j = 4 * (r * modes + m), [a, b, c, d] = [factors[j], factors[j + 1], factors[j + 2], factors[j + 3]]
      const zc = T_z.cos[m], zs = T_z.sin[m], xc = T_x.cos[m], xs = T_x.sin[m]
      const p = a * zc - b * xs, q = -a * zs - b * xc, u = c * xc - d * zs, v = -c * xs - d * zc // times cosine and sine
      const { cos, sin } = waves[m]
      for (let i = 0; i < COLUMNS; i++) {
        apart[i] += p * cos[i] + q * sin[i]
        sheared[i] += u * cos[i] + v * sin[i]
      }
    }
    const to = (rows - 1 - r) * COLUMNS
    for (let i = 0; i < COLUMNS; i++) out[to + i] = Math.sqrt(apart[i] * apart[i] + sheared[i] * sheared[i]) / per
  }
  return out

  // Amplitudes c + i s of T = Re sum (c + i s) exp(i q x), all but the first counted twice
  function modesOf(field, scale) {
    const cos = new Float64Array(modes), sin = new Float64Array(modes), n = scene.nodes
    const base = turnsOf(n)
    for (let i = 0; i < nodes; i++) {
      const value = (field[row * nodes + i] * scale) / n
      if (value === 0) continue
      for (let m = 0, turn = 0; m < modes; m++) {
        cos[m] += value * base.cos[turn]
        sin[m] -= value * base.sin[turn]
        turn = (turn + first + i) % n
      }
    }
    for (let m = 1; m < modes; m++) { cos[m] *= 2; sin[m] *= 2 }
    return { cos, sin }
  }
}

const turns = {} // cosines and sines of n parts of a turn
function turnsOf(n) {
  const angle = (i) => (2 * Math.PI * i) / n
  return (turns[n] ??= { cos: Float64Array.from({ length: n }, (_, i) => Math.cos(angle(i))), sin: Float64Array.from({ length: n }, (_, i) => Math.sin(angle(i))) })
}

function wavesOver(step, modes, half, middle) {
  const key = [step, modes, half, middle].join()
  if (wave?.key !== key) {
    const x = Array.from({ length: COLUMNS }, (_, i) => middle - half + ((i + 0.5) * 2 * half) / COLUMNS)
    const all = Array.from({ length: modes }, (_, m) => ({ cos: Float32Array.from(x, (v) => Math.cos(m * step * v)), sin: Float32Array.from(x, (v) => Math.sin(m * step * v)) }))
    wave = { key, all }
  }
  return wave.all
}

// GPa: a round number, the same for all of a run
function perFringe(run) {
  const most = Math.max(run.T_most, -run.T_least) / ORDERS, size = 10 ** Math.floor(Math.log10(Math.max(most, LEAST)))
  return size * ([5, 2, 1].find((one) => one * size <= most) ?? 1)
}
