// What is drawn over the punch with every frame: its material, its top, the nodes that slipped; features add theirs.

import { charts } from "./charts.js"
import { by, on, tell } from "./dom.js"
import { AFTER } from "./events.js"
import { drawLattice } from "./lattice.js"
import { inks, line, size } from "./pen.js"
import { BAR, drawnFrame, sideways } from "./punch.js"
import { digits } from "./quantities.js"
import { me } from "./store.js"

const LINES = 24 // of the mesh in the body, from the surface to the top
const NARROW = 440 // px, for text of 13 px: in a narrower view words are few

// Draw over the punch everything that belongs to the picture
export function drawStory(pen, box) {
  if (!me.picture) return
  const { run, k } = me.picture, { X, Y } = box, frame = drawnFrame(run, k), slip = run.slipBefore(k, AFTER)
  const view = { narrow: box.width < (NARROW * size()) / 13, pen, box, X, Y, frame, run, k, slip, ink: inks() }
  if (run.head.flat) drawLattice(view)
  else {
    drawMesh(view)
    if (slip !== null) drawMoved(view)
  }
  drawTop(view)
  for (const draw of OVER) draw(view)
}

export const OVER = [] // what features draw over all of it: draw(view)

export const times = (factor) => `${digits(factor, 2)} times`

// By how much the picture enlarges what it shows, in words
function tellScales() {
  const { box } = charts.punch, { run } = me
  if (!box || !run) return
  const moved = sideways(run), aside = moved > 1 ? ` and displacements sideways ${times(moved)}` : ""
  tell(by("scales"), run.head.flat ? "The picture is to scale."
    : `The picture shows heights ${times(box.up / box.across)}${aside} as large as lengths along the surface.`)
}

export const connectStory = () => on("solver", "beforetoggle", tellScales)

// Lines of the material, upright before loading: from a surface node to where it hangs on the top
function drawMesh({ pen, box, X, Y, frame, run, k, ink }) {
  const { nodes, first, spacing, middle } = run.headOf(k), every = Math.max(1, Math.round(nodes / LINES))
  const U_x = frame.times * run.top(k)
  pen.globalAlpha = 0.55
  for (let i = Math.floor(every / 2); i < nodes; i += every) {
    const hung = [X((first + i) * spacing - middle + U_x), box.top + BAR]
    line(pen, [[X(frame.drawn[i]), Y(frame.gap[i])], hung], ink.body)
  }
  pen.globalAlpha = 1
}

// The rigid top: a bar whose marks move with it, and what it does
function drawTop({ pen, box, X, frame, run, k, ink }) {
  const U_x = frame.times * run.top(k), { x: x_range } = charts.punch
  pen.fillStyle = ink.soft
  pen.fillRect(box.left, box.top, box.width, BAR)
  const pitch = run.head.flat ? run.head.spacing / 4 : 20, shift = U_x % pitch
  for (let x = Math.ceil((x_range.start - shift) / pitch) * pitch; x + shift < x_range.end; x += pitch) {
    line(pen, [[X(x + shift) - 3, box.top + BAR], [X(x + shift) + 3, box.top]], ink.page, 1.5)
  }
}

// The nodes that slipped flash, and fade as the top goes on
function drawMoved({ pen, X, Y, frame, run, k, slip, ink }) {
  const moved = run.moved(slip), shift = run.headOf(k).first - run.headOf(slip).first
  pen.lineCap = "round"
  pen.globalAlpha = 0.4 * (1 - ((k - slip) * run.head.step) / AFTER) // nodes are seen through it
  let stretch = []
  for (let i = 0; i <= frame.x.length; i++) {
    if (i in frame.x && moved[i + shift]) stretch.push([X(frame.drawn[i]), Y(frame.gap[i])])
    else line(pen, stretch.splice(0), ink.slip, 14)
  }
  pen.globalAlpha = 1
}
