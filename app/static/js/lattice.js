// Nodes, lattice sites and the springs between them, to scale; for flats over all of the picture.

import { MARKERS } from "./chart.js"
import { charts } from "./charts.js"
import { line, write } from "./pen.js"
import { BAR } from "./punch.js"
import { fixed } from "./quantities.js"

export const APART = 2.4 // nm that nodes are drawn above where they are, so that springs are seen in contact
const REACH = 2.2 // delta_t: springs longer than that are too weak to be drawn

// Substrate, sites, springs and nodes between two places; x and y give pixels of lengths in nm
export function drawAtoms({ pen, frame, run, k, ink }, x, y, scale, from, to) {
  const { spacing, middle, delta_t, delta_n } = run.headOf(k), dot = Math.min(9, 0.28 * spacing * scale)
  pen.fillStyle = ink.grid
  pen.fillRect(x(from) - 1, y(0), x(to) - x(from) + 2, 1000)
  const up = (i) => y(frame.gap[i] + APART), site = (j) => j * spacing - middle
  const inside = [...frame.x.keys()].filter((i) => frame.x[i] > from - spacing && frame.x[i] < to + spacing)
  for (const i of inside) { // a spring is the stronger drawn the stronger it pulls
    const close = Math.round((frame.x[i] + middle) / spacing)
    for (let j = close - 3; j <= close + 3; j++) {
      const stretch = (site(j) - frame.x[i]) / delta_t
      if (Math.abs(stretch) > REACH) continue
      const strength = Math.exp(-stretch * stretch) * Math.min(1, Math.exp(-frame.gap[i] / delta_n))
      if (strength < 0.02) continue
      pen.globalAlpha = 0.2 + 0.8 * Math.min(1, strength)
      line(pen, [[x(frame.x[i]), up(i)], [x(site(j)), y(0)]], ink.shear, 1 + 2.5 * strength)
    }
  }
  pen.globalAlpha = 1
  pen.fillStyle = ink.text
  for (let j = Math.floor((from + middle) / spacing); site(j) < to + spacing; j++)
    pen.fillRect(x(site(j)) - 0.7 * dot, y(0) - 0.7 * dot, 1.4 * dot, 1.4 * dot)
  for (const i of inside) {
    const state = frame.state(i)
    pen.fillStyle = state === "contact" ? ink.shear : ink[state]
    pen.strokeStyle = ink.page
    pen.lineWidth = 1.5
    pen.beginPath()
    if (state === "adhering") MARKERS.inverted_triangle(pen, x(frame.x[i]), up(i), 2.4 * dot) // as in the legend
    else pen.arc(x(frame.x[i]), up(i), dot, 0, 7)
    pen.fill()
    pen.stroke()
  }
}

// Flat on flat: all nodes move alike, each on an elastic line to the top; a picture of its own in place of the punch
export function drawLattice(view) {
  const { pen, box, narrow, X, Y, frame, run, k, ink } = view, { spacing } = run.head
  const { start: from, end: to } = charts.punch.x, scale = box.across, low = Y(0)
  pen.fillStyle = ink.page
  pen.fillRect(box.left, box.top, box.width, box.height)
  const stretch = run.top(k) - run.least(k)
  for (const at of frame.x) {
    if (at < from - 3 * spacing || at > to + 3 * spacing) continue
    line(pen, [[X(at), low - APART * scale], [X(at + stretch), box.top + BAR]], ink.body, 2)
  }
  drawAtoms(view, X, (y) => low - y * scale, scale, from, to)
  const text = `${narrow ? "layer" : "the elastic layer,"} sheared by ${fixed(stretch, 1)} nm`
  write(view, text, box.left + 0.5 * box.width, box.top + 0.4 * box.height)
}
