// Drawing on a canvas: text, arrows, and the colours of style.css.

import { colour, sizeOf, textSize } from "./colours.js"

// The pen of an emptied canvas, in pixels of the page; null while it has no size
export function cleared(canvas) {
  const [width, height] = sizeOf(canvas), ratio = window.devicePixelRatio || 1
  if (!width || !height) return null
  if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
    canvas.width = Math.round(width * ratio)
    canvas.height = Math.round(height * ratio)
  }
  const pen = canvas.getContext("2d")
  pen.setTransform(ratio, 0, 0, ratio, 0, 0)
  pen.clearRect(0, 0, width, height)
  return pen
}

// A line through places, px
export function line(pen, places, ink, width = 1) {
  pen.strokeStyle = ink
  pen.lineWidth = width
  pen.beginPath()
  for (const place of places) pen.lineTo(...place)
  pen.stroke()
}

// What is drawn within a rectangle only
export function within(pen, { left, top, width, height }, draw) {
  pen.save()
  pen.beginPath()
  pen.rect(left, top, width, height)
  pen.clip()
  draw()
  pen.restore()
}

const INKS = ["page", "text", "soft", "body", "shear", "normal", "slip", "repulsive", "adhering", "free", "grid",
  "area"]
export const inks = () => Object.fromEntries(INKS.map((name) => [name, colour(`--${name}`)]))

export const size = textSize

export const font = (scale = 1, bold = false) =>
  `${bold ? "600 " : ""}${Math.round(textSize() * scale)}px system-ui, "Segoe UI", Roboto, sans-serif`

// Text with a rim of the page's colour, so that it is legible over anything; returns from where to where it reaches.
// Where it would leave the box it is moved, or, if it `stays` where it is, left out
export function write({ pen, ink, box }, text, x, y,
  { of = ink.text, align = "center", bold = false, scale = 1, stays = false } = {}) {
  pen.font = font(scale, bold)
  pen.textAlign = "left"
  const width = pen.measureText(text).width
  x -= { left: 0, center: width / 2, right: width }[align]
  if (stays && (x < box.left + 4 || x + width > box.left + box.width - 4)) return null
  if (box) x = Math.max(box.left + 4, Math.min(x, box.left + box.width - width - 4)) // all of it in sight
  pen.textBaseline = "middle"
  pen.lineJoin = "round"
  pen.lineWidth = 4
  pen.strokeStyle = ink.page
  pen.strokeText(text, x, y)
  pen.fillStyle = of
  pen.fillText(text, x, y)
  return [x, x + width]
}

// A shaft with a head, from a place by (dx, dy), px
export function arrow({ pen, ink }, [x, y], [dx, dy], of) {
  const length = Math.hypot(dx, dy)
  if (length < 2) return
  const head = Math.min(10, length), [ux, uy] = [dx / length, dy / length]
  const tip = [x + dx, y + dy], neck = [x + dx - head * ux, y + dy - head * uy]
  for (const [style, width] of [[ink.page, 7], [of, 4]]) line(pen, [[x, y], neck], style, width)
  pen.fillStyle = of
  pen.beginPath()
  pen.moveTo(...tip)
  pen.lineTo(neck[0] - 0.6 * head * uy, neck[1] + 0.6 * head * ux)
  pen.lineTo(neck[0] + 0.6 * head * uy, neck[1] - 0.6 * head * ux)
  pen.fill()
}
