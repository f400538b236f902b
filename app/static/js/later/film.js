// Slow motion through a slip: the states of the motion itself, at one place of the top. Loaded when it is asked for.

import { frameBox, set } from "../bokeh.js"
import { order, take } from "../channel.js"
import { by, make } from "../dom.js"
import { figures } from "../figures.js"
import { cleared, inks, line, over, size, write } from "../pen.js"
import { goto, toggle } from "../player.js"
import { unpackLater } from "../packed.js"
import { Run } from "../run.js"
import { cover, me, now, redraw, view } from "../store.js"
import { forceUnit } from "../words.js"

const SECONDS = 5 // of a film
const DOT = 5 // px, of F now in the curve
const REST = 1.2 // s at its end
const SAID = 5000 // ms, for which a sentence stays
// {run, k: the frame that the slip led to, frames: a Run once they come, clock: s of playing, before: ms, range: of
// tractions before}; the state on screen is `me.film`
let film = null

// Begin, or end; where there is no slip to go through, say so
export function slowMotion() {
  if (film) return leave()
  const { run } = me, at = now(), k = at < 0 ? null : run.slipBefore(at)
  if (at < 0) return refuse("Slow motion: nothing is computed yet.")
  if (k === null)
    return refuse(`Slow motion: no slip up to here${run.nextSlip(at, 1) > at ? "; the key ] leads to the next" : ""}.`)
  goto(k)
  film = { run, k, frames: null, clock: 0, before: 0 }
  tell("solving the motion …")
  order("film", { run: run.number, frame: k })
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
function receive(chunk) {
  if (!film || chunk.frame !== film.k || me.run !== film.run) return
  if (!film.frames) {
    film.frames = Object.assign(new Run(`film ${chunk.frame}`, chunk.head), { filmed: true })
    film.frames.takeOver(film.run, film.k - 1)
  }
  film.frames.add(chunk)
  if (!film.frames.whole) return
  film.before = performance.now()
  scrub.max = film.frames.length - 1 - film.k
  swapScrubs(true)
  me.film = { run: film.frames, k: film.k, paused: false }
  const range = figures.traction.y_range, { T_least, T_most } = film.frames // of the motion as well, which is rougher
  film.range = { start: range.start, end: range.end }
  set(range, { start: Math.min(range.start, 1.1 * T_least), end: Math.max(range.end, 1.1 * T_most) })
  by("announcement").textContent = "Slow motion through the slip: the surface is not at rest."
  requestAnimationFrame(step)
}

function step(time) {
  if (!film?.frames) return
  const { frames, k } = film, { paused } = me.film
  if (!paused) film.clock += Math.max(0, time - film.before) / 1000
  film.before = time
  if (film.clock > SECONDS + REST) return leave()
  const at = Math.min(frames.length - 1, k + Math.floor((film.clock / SECONDS) * (frames.length - k)))
  if (at !== me.film.k) me.film = { run: frames, k: at, paused }
  requestAnimationFrame(step)
}

// The slider of the motion, in the place of that of the run: where it is put, the motion rests
const scrub = make("input", { type: "range", value: 0, id: "film-scrub", "aria-label": "State of the slip shown" })
scrub.addEventListener("input", () => {
  if (!me.film) return // it has come to its end
  film.clock = ((Number(scrub.value) + 0.5) / (film.frames.length - film.k)) * SECONDS
  if (!me.film.paused) toggle()
})

function swapScrubs(filmed) {
  by("scrub").hidden = filmed
  if (filmed) by("scrub").before(scrub)
  else scrub.remove()
}

// F of the motion, up and down at the one place of the top: how far it has swung, and where it is now
function drawTrace() {
  if (!film?.frames) return
  const { frames, k } = film, box = frameBox(figures.forces), pen = box && cleared(film.canvas ??= over("forces"))
  scrub.value = me.film.k - k
  tell("slow motion")
  by("slip").hidden = true
  if (!pen) return
  const { factor, names } = forceUnit([film.run]), F = frames.curves[names.F], ink = inks()
  const x = box.X(frames.along[k - 1]), align = x > box.left + 0.5 * box.width ? "right" : "left"
  const inside = (y) => Math.max(box.top, Math.min(y, box.top + box.height))
  const heights = F.slice(k - 1, me.film.k + 1).map((value) => inside(box.Y(value * factor)))
  line(pen, [Math.min(...heights), Math.max(...heights)].map((y) => [x, y]), ink.slip, 3)
  pen.fillStyle = ink.slip
  pen.beginPath()
  pen.arc(x, heights.at(-1), DOT, 0, 2 * Math.PI)
  pen.fill()
  const beside = x + (align === "left" ? 2 : -2) * DOT
  write({ pen, ink, box }, "F in slow motion", beside, box.Y(0) - size(), { of: ink.slip, align })
}

function leave() {
  film.canvas?.remove()
  if (film.range) set(figures.traction.y_range, film.range)
  film = null
  swapScrubs(false)
  tell("")
  me.film = null
  redraw()
}

take("film", receive, unpackLater)
take("film failed", ({ why }) => { if (film && !film.frames) refuse(`Slow motion: ${why}.`) })
cover(["picture"], drawTrace)
view(["run", "at"], () => { if (film && (me.run !== film.run || now() !== film.k)) leave() })
