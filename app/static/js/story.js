// The story over the punch: who pulls, what holds, what lets go. One canvas above the figure, drawn with every frame.

import { frameBox } from "./bokeh.js"
import { by, fixed, minus } from "./dom.js"
import { figures, overlays } from "./figures.js"
import { drawLattice, drawLens } from "./lens.js"
import { movedSites } from "./sites.js"
import { arrow, cleared, inks, size, write } from "./pen.js"
import { me } from "./state.js"

const LINES = 24 // of the mesh in the body, from the surface to the top
const BAR = 9 // px, height of the top of the layer
const ARROW = 90 // px, the longest
const MARKED = 1.0 // nm of the path for which a slip stays marked
const NARROW = 440 // px, for text of 13 px: in a narrower view words are few
const LENS = 0.5 // of the width, beyond which the lens does not reach as the page opens
const WIDE = 52 // times the size of the text, from which there is room for whole sentences
const PATCHES = 8 // with a bracket each; more are told in words
const GAIN = 0.005 // a change of the area by less is not told

// Draw everything that belongs to frame k of a run: over the punch, or over that of a pinned run
export function drawStory(run, k, canvas = by("story"), figure = figures.punch) {
  const box = frameBox(figure), pen = cleared(canvas), main = figure === figures.punch
  if (!box || !pen) return
  const { x_range, y_range } = figure
  const X = (x) => box.left + ((x - x_range.start) / (x_range.end - x_range.start)) * box.width
  const Y = (y) => box.top + ((y_range.end - y) / (y_range.end - y_range.start)) * box.height
  const frame = run.frame(k), slip = lastSlip(run, k)
  const view = { narrow: box.width < (NARROW * size()) / 13, pen, box, X, Y, frame, run, k, slip, main, ink: inks() }
  pen.save()
  pen.beginPath()
  pen.rect(box.left, box.top, box.width, box.height)
  pen.clip()
  if (run.head.flat) drawLattice(view)
  else {
    drawMesh(view)
    if (slip) drawMoved(view)
    drawEdges(view)
  }
  drawTop(view)
  pen.restore()
  drawForces(view)
  if (main && !run.head.flat) drawLens(view)
  if (main) tellSlip(view)
}

// Lines of the material, upright before loading: from a surface node to where it hangs on the top
function drawMesh({ pen, box, X, Y, frame, run, k, ink }) {
  const { nodes, first, spacing, middle } = run.headOf(k), every = Math.max(1, Math.round(nodes / LINES))
  const U_x = run.curves.U_x[k]
  pen.strokeStyle = ink.body
  pen.globalAlpha = 0.55
  pen.lineWidth = 1
  pen.beginPath()
  for (let i = Math.floor(every / 2); i < nodes; i += every) {
    pen.moveTo(X(frame.x[i]), Y(frame.gap[i]))
    pen.lineTo(X((first + i) * spacing - middle + U_x), box.top + BAR)
  }
  pen.stroke()
  pen.globalAlpha = 1
}

// The rigid top: a bar whose marks move with it, and what it does
function drawTop({ pen, box, X, run, k, slip, main, ink }) {
  const U_x = run.curves.U_x[k], { x_range } = figures.punch
  pen.fillStyle = ink.soft
  pen.fillRect(box.left, box.top, box.width, BAR)
  pen.strokeStyle = ink.page
  pen.lineWidth = 1.5
  pen.beginPath()
  const pitch = run.head.flat ? run.head.spacing / 4 : 20, shift = U_x % pitch
  for (let x = Math.ceil((x_range.start - shift) / pitch) * pitch; x + shift < x_range.end; x += pitch) {
    pen.moveTo(X(x + shift) - 3, box.top + BAR)
    pen.lineTo(X(x + shift) + 3, box.top)
  }
  pen.stroke()
  if (!main && slip) write({ pen, ink, box }, slipSaid(run, slip.at), box.left + 8, box.top + BAR + 12, { of: ink.slip, align: "left", bold: true })
}

// What the hand does: F to the side at the top, against it at the interface, and L down or up; lengths over the largest in view
function drawForces(view) {
  const { box, narrow, run, k, ink } = view
  const full = Math.max(...[run, me.run, ...overlays.punches(me.run, 0).map(([, of]) => of)].map((of) => of.strongest))
  const { F, L, U_x, delta } = run.values(k), none = (force) => !(Math.abs(force) > 1e-6 * full), line = 1.3 * size()
  const long = Math.min(ARROW, 0.3 * box.height, 0.16 * box.width), y = box.top + BAR + 0.9 * line, right = box.left + box.width - 12
  const moves = { approach: `pushed down ${fixed(delta, 1)} nm`, reload: `pushed down ${fixed(delta, 1)} nm`, unload: `lifted to ${fixed(delta, 1)} nm`,
    back: `pulled back: ${fixed(U_x, 1)} nm` }[run.stage(k)] ?? `pulled ${fixed(U_x, 1)} nm`
  const pull = none(F) || run.apart ? 0 : (F / full) * long
  arrow(view, [pull > 0 ? right - pull : right, y], [pull, 0], ink.shear)
  write(view, pull ? `${box.width < WIDE * size() ? "" : `${moves}, `}F = ${said(F)}` : moves, right - Math.abs(pull) - (pull ? 8 : 0), y, { of: pull ? ink.shear : ink.text, align: "right", bold: true })
  if (none(L) || run.apart) return
  const deep = (Math.abs(L) / full) * long, at = box.left + (narrow ? 0.06 : LENS) * box.width, from = box.top + BAR + 3
  if (L > 0) arrow(view, [at, from], [0, deep], ink.normal)
  else arrow(view, [at, from + deep], [0, -deep], ink.normal)
  const text = narrow ? `L = ${said(L)}` : `load L = ${said(L)}, ${L > 0 ? "presses" : "holds it up"}`
  write(view, text, at + 12, from + Math.max(2.1 * line, 0.5 * deep), { of: ink.normal, align: "left" })
}

// A force per depth in the unit that needs the fewest digits
export function said(force) {
  const small = Math.abs(force) < 0.1
  return `${minus(Number((small ? 1000 * force : force).toPrecision(3)))} ${small ? "mN/m" : "N/m"}`
}

// Under the surface: friction on the punch, a bracket for each stretch that is repelled, and how far either edge has peeled
function drawEdges(view) {
  const { box, narrow, X, Y, frame, run, k, ink } = view, line = 1.3 * size()
  const patches = run.patches(k), bottom = box.top + box.height
  const y = Math.min(Math.max(Y(0), Y(Math.min(...frame.gap))) + 12, bottom - 1.8 * size())
  if (!patches.length) {
    const held = frame.T_n.some((_, i) => frame.state(i) === "adhering")
    const text = !held ? "the surfaces do not reach each other" : narrow ? "attraction alone" : "no contact, A = 0: held by attraction alone"
    return drawFriction(view, ...write(view, text, X(0), y + size()), y + size())
  }
  const place = (edge) => {
    const i = Math.floor(edge - run.headOf(k).first), t = edge - run.headOf(k).first - i
    return X(frame.x[i] * (1 - t) + frame.x[Math.min(i + 1, frame.x.length - 1)] * t)
  }
  const drawn = patches.map((ends) => ends.map(place)), left = drawn[0][0], right = drawn.at(-1)[1]
  if (drawn.length <= PATCHES) for (const ends of drawn) bracket(view, ends, y)
  const A = `${narrow ? "A" : "contact A"} = ${fixed(run.curves.A[k], 0)} nm${patches.length > 1 ? ` in ${patches.length} places` : ""}`
  const [from, to] = write(view, A, (left + right) / 2, y + 0.8 * size(), { of: ink.area })
  drawFriction(view, Math.min(left, from), Math.max(right, to), y)
  const start = run.sheared >= 0 && k > run.sheared && !narrow && patches.length === 1 ? run.edges(run.sheared) : null
  if (!start || y + 0.8 * size() + line > bottom) return
  const [a, b] = run.edges(k), peeled = [a - start[0], start[1] - b], low = y + 0.8 * size() + line
  const told = peeled.map((sites) => Math.abs(sites) < 0.05 ? "" : `${sites > 0 ? "let go by" : "gained"} ${Math.abs(sites).toFixed(1)} sites`)
  if (told[0]) write(view, told[0], Math.min(left, X(0) - 20), low, { align: "right" })
  if (told[1]) write(view, told[1], Math.max(right, X(0) + 20), low, { align: "left" })
}

function bracket({ pen, ink }, [left, right], y) {
  pen.strokeStyle = ink.area
  pen.lineWidth = 2
  pen.beginPath()
  pen.moveTo(left, y - 6)
  pen.lineTo(left, y)
  pen.lineTo(right, y)
  pen.lineTo(right, y - 6)
  pen.stroke()
}

// What the substrate does to the punch: as large as the pull, against it, beside the contact
function drawFriction(view, left, right, y) {
  const { box, narrow, run, k, ink } = view, F = run.curves.F[k], full = run.strongest
  if (!(Math.abs(F) > 1e-6 * full)) return
  const long = (F / full) * Math.min(ARROW, 0.3 * box.height, 0.16 * box.width), from = F > 0 ? left - 10 : right + 10
  arrow(view, [from, y], [-long, 0], ink.shear)
  if (!narrow) write(view, "friction", from - long + (F > 0 ? -8 : 8), y, { of: ink.shear, align: F > 0 ? "right" : "left", bold: true })
}

// The slip that led to frame k or to one shortly before: {at: its frame, age: 0 .. 1}, or null
function lastSlip(run, k) {
  if (run.followed) return null // of its motion two frames are known
  const { slip } = run.curves, reach = Math.max(1, Math.round(MARKED / run.head.step))
  for (let at = k; at > 0 && at > k - reach; at--) if (slip[at]) return { at, age: (k - at) / reach }
  return null
}

// The nodes that slipped flash, and fade as the top goes on
function drawMoved({ pen, X, Y, frame, run, k, slip, ink }) {
  const moved = movedSites(run, slip.at), shift = run.headOf(k).first - run.headOf(slip.at).first
  pen.strokeStyle = ink.slip
  pen.lineWidth = 14
  pen.lineCap = "round"
  pen.globalAlpha = 0.6 * (1 - slip.age)
  pen.beginPath()
  let drawing = false
  frame.x.forEach((x, i) => {
    const point = [X(x), Y(frame.gap[i])]
    if (moved[i + shift] && drawing) pen.lineTo(...point)
    else if (moved[i + shift]) pen.moveTo(...point)
    drawing = Boolean(moved[i + shift])
  })
  pen.stroke()
  pen.globalAlpha = 1
}

const COUNTS = ["no", "one", "two", "three", "four", "five", "six"]
export function slipSaid(run, at, brief = false) {
  const moved = movedSites(run, at), frame = run.frame(at)
  const acting = [...moved.keys()].filter((i) => frame.state(i) !== "free")
  const gone = acting.filter((i) => moved[i])
  const before = run.curves.A_bar[at - 1], now = run.curves.A_bar[at], change = now / before - 1
  const area = before === 0 ? (now > 0 ? ", contact again" : "") : now === 0 ? ", A falls to 0"
    : Math.abs(change) < GAIN ? "" : `, A ${change > 0 ? "+" : "−"}${(100 * Math.abs(change)).toPrecision(2)} %`
  if (!gone.length) return run.stage(at) === "unload" ? "pull-off" : `jump${area}`
  const sites = Math.abs(moved[gone[gone.length >> 1]]), nm = fixed(sites * run.head.spacing, 1)
  const part = gone.length < 0.95 * acting.length ? `${gone.length} of ${acting.length} nodes` : ""
  const far = part && brief ? "" : `${part && " by "}${COUNTS[sites] ?? sites} site${sites === 1 ? "" : "s"}${brief ? "" : ` (${nm} nm)`}`
  return `slip: ${part}${far}${run.head.flat ? "" : area}`
}

function tellSlip({ run, k, slip, narrow }) {
  by("slip").hidden = !slip
  by("slow").hidden = run.followed || slipAt(run, k) === null
  if (slip) by("slip").textContent = slipSaid(run, slip.at, narrow)
}

// The frame of the last slip up to frame k, or null
export function slipAt(run, k) {
  const at = run.curves.slip.findLastIndex((slipped, i) => slipped && i <= k && i > 0)
  return at < 0 ? null : at
}

// The frame of the next slip that way, or k itself
export function nextSlip(run, k, way) {
  const { slip } = run.curves
  for (let at = k + way; at >= 0 && at < slip.length; at += way) if (slip[at] && at >= run.sheared) return at
  return k
}
