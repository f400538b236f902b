// The story over the punch: who pulls, what holds, what lets go. Drawn with every frame.

import { charts } from "./charts.js"
import { by, on, tell } from "./dom.js"
import { AFTER } from "./events.js"
import { drawLattice } from "./lattice.js"
import { arrow, inks, line, size, write } from "./pen.js"
import { BAR, drawnFrame, sideways } from "./punch.js"
import { digits, fixed, withUnit } from "./quantities.js"
import { me, sees } from "./store.js"

const REST = 46 // px, a drive that is not stretched
const TURNS = 12 // of its spring
const LINES = 24 // of the mesh in the body, from the surface to the top
const ARROW = 90 // px, the longest
const NARROW = 440 // px, for text of 13 px: in a narrower view words are few
const LENS = 0.5 // of the width, beyond which the lens does not reach as the page opens
const WIDE = 52 // times the size of the text, from which there is room for whole sentences
const PATCHES = 8 // with a bracket each; more are described in words

// Draw over the punch everything that belongs to the picture
export function drawStory(pen, box) {
  if (!me.picture) return
  const { run, k } = me.picture, { X, Y } = box, frame = drawnFrame(run, k), slip = run.slipBefore(k, AFTER)
  const view = { narrow: box.width < (NARROW * size()) / 13, pen, box, X, Y, frame, run, k, slip, ink: inks() }
  if (run.head.flat) drawLattice(view)
  else {
    drawMesh(view)
    if (slip !== null) drawMoved(view)
    drawEdges(view)
  }
  drawTop(view)
  drawForces(view)
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

// The spring of the drive from the top to the stage, which stays in view; to scale. Returns where it begins, px
function drawDrive(view, right, y) {
  const { pen, box, narrow, X, frame, run, k, ink } = view, stretch = run.curves.U_x[k] - run.top(k)
  const drawn = X(frame.times * stretch) - X(0)
  const long = Math.min(0.3 * box.width, Math.max(0.2 * REST, REST + drawn)), left = right - long
  const turns = Array.from({ length: TURNS + 1 }, (_, i) =>
    [left + (i * long) / TURNS, y + (i % TURNS ? 5 * (-1) ** i : 0)])
  line(pen, [[left, box.top + BAR], ...turns], ink.text, 1.5)
  line(pen, [[right, y - 9], [right, y + 9]], ink.soft, 4)
  const text = `drive ${stretch < 0 ? "compressed" : "stretched"} by ${fixed(Math.abs(stretch), 1)} nm`
  if (!narrow && Math.abs(stretch) > 0.05) write(view, text, right, y + 1.3 * size(), { align: "right" })
  return left
}

// What the hand does: F to the side at the top, against it at the interface, and L down or up; lengths over the largest
// in view
function drawForces(view) {
  const { box, narrow, run, k, ink } = view
  const full = Math.max(run.strongest, me.run.strongest)
  const { F, L, U_x, delta } = run.values(k), none = (force) => !(Math.abs(force) > 1e-6 * full), row = 1.3 * size()
  const long = Math.min(ARROW, 0.3 * box.height, 0.16 * box.width), y = box.top + BAR + 0.9 * row
  const spring = Number(run.scene.drive_t) // NaN where the drive is rigid
  const edge = box.left + box.width - 12, right = spring ? drawDrive(view, edge, y) - 10 : edge
  const to = `to δ = ${fixed(delta, 1)} nm`, down = `lowered ${to}`, stage = run.driven ? "stage " : ""
  const moves = { approach: down, reload: down, unload: `raised ${to}`,
    back: `${stage}moved back to ${fixed(U_x, 1)} nm` }[run.stage(k)] ?? `${stage}moved ${fixed(U_x, 1)} nm`
  const pull = none(F) || run.apart ? 0 : (F / full) * long
  arrow(view, [pull > 0 ? right - pull : right, y], [pull, 0], ink.shear)
  const way = (pull > 0) === (run.stage(k) !== "back") ? "pulled" : "held back"
  const wide = box.width - (edge - right) > (spring ? 1.6 : 1) * WIDE * size()
  const pulled = `${!wide ? "" : `${moves}, ${way} by `}F = ${withUnit("F", F)}`
  write(view, pull ? pulled : moves, right - Math.abs(pull) - (pull ? 8 : 0), y,
    { of: pull ? ink.shear : ink.text, align: "right", bold: true })
  if (none(L) || run.apart) return
  const deep = (Math.abs(L) / full) * long, at = box.left + (narrow ? 0.06 : LENS) * box.width
  const from = y + (spring ? 2 : 0.8) * row // under the key, the text of F and the drive
  if (L > 0) arrow(view, [at, from], [0, deep], ink.normal)
  else arrow(view, [at, from + deep], [0, -deep], ink.normal)
  const text = narrow ? `L = ${withUnit("F", L)}` : `load L = ${withUnit("F", L)}, ${L > 0 ? "presses" : "holds it up"}`
  write(view, text, at + 12, from + Math.max(0.6 * row, 0.5 * deep), { of: ink.normal, align: "left" })
}

// Under the surface: friction on the punch, a bracket for each stretch that is repelled, and how far either edge has
// peeled
function drawEdges(view) {
  const { box, narrow, X, Y, frame, run, k, ink } = view, row = 1.3 * size()
  const patches = run.patches(k), bottom = box.top + box.height
  const y = Math.min(Math.max(Y(0), Y(Math.min(...frame.gap))) + 12, bottom - 1.8 * size())
  if (!patches.length) {
    const held = frame.T_n.some((_, i) => frame.state(i) === "adhering")
    const text = !held ? "the surfaces do not reach each other" : narrow ? "attraction alone"
      : "no contact, A = 0: held by attraction alone"
    const ends = write(view, text, X(0), y + size())
    return held && drawFriction(view, ...ends, y + size())
  }
  const place = (edge) => {
    const i = Math.floor(edge - run.headOf(k).first), t = edge - run.headOf(k).first - i
    return X(frame.drawn[i] * (1 - t) + frame.drawn[Math.min(i + 1, frame.drawn.length - 1)] * t)
  }
  const drawn = patches.map((ends) => ends.map(place)), left = drawn[0][0], right = drawn.at(-1)[1]
  if (drawn.length <= PATCHES) for (const ends of drawn) bracket(view, ends, y)
  const places = patches.length > 1 ? ` in ${patches.length} places` : ""
  const A = `${narrow ? "A" : "contact A"} = ${fixed(run.curves.A[k], 0)} nm${narrow ? "" : " wide"}${places}`
  const [from, to] = write(view, A, (left + right) / 2, y + 0.8 * size(), { of: ink.area })
  drawFriction(view, Math.min(left, from), Math.max(right, to), y)
  // while the top moves up or down contact grows and shrinks anyway
  const sliding = ["shear", "back"].includes(run.stage(k))
  if (!sees("edges") || !sliding || k <= run.sheared || narrow || patches.length > 1) return
  const start = run.edges(run.sheared)
  if (!start) return
  const [a, b] = run.edges(k), peeled = [a - start[0], start[1] - b]
  const low = Math.min(y + 0.8 * size() + row, bottom - 0.7 * size()) // in sight under a deep punch, too
  const labels = peeled.map((sites) => {
    const nm = Math.abs(sites) * run.head.spacing
    return Math.abs(sites) < 0.05 ? "" : `${fixed(nm, nm < 10 ? 1 : 0)} nm ${sites > 0 ? "let go" : "gained"}`
  })
  if (labels[0]) write(view, labels[0], Math.min(left, from - 8, X(0) - 20), low, { align: "right", stays: true })
  if (labels[1]) write(view, labels[1], Math.max(right, to + 8, X(0) + 20), low, { align: "left", stays: true })
}

function bracket({ pen, ink }, [left, right], y) {
  line(pen, [[left, y - 6], [left, y], [right, y], [right, y - 6]], ink.area, 2)
}

// What the substrate does to the punch: as large as the pull, against it, beside the contact
function drawFriction(view, left, right, y) {
  const { box, narrow, run, k, ink } = view, F = run.curves.F[k], full = run.strongest
  const long = (F / full) * Math.min(ARROW, 0.3 * box.height, 0.16 * box.width)
  if (!(Math.abs(long) > 2)) return
  const from = F > 0 ? left - 10 : right + 10
  arrow(view, [from, y], [-long, 0], ink.shear)
  if (!narrow)
    write(view, "friction", from - long + (F > 0 ? -8 : 8), y,
      { of: ink.shear, align: F > 0 ? "right" : "left", bold: true, stays: true })
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
