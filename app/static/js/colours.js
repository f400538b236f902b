// Colours, all of them from style.css, what of the page is visible, and the shades of maps.

import { root } from "./dom.js"

const SHADES = 128, MOST = 4096 // of one sign, at least where the limits are not too different; steps in all
const LEVELS = 4 // colours of style.css, between which levels are mixed

const TEXT = 0.88 // of the text of the page
// Variables of the page's styles, whether elements are visible, and their sizes: to ask lays the page out
let read = {}, shown = new WeakMap(), sizes = new WeakMap()

// Read them again: the theme, the size, or what is shown, has changed
export function readAgain() {
  read = {}
  shown = new WeakMap()
  sizes = new WeakMap()
}

export const colour = (name) =>
  (read[name] ??= getComputedStyle(root).getPropertyValue(name).trim())

export function isShown(element) {
  if (!shown.has(element)) shown.set(element, element.checkVisibility())
  return shown.get(element)
}

// [width, height] of an element, px: of whole pixels of the screen, to whose edges the browser moves a canvas
export function sizeOf(element) {
  if (!sizes.has(element)) {
    const { left, top, right, bottom } = element.getBoundingClientRect(), ratio = window.devicePixelRatio || 1
    const between = (from, to) => (Math.round(to * ratio) - Math.round(from * ratio)) / ratio
    sizes.set(element, [between(left, right), between(top, bottom)])
  }
  return sizes.get(element)
}

// px, of text in figures and on canvases
export const textSize = () => (
  read.size ??= Math.floor(TEXT * parseFloat(getComputedStyle(root).fontSize)))

export const theme = () => root.dataset.theme

// Red, green and blue mixed, as an opaque pixel of 32 bits
export const mixed = (from, to, part) => from.reduce((ink, value, i) => (
  (ink | (Math.round(value + part * (to[i] - value)) << (8 * i))) >>> 0), 0xff000000)

// Shades by the sign: two ramps that meet at zero, so that the sign is never in doubt. They are steps of one size, a
// whole number of them on either side of zero, hence the limits lie up to a step beyond low and high.
export function shades(low, high) {
  const step = Math.max(Math.min(-low, high) / SHADES, (high - low) / MOST)
  const ramp = (name, end) => {
    const [from, to] = [0, 1].map((i) => bytes(`--${name}-${i}`))
    const mixtures = Array.from({ length: SHADES }, (_, i) => mixed(from, to, i / (SHADES - 1)))
    const shade = (i) => mixtures[Math.min(SHADES - 1, Math.floor(((i + 0.5) * step * SHADES) / end))]
    return Array.from({ length: Math.ceil(end / step - 1e-9) }, (_, i) => shade(i))
  }
  const under = ramp("pull", -low), over = ramp("push", high)
  return { low: -step * under.length, high: step * over.length, palette: [...under.toReversed(), ...over] }
}

// Shades from the least value to the largest
export function levels(low, high) {
  const stops = Array.from({ length: LEVELS }, (_, i) => bytes(`--level-${i}`))
  const palette = Array.from({ length: 2 * SHADES }, (_, i) => {
    const at = (i / (2 * SHADES - 1)) * (LEVELS - 1), from = Math.min(Math.floor(at), LEVELS - 2)
    return mixed(stops[from], stops[from + 1], at - from)
  })
  return { low, high, palette }
}

// A canvas with a pixel for each of the values (rows, columns), shaded; those that are NaN are left free
export function pictureOf(values, [rows, columns], { low, high, palette }) {
  const step = (high - low) / palette.length, last = palette.length - 1
  const canvas = new OffscreenCanvas(columns, rows), pen = canvas.getContext("2d")
  const pixels = pen.createImageData(columns, rows), painted = new Uint32Array(pixels.data.buffer)
  values.forEach((value, i) => {
    if (value === value) painted[i] = palette[Math.min(Math.max(Math.floor((value - low) / step), 0), last)]
  })
  pen.putImageData(pixels, 0, 0)
  return canvas
}

// Red, green and blue of a colour
export const bytes = (name) => [1, 3, 5].map((i) => parseInt(colour(name).slice(i, i + 2), 16))

// The next larger number of one digit or so
export function nice(value) {
  const ten = 10 ** Math.floor(Math.log10(Math.max(value, 1e-6)))
  return Number([1, 1.5, 2, 3, 4, 5, 6, 8, 10].map((m) => m * ten).find((v) => v >= value * 0.999)?.toPrecision(3))
}
