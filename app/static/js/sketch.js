// While a hand moves a slider, axes stay and only what lies between them changes: that is drawn here, on a canvas over each
// figure, for Bokeh would paint axes and all anew, in ten times as long. What is sketched looks as Bokeh draws it.

import { frameBox, lookOf } from "./bokeh.js"
import { make } from "./dom.js"
import { cleared, within } from "./pen.js"

const sheets = {} // view: {canvas, columns: {label: columns}, changed}

// Keep the columns of a part of a view until `drawSketches`
export function put(view, label, columns) {
  const sheet = (sheets[view] ??= { canvas: over(view), columns: {} })
  sheet.columns[label] = columns
  sheet.changed = true
}

export function over(view) {
  const canvas = make("canvas", { className: "story" })
  const place = document.querySelector(`.view[data-view="${view}"]`) ?? document.getElementById(`${view}-view`)
  place.insertBefore(canvas, place.querySelector(".story")) // under what is written there
  return canvas
}

export function wipe(view) {
  if (!sheets[view]) return
  cleared(sheets[view].canvas)
  sheets[view].columns = {}
}

// figures: {view: figure}, parts: {view: {label: renderer}}
export function drawSketches(figures, parts) {
  for (const view in sheets) {
    const sheet = sheets[view]
    if (!sheet.changed) continue
    sheet.changed = false
    const box = frameBox(figures[view]), pen = cleared(sheet.canvas)
    if (!box || !pen) continue
    within(pen, box, () => {
      for (const label in parts[view]) { // in the order in which Bokeh draws them
        if (sheet.columns[label]) drawPart(pen, lookOf(parts[view][label]), sheet.columns[label], box)
      }
    })
  }
}

function drawPart(pen, look, columns, { X, Y }) {
  if (look.mapper) return drawImage(pen, look.mapper, columns, X, Y)
  const x = columns[look.x], y = columns[look.y]
  pen.strokeStyle = look.stroke
  pen.fillStyle = look.fill
  pen.lineWidth = look.width
  pen.setLineDash(look.dash)
  pen.beginPath()
  if (look.marker) for (let i = 0; i < x.length; i++) MARKS[look.marker](pen, X(x[i]), Y(y[i]), look.size / 2)
  else for (let i = 0; i < x.length; i++) pen.lineTo(X(x[i]), Y(y[i]))
  if (look.fill) {
    pen.globalAlpha = look.alpha
    pen.fill()
    pen.globalAlpha = 1
  }
  if (look.stroke) pen.stroke()
}

const polygon = (...corners) => (pen, x, y, r) => {
  corners.forEach(([u, v], i) => (i ? pen.lineTo(x + r * u, y + r * v) : pen.moveTo(x + r * u, y + r * v)))
  pen.closePath()
}
const MARKS = { // as of Bokeh, of half their size
  circle: (pen, x, y, r) => { pen.moveTo(x + r, y); pen.arc(x, y, r, 0, 7) },
  square: polygon([-1, -1], [1, -1], [1, 1], [-1, 1]),
  diamond: polygon([0, -1], [2 / 3, 0], [0, 1], [-2 / 3, 0]),
  inverted_triangle: polygon([-1, -Math.sqrt(3) / 3], [1, -Math.sqrt(3) / 3], [0, (2 * Math.sqrt(3)) / 3]),
}

const canvas = document.createElement("canvas") // an image before it is stretched
let inks = null, inked = null // the shades of a palette, as bytes, and of which
function drawImage(pen, { palette, low, high }, { image: [image], x: [x], y: [y], dw: [dw], dh: [dh] }, X, Y) {
  const [rows, columns] = image.shape
  if (inked !== palette) {
    inked = palette
    inks = Uint32Array.from(palette, (text) => (0xff000000 | Number(`0x${text.slice(5, 7)}${text.slice(3, 5)}${text.slice(1, 3)}`)) >>> 0)
  }
  Object.assign(canvas, { width: columns, height: rows })
  const brush = canvas.getContext("2d"), data = brush.createImageData(columns, rows), pixels = new Uint32Array(data.data.buffer)
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      const value = image[i * columns + j]
      if (Number.isNaN(value)) continue
      const shade = Math.floor(((value - low) / (high - low)) * inks.length)
      pixels[(rows - 1 - i) * columns + j] = inks[Math.max(0, Math.min(inks.length - 1, shade))]
    }
  }
  brush.putImageData(data, 0, 0)
  pen.imageSmoothingEnabled = false
  pen.drawImage(canvas, X(x), Y(y + dh), X(x + dw) - X(x), Y(y) - Y(y + dh))
}
