// The page "Inside the solid": asks for the picture of the increment shown, as soon as the one before is there.

import { set } from "../bokeh.js"
import { ask, opened as unpacked } from "../channel.js"
import { nice, shades } from "../colours.js"
import { by, on } from "../dom.js"
import { extent, figures, fill, fillImage, painted as paintedTogether, parts, tellLimits, tellStretch } from "../figures.js"
import { me } from "../state.js"

const BENEATH = 0.06 // of the depth, below the picture, for the deformed surface
const LOST = 2000 // ms after which a picture that did not come is asked for again
const GREYS = Array.from({ length: 256 }, (_, i) => `#${i.toString(16).padStart(2, "0").repeat(3)}`)

let open = false, palette = [], stresses = {} // colours of a quantity without sign; all quantities (app/schema.py)
let asked = null, since = 0 // what is in the making, and since when
let done = null, shown = null // what is on screen, as it was asked for, and as [quantity, run]
let limits = {} // of the run on screen

function askPicture(again = false) {
  if (!open || !me.run?.length || me.drawn < 0) return
  const wanted = { run: me.run.number, frame: Math.min(me.drawn, me.run.length - 1), half: figures.punch.x_range.end,
    quantity: by("solid-quantity").value, per_fringe: Number(by("solid-fringe").value), mesh: by("solid-mesh").checked }
  const key = JSON.stringify(wanted), now = performance.now()
  if ((asked && now - since < LOST) || (key === done && !again)) return
  asked = key
  since = now
  ask(wanted)
}

export function pictured(buffer) {
  if (!buffer) return
  const { head, start } = unpacked(buffer)
  const { rows, columns, scale, half, depth, points, quantity, run, factor } = head
  const size = rows * columns
  const image = Float32Array.from(new Int16Array(buffer.slice(start, start + 2 * size)), (v) => v * scale)
  const lines = buffer.slice(start + 2 * size)
  done = asked
  asked = null
  paintedTogether(() => {
    fillImage("solid_field", "field", image, [rows, columns], { x: [-half], y: [0], dw: [2 * half], dh: [depth] })
    fill("solid_field", "mesh", { x: new Float32Array(lines, 0, points), z: new Float32Array(lines, 4 * points, points) })
    set(figures.solid_field.x_range, { start: -half, end: half })
    set(figures.solid_field.y_range, { start: points ? -BENEATH * depth : 0, end: depth })
    shown = [quantity, run]
    shade(image)
    nameQuantity(quantity)
    tellStretch()
  })
  const largest = quantity === "fringes" ? "" : `largest ${Math.max(...extent(image).map(Math.abs)).toPrecision(3)} GPa`
  const mesh = points ? `mesh: displacements × ${factor}, the top at rest; stress over the undeformed layer` : ""
  by("solid-said").textContent = [largest, mesh].filter(Boolean).join("; ")
  askPicture()
}

// What the view shows now, and the key of its colours
function nameQuantity(quantity) {
  const { name, below: [low, , less], above: [high, , more] } = stresses[quantity]
  by("solid-name").textContent = name
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
function shade(image) {
  const [quantity, run] = shown
  const mapper = parts.solid_field.field.glyph.color_mapper
  if (quantity === "fringes") return set(mapper, { low: 0, high: 1, palette: GREYS })
  const key = `${quantity} ${run}`
  const [low, high] = extent(limits[key] ?? [0, 0], image)
  limits = { [key]: [low, high] }
  const top = nice(Math.max(-low, high)), { below: [, less], above: [, more] } = stresses[quantity]
  set(mapper, less ? shades(-top, top, [less, more]) : { low: 0, high: top, palette })
  tellLimits("solid_field", -top, top)
}

export function told(news) {
  if (news.palette) ({ palette, stresses } = news)
}
export const frame = () => askPicture()
export const painted = () => { if (shown) shade([]) }

export function opened() {
  open = true
  asked = done = shown = null
}

export const closed = () => { open = false }

export function connect() {
  for (const id of ["solid-quantity", "solid-fringe", "solid-mesh"]) on(id, "input", () => {
    by("solid-fringe-row").hidden = by("solid-quantity").value !== "fringes"
    by("solid-fringe-value").textContent = `${Number(by("solid-fringe").value).toFixed(2)} GPa`
    asked = null
    askPicture(true)
  })
}
