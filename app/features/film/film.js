// Slow motion through a slip: the states of the motion itself, at one place of the top. Loaded when it is asked for.

import { charts } from "../../static/js/charts.js"
import { order, take } from "../../static/js/channel.js"
import { by } from "../../static/js/dom.js"
import { inks, line, size, write } from "../../static/js/pen.js"
import { framed, goto } from "../../static/js/player.js"
import { unpackLater } from "../../static/js/packed.js"
import { Run, SPANS } from "../../static/js/run.js"
import { frame, me, now, redraw, view } from "../../static/js/store.js"

const SECONDS = 5 // of a film
const DOT = 5 // px, of F now in the curve
const FIELD = 0.5, EDGE = 8 // of the width of the plot, for F of the motion; px beside its curve
const REST = 1.2 // s at its end
const SAID = 5000 // ms, for which a sentence stays
// {run, k: the frame that the slip led to, frames: a Run once they come, clock: s of playing, before: ms, axis: its
// ends before}; the state on screen is `me.instead`
let film = null

// Begin, or end; where there is no slip to go through, say so
export function slowMotion() {
  if (film) return leave()
  const { run } = me, at = now(), k = at < 0 ? null : run.slipBefore(at)
  if (at < 0) return refuse("Slow motion: nothing is computed yet.")
  if (run.followed || run.checked) return waitForExact()
  if (k === null)
    return refuse(`Slow motion: no slip up to here${run.nextSlip(at, 1) > at ? "; the key ] leads to the next" : ""}.`)
  goto(k)
  film = { run, k, frames: null, clock: 0, before: 0 }
  tell("solving the motion …")
  order("film", { run: run.number, frame: k })
}

// A predicted run has no motions: those of the exact run, as soon as it is there
async function waitForExact() {
  tell("the exact run comes first …")
  const there = await framed()
  tell("")
  if (there) slowMotion()
}

function look() {
  if (film && (me.run !== film.run || now() !== film.k)) leave()
}

function tell(text) {
  by("film").hidden = !text
  by("film").textContent = text
  by("slow").textContent = film ? "Stop" : "Slow motion"
  if (film) by("slow").hidden = false
}

function refuse(why) {
  film = null
  tell(why)
  by("announcement").textContent = why
  setTimeout(() => { if (!film) tell("") }, SAID)
}

// Its frames follow those of the run, up to the one before the slip: so they are drawn as all others are
function receive({ why, ...chunk }) {
  if (why && film && !film.frames) refuse(`Slow motion: ${why}.`)
  if (!film || chunk.frame !== film.k || me.run !== film.run) return
  if (!film.frames) {
    film.frames = Object.assign(new Run(`film ${chunk.frame}`, chunk.head), { transient: true })
    takeOver(film.frames, film.run, film.k - 1)
  }
  film.frames.add(chunk)
  if (!film.frames.whole) return
  film.before = performance.now()
  me.instead = { run: film.frames, k: film.k, paused: false }
  widenForces(film.frames.curves.F)
  charts.forces.parts.motion = { kind: "drawing", draw: drawTrace }
  by("announcement").textContent = "Slow motion through the slip: the surface is not at rest."
  requestAnimationFrame(step)
}

// Begin with the frames of another run up to k
export function takeOver(made, other, k) {
  made.places = other.places.slice(0, k + 1)
  for (const name in made.curves) made.curves[name] = other.curves[name].slice(0, k + 1)
  for (const name of ["sheared", ...SPANS]) made[name] = other[name]
}

// Let the axis of the forces hold the motion as well, which is rougher
function widenForces(values) {
  const { start, end } = charts.forces.y, held = values.map((value) => 1.1 * value)
  film.axis = { start, end }
  charts.forces.range("y", { start: Math.min(start, ...held), end: Math.max(end, ...held) })
}

function step(time) {
  if (!film?.frames) return
  const { frames, k } = film, { paused } = me.instead
  if (!paused) film.clock += Math.max(0, time - film.before) / 1000
  film.before = time
  if (film.clock > SECONDS + REST) return leave()
  const at = Math.min(frames.length - 1, k + Math.floor((film.clock / SECONDS) * (frames.length - k)))
  if (at !== me.instead.k) me.instead = { run: frames, k: at, paused }
  requestAnimationFrame(step)
}

function followFilm() {
  if (!film?.frames) return
  tell("slow motion")
  charts.forces.changed = true
}

// F of the motion from state to state, in a field of its own beside the place of the slip, over the same axis of forces
function drawTrace(pen, box) {
  const { frames, k } = film
  const F = frames.curves.F.slice(k - 1), ink = inks()
  const width = FIELD * box.width, right = box.X(frames.along[k - 1]) < box.left + 0.5 * box.width
  const left = right ? box.left + box.width - width : box.left
  const places = F.map((value, i) => [left + EDGE + (i / (F.length - 1)) * (width - 2 * EDGE), box.Y(value)])
  pen.fillStyle = ink.page
  pen.fillRect(left, box.top, width, box.height)
  pen.strokeStyle = ink.slip
  pen.lineWidth = 1
  pen.strokeRect(left, box.top, width, box.height)
  const shown = me.instead.k - k + 1
  line(pen, places, ink.grid, 2)
  line(pen, places.slice(0, shown + 1), ink.slip, 2)
  pen.fillStyle = ink.slip
  pen.beginPath()
  pen.arc(...places[shown], DOT, 0, 2 * Math.PI)
  pen.fill()
  const field = { left, top: box.top, width, height: box.height }
  write({ pen, ink, box: field }, "F until it rests", left + width / 2, box.top + box.height - size(), { of: ink.slip })
}

function leave() {
  delete charts.forces.parts.motion
  if (film.axis) charts.forces.range("y", film.axis)
  film = null
  tell("")
  me.instead = null
  redraw()
}

take("slip", receive, (message) => (message.why ? message : unpackLater(message)))
frame(["picture"], followFilm)
view(["run", "at"], look)
