// The lens over the punch: nodes, lattice sites and the springs between them, to scale.

import { charts } from "../../static/js/charts.js"
import { by, closest, on, onDrag } from "../../static/js/dom.js"
import { APART, drawAtoms } from "../../static/js/lattice.js"
import { line } from "../../static/js/pen.js"
import { fixed } from "../../static/js/quantities.js"
import { me, redrawPunch, sees } from "../../static/js/store.js"
import { OVER, times } from "../../static/js/story.js"

const ACROSS = 13 // nm seen in the lens
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

// By how much it enlarges what it shows, after what the core says of the picture
function tellScale() {
  const { box } = charts.punch
  if (box && !by("lens").hidden)
    by("scales").append(` The lens is to scale and magnifies ${times((2 * radiusIn(box)) / ACROSS / box.across)}.`)
}

const radiusIn = ({ width, height }) => Math.min(95, 0.25 * height, 0.16 * width)

function drawLens(view) {
  if (view.run.head.flat) return void (by("lens").hidden = true)
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

export function connect() {
  OVER.push(drawLens)
  on("solver", "beforetoggle", tellScale)
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
