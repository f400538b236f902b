// Slow motion through a slip: the states of the motion itself, at one place of the top. Loaded when it is asked for.

import { drawBands } from "../bands.js"
import { frameBox, set } from "../bokeh.js"
import { listen, order } from "../channel.js"
import { by } from "../dom.js"
import { drawFrame, figures, painted } from "../figures.js"
import { drawFringes } from "../fringes.js"
import { cleared, inks, size, write } from "../pen.js"
import { goto, show, tellFrame } from "../player.js"
import { FILM, Run } from "../run.js"
import { tellNow } from "../saying.js"
import { over } from "../sketch.js"
import { me, onFrame } from "../state.js"
import { drawStory, nextSlip, slipAt } from "../story.js"
import { forceUnit } from "../units.js"

const SECONDS = 5 // of a film
const TRACE = 90 // px, the length of a film in the curve
const REST = 1.2 // s at its end
const SAID = 5000 // ms, for which a sentence stays
let film = null // {run, k: the frame that the slip led to, frames: a Run once they come, at, begun, range: of tractions before}
let listens = false

// Begin, or end; where there is no slip to go through, say so
export function slowMotion() {
  if (film) return end()
  const { run } = me, at = Math.min(Math.floor(me.at), (run?.length ?? 0) - 1), k = at < 0 ? null : slipAt(run, at)
  if (at < 0) return refuse("Slow motion: nothing is computed yet.")
  if (k === null) return refuse(`Slow motion: no slip up to here${nextSlip(run, at, 1) > at ? "; the key ] leads to the next" : ""}.`)
  if (!listens) listen("status", heard)
  listens = true
  goto(k)
  film = { run, k, frames: null, at: -1, begun: 0 }
  tell("solving the motion …")
  order("film", { run: run.number, frame: k })
}

function tell(text) {
  by("film").hidden = !text
  by("film").textContent = text
  by("slow").textContent = film ? "Stop" : "Slow motion"
  if (film) by("slow").hidden = false
}

// What the server says where it has no motion to send
function heard() {
  const why = film && !film.frames && me.status.notes.find((note) => note.startsWith("Slow motion"))
  if (why) refuse(why)
}

function refuse(why) {
  film = null
  tell(why)
  by("told").textContent = why
  setTimeout(() => { if (!film) tell("") }, SAID)
}

// Its frames follow those of the run, up to the one before the slip: so they are drawn as all others are
function receive(chunk) {
  if (!film || chunk.run !== FILM + film.k || me.run !== film.run) return
  if (!film.frames) {
    film.frames = new Run(chunk.run, chunk.head)
    film.frames.takeOver(film.run, film.k - 1)
  }
  film.frames.add(chunk)
  if (!film.frames.whole) return
  film.begun = performance.now()
  const range = figures.traction.y_range, { T_least, T_most } = film.frames // of the motion as well, which is rougher
  film.range = { start: range.start, end: range.end }
  set(range, { start: Math.min(range.start, 1.1 * T_least), end: Math.max(range.end, 1.1 * T_most) })
  by("told").textContent = "Slow motion through the slip: the surface is not at rest."
  requestAnimationFrame(step)
}

function step(now) {
  if (!film?.frames) return
  const { frames, k } = film, passed = (now - film.begun) / 1000
  if (passed > SECONDS + REST) return end()
  const at = Math.max(k, Math.min(frames.length - 1, k + Math.floor((passed / SECONDS) * (frames.length - k))))
  if (at !== film.at) {
    film.at = at
    painted(() => {
      drawFrame(frames, at)
      drawFringes(frames, at)
      drawStory(frames, at)
      tell("slow motion")
      tellNow(frames, at)
      drawTrace(frames, k, at)
      tellFrame(frames, at)
      drawBands(frames, at)
      by("slip").hidden = true
    })
  }
  requestAnimationFrame(step)
}

// F of the motion, from where the slip is in the curve on to the right: there its axis is time
function drawTrace(frames, k, at) {
  const box = frameBox(figures.forces), pen = box && cleared(film.canvas ??= over("forces"))
  if (!pen) return
  const { x_range, y_range } = figures.forces, { factor, names } = forceUnit([film.run]), F = frames.curves[names.F], ink = inks()
  const x = box.left + ((frames.along[k - 1] - x_range.start) / (x_range.end - x_range.start)) * box.width
  const long = Math.min(TRACE, box.left + box.width - x), of = (i) => x + ((i - k + 1) / (frames.length - k)) * long
  const Y = (value) => box.top + ((y_range.end - value * factor) / (y_range.end - y_range.start)) * box.height
  pen.strokeStyle = ink.slip
  pen.lineWidth = 2.5
  pen.beginPath()
  for (let i = k - 1; i <= at; i++) pen.lineTo(of(i), Y(F[i]))
  pen.stroke()
  write({ pen, ink, box }, "F in slow motion", of(at), Y(F[at]) - size(), { of: ink.slip })
}

function leave() {
  film.canvas?.remove()
  if (film.range) set(figures.traction.y_range, film.range)
  film = null
  tell("")
}

function end() {
  leave()
  show()
}

me.filmed = receive
onFrame(() => { // another increment is drawn: it goes on from there; the same one, where the page has changed its size
  if (!film || (me.run === film.run && Math.floor(me.at) === film.k)) return
  leave()
})
