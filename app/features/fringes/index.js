// Stress inside the punch: photoelastic fringes, lines of equal shear stress, or one component with its sign.

import { addPart, charts } from "../../static/js/charts.js"
import { bytes, isShown, mixed, theme } from "../../static/js/colours.js"
import { all, by, keep, kept, make, on, one } from "../../static/js/dom.js"
import { APART, middles, SHEARED, sumsIn, tableFor, tableMeanwhile, XX, XZ, ZZ } from "./inside.js"
import { BAR, drawnFrame } from "../../static/js/punch.js"
import { digits } from "../../static/js/quantities.js"
import { frame, me, memory, redrawPunch } from "../../static/js/store.js"

// of the picture in pixels, and in how many columns and rows stress is summed; half as many while a slider is held
const ROWS = 60
const FINE = { wide: 320, high: 180, columns: 192, rows: ROWS }
const COARSE = { wide: 160, high: 90, columns: 96, rows: ROWS / 2 }
const SHADES = 64 // of a fringe
const WAVES = 9 // of the shortest mode in half of the width shown
const ORDERS = 3 // fringes in the key; the colours of a component end at so many
const COMPONENTS = { zz: ZZ, xx: XX, xz: XZ }
const LIGHT = 0.3, SIGNED = 0.7, DARK = 0.4 // opacity: calm enough for what stands over it
const sheet = make("canvas")
// of red, green and blue: orders over that of green, as their waves are longer and shorter
const CHANNELS = [1.1, 1, 0.91]

export function connect() {
  addPart("punch", "fringes", { kind: "image", picture: null, smooth: true }, "substrate")
  frame(["picture"], () => { if (me.picture) drawFringes(me.picture.run, me.picture.k) })
  for (const [id, name] of [["stress", "fringes"], ["fringe", "fringe"]]) {
    const choice = by(id), usual = choice.value
    choice.value = kept(name)
    choice.value ||= usual
    on(id, "change", () => {
      keep(name, choice.value)
      redrawPunch()
    })
  }
}

const chosen = () => by("stress").value
const keyOf = (component) => one(`.of-stress[data-stress=${component}]`)
const perFringe = () => Number(by("fringe").value) // GPa, for all runs: only the user changes it

// The key of what is drawn: the colours of the first orders or of both signs, and the stress at which they end
const keyed = memory()
function drawKey(what) {
  if (!keyed(theme(), perFringe(), what)) return
  one(".of-fringe").hidden = what !== "fringes"
  for (const key of all(".of-stress")) key.hidden = key.dataset.stress !== what
  const most = digits(ORDERS * perFringe(), 2)
  by("fringe-most").textContent = `${most} GPa`
  if (what === "fringes") drawBar(by("fringe-bar"), inksOf(theme()).subarray(0, ORDERS * SHADES))
  if (!(what in COMPONENTS)) return
  keyOf(what).querySelector(".stress-low").textContent = `−${most}`
  keyOf(what).querySelector(".stress-high").textContent = `+${most} GPa`
  drawBar(keyOf(what).querySelector("canvas"), signedInks(what, theme()))
}

function drawBar(bar, inks) {
  Object.assign(bar, { width: inks.length, height: 1 })
  const pen = bar.getContext("2d"), pixels = pen.createImageData(bar.width, 1)
  new Uint32Array(pixels.data.buffer).set(inks)
  pen.putImageData(pixels, 0, 0)
}

// The table for what is shown of a run, once it is there, and how deep that is, in depths of the table
function tableNow({ head: { scene } }, half) {
  const modes = Math.max(32, Math.min(128, Math.ceil((WAVES * scene.width) / half)))
  const wanted = { rows: ROWS, modes, depth: Math.min(half, scene.height * scene.width) }
  const table = tableFor(scene, wanted) ?? tableMeanwhile(scene, wanted)
  return { table, deep: wanted.depth / table?.asked.depth }
}

function drawFringes(run, k) {
  const { punch } = charts, box = isShown(by("punch-view")) ? punch.box : null
  if (!box) return
  const { table, deep } = chosen() === "plain" || run.head.flat || run.apart ? {} : tableNow(run, punch.x.end)
  drawKey(table ? chosen() : "plain") // the table may still be on its way
  punch.fill("fringes", { picture: table ? sheet : null })
  if (!table) return
  const size = me.dragging ? COARSE : FINE, orders = ordersIn(run, k, table, punch.x.end, size)
  const { start, end } = punch.x, low = punch.y.start, high = punch.y.end - BAR / box.up
  paintSheet(run, k, { ...size, orders, half: end, low, top: high, depth: deep })
  const light = chosen() in COMPONENTS ? SIGNED : LIGHT, alpha = theme() === "dark" ? DARK : light
  punch.fill("fringes", { x: start, wide: end - start, y: high, high: low - high, alpha })
}

// The body in the pixels of a small picture of the view below the top: each column of material from where its surface
// is to where it hangs on the top. half: of the width, low and high: the ends of the height, nm; depth: of what is
// shown, in parts of the table
function paintSheet(run, k, { wide, high: tall, columns, rows, orders, half, low, top: high, depth }) {
  if (sheet.width !== wide) Object.assign(sheet, { width: wide, height: tall })
  const pen = sheet.getContext("2d"), pixels = pen.createImageData(wide, tall)
  const shades = new Uint32Array(pixels.data.buffer)
  const { drawn: x, gap, times } = drawnFrame(run, k), { first, spacing, middle } = run.headOf(k)
  const U_x = times * run.top(k)
  const signed = chosen() in COMPONENTS, nm = (2 * half) / wide, step = (high - low) / tall
  const inks = signed ? signedInks(chosen(), theme()) : inksOf(theme()), zero = signed ? ORDERS * SHADES : 0
  for (let c = 0, i = 0; c < wide; c++) {
    const at = -half + (c + 0.5) * nm
    while (i < x.length - 2 && x[i + 1] < at) i++
    const between = (at - x[i]) / (x[i + 1] - x[i])
    if (!(between >= 0 && between <= 1)) continue
    const surface = gap[i] + (gap[i + 1] - gap[i]) * between, u = at - ((first + i + between) * spacing - middle)
    const deep = high - surface
    const last = Math.min(tall, Math.ceil((high - surface) / step))
    for (let r = 0; r < last; r++) {
      const t = Math.max(0, 1 - ((r + 0.5) * step) / deep), column = (at - u - (U_x - u) * t + half) / nm - 0.5
      const row = t * depth * rows - (0.5 * rows) / ROWS
      const j = Math.max(0, Math.min(columns - 2, Math.floor((column * columns) / wide)))
      const l = Math.max(0, Math.min(rows - 2, Math.floor(row)))
      const p = Math.max(0, Math.min(1, (column * columns) / wide - j)), q = Math.max(0, Math.min(1, row - l))
      const n = l * columns + j
      const fringe = (orders[n] * (1 - p) + orders[n + 1] * p) * (1 - q)
        + (orders[n + columns] * (1 - p) + orders[n + columns + 1] * p) * q
      shades[r * wide + c] = inks[Math.max(0, Math.min(inks.length - 1, zero + Math.round(fringe * SHADES)))]
    }
  }
  pen.putImageData(pixels, 0, 0)
}

// The colours of fringe orders, as bytes: bright where nothing is sheared on a light page, dark on a dark one
const inked = {}
function inksOf(ground) {
  return (inked[ground] ??=
    Uint32Array.from({ length: 16 * SHADES }, (_, i) => CHANNELS.reduce((ink, longer, channel) => {
    const light = 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / SHADES / longer)
    return (ink | (Math.round(255 * (ground === "dark" ? light : 1 - light)) << (8 * channel))) >>> 0
  }, 0xff000000)))
}

// The colours of a component from -ORDERS to ORDERS fringes, as bytes: that of the page where there is no stress
const signs = {}
function signedInks(component, ground) {
  const { below, above } = keyOf(component).dataset
  return (signs[`${component} ${ground}`] ??= Uint32Array.from({ length: 2 * ORDERS * SHADES + 1 }, (_, i) => {
    const part = i / (ORDERS * SHADES) - 1
    return mixed(bytes("--page"), bytes(part < 0 ? below : above), Math.abs(part))
  }))
}

// Fringe orders, or a component in fringes (rows, columns), from the tractions of frame k, the row at the surface first
function ordersIn(run, k, table, half, { columns, rows }) {
  const component = COMPONENTS[chosen()], per = perFringe(), x = middles(columns, half), every = ROWS / rows
  if (component) return sumsIn(run, k, table, x, [component], every)[0].map((value) => value / per)
  const [apart, sheared] = sumsIn(run, k, table, x, [APART, SHEARED], every)
  return apart.map((a, i) => Math.sqrt(a * a + sheared[i] * sheared[i]) / per)
}
