// Under the punch, over the same places: the tractions as two bands, so that what holds and what slips is seen where it
// happens.

import { ticksOf } from "./chart.js"
import { charts } from "./charts.js"
import { isShown, sizeOf } from "./colours.js"
import { LEAST } from "./curves.js"
import { by } from "./dom.js"
import { inks, line, size, within, write } from "./pen.js"
import { drawnFrame } from "./punch.js"
import { me } from "./store.js"

const GAP = 10 // px between both
const LABEL = 4 // times the size of the text, for a number of a place
const ABOVE = 1.3 // times the size of the text, for what is above zero

export function drawBands(pen, box) {
  if (!me.picture || !isShown(by("bands"))) return
  const { run, k } = me.picture, { drawn: x, T_n, T_t } = drawnFrame(run, k)
  const ink = inks(), { start, end } = charts.punch.x
  const from = sizeOf(by("punch-view"))[1], row = 1.35 * size(), high = from + sizeOf(by("bands"))[1] - row - 4
  const normal = {
    of: T_n, up: Math.max(run.T_high, LEAST), low: Math.min(run.T_low, -LEAST), inks: [ink.repulsive, ink.adhering],
    says: ["pushes apart", "pulls together"],
  }
  const shear = {
    of: T_t, up: Math.max(run.T_out, LEAST), low: run.T_back, inks: [ink.shear, ink.shear], says: ["holds back", ""],
  }
  // of both the same; a low one gets the room above zero that its label needs
  const bands = [normal, shear], least = ABOVE * size()
  const scaleOf = (low) => (high - from - bands.length * GAP - low.length * least)
    / bands.reduce((GPa, band) => GPa - band.low + (low.includes(band) ? 0 : band.up), 0)
  const whole = scaleOf([]), scale = scaleOf(bands.filter(({ up }) => up * whole < least))
  if (scale <= 0) return // no room
  const view = { pen, ink, box }
  let top = from
  for (const band of bands) {
    const zero = top + GAP / 2 + Math.max(band.up * scale, least), bottom = zero - band.low * scale + GAP / 2
    drawBand(view, { ...band, top, zero, bottom, scale }, x)
    top = bottom
  }
  drawScale(view, from + GAP / 2, scale, row, high)
  drawPlaces(view, start, end, high + 2, row)
}

function drawBand({ pen, ink, box }, { of, top, zero, bottom, scale, inks: [over, under], says }, x) {
  const Y = (v) => zero - v * scale, { left, width, X } = box
  within(pen, { left, top, width, height: bottom - top }, () => {
    for (const [keep, colour] of [[(v) => Math.max(v, 0), over], [(v) => Math.min(v, 0), under]]) {
      const places = Array.from(x, (at, i) => [X(at), Y(keep(of[i]))])
      line(pen, [[X(x[0]), Y(0)], ...places, [X(x.at(-1)), Y(0)]], colour, 1.5)
      pen.fillStyle = colour
      pen.globalAlpha = 0.28
      pen.fill()
      pen.globalAlpha = 1
    }
    line(pen, [[left, Y(0)], [left + width, Y(0)]], ink.soft)
  })
  const view = { pen, ink, box }
  const text = (label, y, colour) => write(view, label, box.left + 8, y, { of: colour, align: "left", scale: 0.95 })
  const above = zero - 0.75 * size(), below = zero + 1.15 * size(), pushes = !says[1] || of.some((T) => T > 0)
  if (pushes) text(says[0], above, over)
  if (below + 0.5 * size() < bottom) text(says[1], below, under)
  else if (!pushes) text(says[1], above, under)
}

const NICE = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200] // GPa

// A bar for so many GPa beside both bands, which ends above the numbers of the places
function drawScale({ pen, ink, box }, top, scale, row, bottom) {
  const fitting = NICE.filter((GPa) => top + GPa * scale < bottom - 0.5 * row), x = box.left - 10
  const bar = fitting.find((GPa) => GPa * scale > 1.5 * row) ?? fitting.at(-1)
  if (!bar) return
  line(pen, [[x, top], [x, top + bar * scale]], ink.soft, 2)
  write({ pen, ink }, `${bar} GPa`, x - 5, top + 0.5 * bar * scale, { of: ink.soft, align: "right", scale: 0.9 })
}

function drawPlaces({ pen, ink, box: { X, width } }, start, end, y, row) {
  const most = Math.min(8, width / (LABEL * size())) // numbers side by side
  for (const [at, text] of ticksOf({ start, end }, most)) {
    line(pen, [[X(at), y - 2], [X(at), y + 3]], ink.soft)
    write({ pen, ink }, `${text}${at === 0 ? " nm" : ""}`, X(at), y + 0.65 * row, { of: ink.soft, scale: 0.95 })
  }
}
