// A chart on a canvas: axes, a grid, and parts that are painted in order. Sizes are in px of the page.

import { colour, isShown, sizeOf, textSize } from "./colours.js"
import { minus } from "./quantities.js"
import { cleared, font, within } from "./pen.js"

const LEFT = 76, RIGHT = 14, TOP = 6, BOTTOM = 4 // beside the frame: the same in all charts, so that axes line up
const WIDE = 3.6 // sizes of a letter that numbers and name of the upright axis take
const LARGE = 15, THICK = 2.5 // text larger than that is for a projector: then lines are so many times as thick
const TICK = 5, NEAR = 12 // of a tick; from the mouse to a text about what it points at
const ACROSS = 4.2, DOWN = 2.6 // sizes of the text, from one number of an axis to the next, at least
const MOST = 6 // numbers of an axis upwards
export const MARKERS = { // paths of marks of a size
  circle: (pen, x, y, size) => {
    pen.moveTo(x + size / 2, y)
    pen.arc(x, y, size / 2, 0, 2 * Math.PI)
  },
  square: (pen, x, y, size) => pen.rect(x - size / 2, y - size / 2, size, size),
  diamond: (pen, x, y, size) => polygon(pen, x, y, [[0, -size / 2], [size / 3, 0], [0, size / 2], [-size / 3, 0]]),
  inverted_triangle: (pen, x, y, size) => {
    polygon(pen, x, y, [[-0.5, -0.29], [0.5, -0.29], [0, 0.58]].map((corner) => corner.map((at) => at * size)))
  },
  right: (pen, x, y, size) => polygon(pen, x, y, [[-size / 2, -size / 2], [size / 2, 0], [-size / 2, size / 2]]),
  left: (pen, x, y, size) => polygon(pen, x, y, [[size / 2, -size / 2], [-size / 2, 0], [size / 2, size / 2]]),
}

function polygon(pen, x, y, corners) {
  pen.moveTo(x + corners[0][0], y + corners[0][1])
  for (const [across, down] of corners.slice(1)) pen.lineTo(x + across, y + down)
  pen.closePath()
}

// The steps between numbers: 1, 2 or 5 times a power of ten
function stepFor(length, most) {
  const least = length / Math.max(most, 1), ten = 10 ** Math.floor(Math.log10(least))
  return [1, 2, 5, 10].map((times) => times * ten).find((step) => step >= least * (1 - 1e-9))
}

// Numbers of an axis within a range, at most so many: [value, text]; of those that it has itself every second or so
export function ticksOf({ start, end, ticks }, most) {
  if (ticks) return ticks.filter((_, i) => i % Math.ceil(ticks.length / most) === 0)
  const step = stepFor(end - start, most), places = Math.max(0, -Math.floor(Math.log10(step) + 1e-9))
  const first = Math.ceil(start / step - 1e-9), count = Math.floor(end / step + 1e-9) - first + 1
  return Array.from({ length: Math.max(0, count) }, (_, i) => {
    const value = (first + i) * step
    return [value, minus((value || 0).toFixed(places))]
  })
}

// The value that an image shows at a place {x, y}; NaN where it shows none
export function valueAt({ picture, values, rows, columns, x, y, wide, high }, place) {
  const column = Math.floor(((place.x - x) / wide) * columns), row = Math.floor(((place.y - y) / high) * rows)
  const inside = picture && column >= 0 && column < columns && row >= 0 && row < rows
  return inside ? values[row * columns + column] : NaN
}

// Painters of the kinds of parts; thick: how many times as thick as on a desk
const PAINTERS = {
  // {x, y, ink, width, dash}; with a gap where a number is NaN
  line(pen, { X, Y }, { x, y, ink, width = 1, dash = [] }, thick) {
    pen.setLineDash(dash.map((length) => length * Math.max(1, thick / 2)))
    pen.strokeStyle = colour(ink)
    pen.lineWidth = width * thick
    pen.beginPath()
    for (let i = 0, down = false; i < x.length; i++) {
      const at = X(x[i]), up = Y(y[i]), there = up === up && at === at
      if (there && down) pen.lineTo(at, up)
      else if (there) pen.moveTo(at, up)
      down = there
    }
    pen.stroke()
    pen.setLineDash([])
  },
  lines(pen, box, { list }, thick) { for (const one of list) PAINTERS.line(pen, box, one, thick) },
  // {x, y, marker, size, ink, hollow}; all of a kind are one path, as one by one they take longest
  marks(pen, { X, Y }, { x, y, marker, size, ink, hollow }, thick) {
    pen.fillStyle = pen.strokeStyle = colour(ink)
    pen.lineWidth = hollow ? 1.5 * thick : 1
    pen.beginPath()
    for (let i = 0; i < x.length; i++) {
      const kind = Array.isArray(marker) ? marker[i] : marker
      MARKERS[kind](pen, X(x[i]), Y(y[i]), size * Math.sqrt(thick))
    }
    if (hollow) pen.stroke()
    else pen.fill()
  },
  // {x, y, ink, alpha}: what lies between a curve and the top of the frame
  body(pen, { X, Y, top }, { x, y, ink, alpha }) {
    if (!x.length) return
    pen.beginPath()
    for (let i = 0; i < x.length; i++) pen.lineTo(X(x[i]), Y(y[i]))
    pen.lineTo(X(x.at(-1)), top)
    pen.lineTo(X(x[0]), top)
    pen.globalAlpha = alpha
    pen.fillStyle = colour(ink)
    pen.fill()
    pen.globalAlpha = 1
  },
  // {ink, alpha}: all below zero
  below(pen, { Y, left, width, top, height }, { ink, alpha }) {
    pen.globalAlpha = alpha
    pen.fillStyle = colour(ink)
    pen.fillRect(left, Y(0), width, Math.max(0, top + height - Y(0)))
    pen.globalAlpha = 1
  },
  // {picture, x, y, wide, high, smooth, alpha}: a canvas over a rectangle, its first row at y
  image(pen, { X, Y }, { picture, x, y, wide, high, smooth = false, alpha = 1 }) {
    if (!picture) return
    pen.save()
    pen.imageSmoothingEnabled = smooth
    pen.globalAlpha = alpha
    pen.translate(X(x), Y(y))
    pen.scale((X(x + wide) - X(x)) / picture.width, (Y(y + high) - Y(y)) / picture.height)
    pen.drawImage(picture, 0, 0)
    pen.restore()
  },
  // {list: [middle, width], ink}: hatched stripes from bottom to top
  stripes(pen, { X, top, height }, { list, ink }) {
    pen.strokeStyle = colour(ink)
    for (const [middle, wide] of list) {
      const left = X(middle - wide / 2), width = X(middle + wide / 2) - left
      within(pen, { left, top, width, height }, () => {
        pen.lineWidth = 2
        pen.beginPath()
        for (let at = -height; at < width; at += 8) {
          pen.moveTo(left + at, top + height)
          pen.lineTo(left + at + height, top)
        }
        pen.stroke()
      })
    }
  },
  // {at, ink, width}: a line across or upright
  across(pen, box, { ink }, thick) {
    PAINTERS.line(pen, { X: (x) => x, Y: box.Y }, { x: [box.left, box.left + box.width], y: [0, 0], ink }, thick)
  },
  upright(pen, box, { at, ...look }, thick) {
    const ends = [box.top, box.top + box.height]
    PAINTERS.line(pen, { X: box.X, Y: (y) => y }, { x: [at, at], y: ends, ...look }, thick)
  },
  // {draw}: what another script draws
  drawing(pen, box, { draw }) { draw(pen, box) },
}

export class Chart {
  changed = true // since it was painted
  axis = true // whether the axis under it is
  pointed = null // where the mouse is, {x, y} px in the canvas
  under = () => {} // draws what lies under the axes
  says = () => null // lines of text about a place {x, y}, given also in px of the canvas; null: nothing

  // parts: {label: {kind, ...}}, painted in this order
  constructor(view, { x, y, across, up, parts }) {
    Object.assign(this, { view, x, y, across, up, parts })
    this.canvas = view.closest("figure").querySelector(".chart")
  }

  // Change what a part is made of
  fill(label, values) {
    Object.assign(this.parts[label], values)
    this.changed = true
  }

  // Where the mouse points, {x, y} px in the canvas, or null
  point(at) {
    if (at === this.pointed) return
    this.pointed = at
    this.changed = true
  }

  // Change a range, {start, end}, of x or y
  range(name, values) {
    const range = this[name]
    if (Object.entries(values).every(([end, value]) => range[end] === value)) return
    Object.assign(range, values)
    this.changed = true
  }

  // The frame within the axes, px, and the px of its places; null while it is not in sight
  get box() {
    const [wide, high] = sizeOf(this.view), size = textSize(), { x, y } = this
    const under = this.axis ? TICK + 2.6 * size + 8 : BOTTOM
    const left = Math.max(LEFT, WIDE * size) // room for the numbers of a projector, too
    const width = wide - left - (size > LARGE ? 34 : RIGHT), height = high - TOP - under
    if (!(width > 0 && height > 0)) return null
    const across = width / (x.end - x.start), up = height / (y.end - y.start) // px of a unit
    return { left, top: TOP, width, height, across, up,
      X: (at) => left + (at - x.start) * across, Y: (at) => TOP + (y.end - at) * up }
  }

  // The place in the chart of a place in the canvas, px
  placeOf({ x, y }) {
    const { left, top, across, up } = this.box
    return { x: this.x.start + (x - left) / across, y: this.y.end - (y - top) / up }
  }

  paint() {
    if (!this.changed || !isShown(this.view)) return
    const pen = cleared(this.canvas), { box } = this
    if (!pen || !box) return
    this.changed = false
    const thick = textSize() > LARGE ? THICK : 1
    this.#paintAxes(pen, box)
    within(pen, box, () => {
      for (const part of Object.values(this.parts)) PAINTERS[part.kind](pen, box, part, thick)
    })
    this.under(pen, box)
    if (this.pointed) this.#tell(pen, box)
  }

  #paintAxes(pen, { left, top, width, height, X, Y }) {
    const size = textSize(), bottom = top + height
    const rows = Math.min(this.y.ticks ? Infinity : MOST, Math.floor(height / (DOWN * size)))
    const upright = ticksOf(this.y, Math.max(2, rows))
    const along = ticksOf(this.x, Math.max(2, Math.floor(width / (ACROSS * size))))
    const stroke = (ink, alpha, path) => {
      pen.strokeStyle = colour(ink)
      pen.globalAlpha = alpha
      pen.lineWidth = 1
      pen.beginPath()
      path()
      pen.stroke()
      pen.globalAlpha = 1
    }
    const segment = (...ends) => ends.forEach(([x, y], i) => (
      i ? pen.lineTo(Math.round(x) + 0.5, Math.round(y) + 0.5) : pen.moveTo(Math.round(x) + 0.5, Math.round(y) + 0.5)))
    stroke("--grid", 0.5, () => {
      for (const [value] of along) segment([X(value), top], [X(value), bottom])
      for (const [value] of upright) segment([left, Y(value)], [left + width, Y(value)])
    })
    stroke("--grid", 1, () => segment([left, top], [left + width, top], [left + width, bottom]))
    stroke("--soft", 1, () => {
      segment([left, top], [left, bottom], [left + width, bottom])
      for (const [value] of upright) segment([left - TICK, Y(value)], [left, Y(value)])
      if (this.axis) for (const [value] of along) segment([X(value), bottom], [X(value), bottom + TICK])
    })
    pen.font = font()
    pen.fillStyle = colour("--soft")
    pen.textBaseline = "middle"
    pen.textAlign = "right"
    for (const [value, text] of upright) pen.fillText(text, left - TICK - 4, Y(value))
    pen.textAlign = "center"
    if (this.axis) for (const [value, text] of along) pen.fillText(text, X(value), bottom + TICK + 3 + 0.6 * size)
    pen.fillStyle = colour("--text")
    if (this.axis) pen.fillText(this.across, left + width / 2, bottom + TICK + 6 + 1.9 * size)
    const wide = Math.max(...upright.map(([, text]) => pen.measureText(text).width))
    pen.save()
    pen.translate(Math.max(0.6 * size + 1, left - TICK - 8 - wide - 0.7 * size), top + height / 2) // all of it in sight
    pen.rotate(-Math.PI / 2)
    pen.fillText(this.up, 0, 0, height + 2 * TOP)
    pen.restore()
  }

  // Text about what the mouse points at, on a ground of its own, within the frame
  #tell(pen, { left, top, width, height }) {
    const { x, y } = this.pointed
    const inside = x >= left && x <= left + width && y >= top && y <= top + height
    const texts = inside ? this.says(this.placeOf(this.pointed), this.pointed) : null
    if (!texts) return
    const row = 1.35 * textSize(), high = texts.length * row + 8
    pen.font = font()
    const wide = Math.max(...texts.map((text) => pen.measureText(text).width)) + 12
    const at = x + NEAR + wide < left + width ? x + NEAR : Math.max(left, x - NEAR - wide)
    const up = Math.min(Math.max(top, y - high / 2), top + height - high)
    pen.fillStyle = colour("--card")
    pen.strokeStyle = colour("--grid")
    pen.lineWidth = 1
    pen.beginPath()
    pen.roundRect(at, up, wide, high, 4)
    pen.fill()
    pen.stroke()
    pen.fillStyle = colour("--text")
    pen.textAlign = "left"
    pen.textBaseline = "middle"
    texts.forEach((text, i) => pen.fillText(text, at + 6, up + 4 + (i + 0.5) * row))
  }
}
