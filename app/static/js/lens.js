// Nodes, lattice sites and the springs between them, to scale: in a lens over the punch, or, for flats, over all of it.

import { MARKERS } from "./chart.js"
import { charts } from "./charts.js"
import { by, closest, on, onDrag, tell } from "./dom.js"
import { cleared, inks, line, write } from "./pen.js"
import { BAR, sideways } from "./punch.js"
import { digits, fixed } from "./quantities.js"
import { me, redrawPunch, sees } from "./store.js"

const ACROSS = 13 // nm seen in the lens
const SPRUNG = 9 // nodes seen with their springs in a reason of the tour
const APART = 2.4 // nm that nodes are drawn above where they are, so that springs are seen in contact
const REACH = 2.2 // delta_t: springs longer than that are too weak to be drawn
// nm along the interface, null: at the trailing edge; in slow motion where most moves
const lens = { place: null, moving: null }
const EASE = 0.15 // of the way to where most moves, in each picture of a slow motion

// Where the lens looks unless it was dragged elsewhere: at the trailing edge; before there is contact, at the first dip
// held, if any
function focus({ run, k, frame }) {
  if (lens.place !== null) return lens.place
  if (run.transient) return follow(run, k, frame)
  lens.moving = null
  const edges = run.edges(k), { first } = run.headOf(k), { x, gap } = frame
  if (!edges) {
    const dip = gap.findIndex((g, i) => g <= gap[i - 1] && g < gap[i + 1] && frame.state(i) === "adhering")
    return dip < 0 ? null : x[dip]
  }
  return frame.x[Math.max(0, Math.floor(run.stage(k) === "back" ? edges[1] - first : edges[0] - first))]
}

// Where the surface has moved most since the state of the motion before, eased, so that it can be watched
function follow(run, k, { x, T_n }) {
  const before = run.frame(k - 1).x, moved = (i) => (T_n[i] === 0 ? 0 : Math.abs(x[i] - before[i]))
  const most = before.length === x.length ? x.reduce((best, _, i) => (moved(i) > moved(best) ? i : best), 0) : 0
  lens.moving = lens.moving === null ? x[most] : lens.moving + EASE * (x[most] - lens.moving)
  return lens.moving
}

const times = (factor) => `${digits(factor, 2)} times`

// By how much the picture enlarges what it shows, in words
function tellScales() {
  const box = charts.punch.box, { run } = me
  if (!box || !run) return
  const moved = sideways(run), aside = moved > 1 ? ` and displacements sideways ${times(moved)}` : ""
  const text = run.head.flat ? "The picture is to scale."
    : `The picture shows heights ${times(box.up / box.across)}${aside} as large as lengths along the surface.`
  const magnified = times((2 * radiusIn(box)) / ACROSS / box.across)
  tell(by("scales"), `${text}${by("lens").hidden ? "" : ` The lens is to scale and magnifies ${magnified}.`}`)
}

const radiusIn = ({ width, height }) => Math.min(95, 0.25 * height, 0.16 * width)

export function drawLens(view) {
  const { pen, box, X, Y, frame, ink } = view
  const radius = radiusIn(box), at = focus(view)
  by("lens").hidden = !sees("lens") || view.narrow || radius < 40 || at === null
  if (by("lens").hidden) return
  const centre = [box.left + 0.3 * box.width, box.top + 0.36 * box.height]
  const near = closest(frame.x, at)
  Object.assign(by("lens").style,
    { left: `${centre[0] - radius}px`, top: `${centre[1] - radius}px`, width: `${2 * radius}px`,
      height: `${2 * radius}px` })
  const { start, end } = charts.punch.x
  for (const [name, value] of [["min", start], ["max", end], ["now", at]])
    by("lens").setAttribute(`aria-value${name}`, value.toFixed(1))
  by("lens").setAttribute("aria-valuetext",
    `x = ${fixed(at, 1)}, gap ${fixed(frame.gap[near], 2)}, ${frame.state(near)}`)
  const spot = [X(frame.drawn[near]), Math.max(box.top, Y(Math.max(0, frame.gap[near])))]
  const part = radius / Math.hypot(spot[0] - centre[0], spot[1] - centre[1])
  line(pen, [spot, centre.map((c, i) => c + (spot[i] - c) * part)], ink.soft) // from what it shows to the lens
  pen.save()
  pen.beginPath()
  pen.arc(...centre, radius, 0, 7)
  pen.fillStyle = ink.page
  pen.fill()
  pen.clip()
  const scale = (2 * radius) / ACROSS, low = centre[1] + 0.55 * radius
  const x = (nm) => centre[0] + (nm - at) * scale, y = (nm) => low - nm * scale
  drawBody(view, x, y, at - ACROSS, at + ACROSS, centre[1] - radius)
  drawAtoms(view, x, y, scale, at - ACROSS / 2, at + ACROSS / 2)
  pen.restore()
  pen.beginPath()
  pen.arc(...centre, radius, 0, 7)
  pen.strokeStyle = ink.text
  pen.lineWidth = 2
  pen.stroke()
}

// The punch above its nodes
function drawBody({ pen, frame, ink }, x, y, from, to, top) {
  const shown = [...frame.x.keys()].filter((i) => frame.x[i] > from && frame.x[i] < to)
  pen.beginPath()
  for (const i of shown) pen.lineTo(x(frame.x[i]), y(frame.gap[i] + APART))
  for (const i of [shown.at(-1), shown[0]]) pen.lineTo(x(frame.x[i]), top)
  pen.globalAlpha = 0.2
  pen.fillStyle = ink.body
  pen.fill()
  pen.globalAlpha = 1
}

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

// The picture that argues the reason at some stops of the tour: the trailing edge of frame k of a run
export function drawSprings(canvas, run, k) {
  const pen = cleared(canvas), { clientWidth: width, clientHeight: height } = canvas
  if (!pen || run.head.flat) return
  const frame = run.frame(k), edges = run.edges(k), { first, spacing } = run.headOf(k)
  const i = edges ? Math.floor(edges[0] - first) : frame.gap.findIndex((gap) => gap === Math.min(...frame.gap))
  const at = frame.x[Math.max(0, i)] + 2 * spacing, scale = width / (SPRUNG * spacing), low = 0.72 * height
  drawAtoms({ pen, frame, run, k, ink: inks() }, (x) => 0.5 * width + (x - at) * scale, (y) => low - y * scale * 0.8,
    scale, at - (SPRUNG * spacing) / 2, at + (SPRUNG * spacing) / 2)
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

export function connectLens() {
  on("solver", "beforetoggle", tellScales)
  const grip = by("lens")
  const move = (nm) => {
    const { start, end } = charts.punch.x
    lens.place = Math.max(start, Math.min(end, (lens.place ?? Number(grip.getAttribute("aria-valuenow"))) + nm))
    redrawPunch()
  }
  onDrag(grip, (event) => {
    grip.setPointerCapture(event.pointerId)
    event.preventDefault()
    grip.focus()
    return { x: event.clientX }
  }, (event, last) => {
    const { start, end } = charts.punch.x
    move(((event.clientX - last.x) * (end - start)) / by("punch-view").clientWidth)
    last.x = event.clientX
  })
  on("lens", "dblclick", () => { lens.place = null; redrawPunch() })
  on("lens", "keydown", (event) => {
    const spacing = me.run?.head.spacing ?? 1
    const steps = { ArrowLeft: -spacing, ArrowRight: spacing, PageDown: -10 * spacing, PageUp: 10 * spacing }
    if (!(event.key in steps)) return
    event.preventDefault()
    event.stopPropagation()
    move(steps[event.key])
  })
}
