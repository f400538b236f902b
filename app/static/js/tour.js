// The tour beside the hero: stops, each with a prediction before the run draws itself. Loaded when it is asked for.

import { frameBox } from "./bokeh.js"
import { order } from "./channel.js"
import { colour } from "./colours.js"
import { by, fixed, make, makeButton, minus, readdress } from "./dom.js"
import { figures } from "./figures.js"
import { openPage } from "./pages.js"
import { goto, play } from "./player.js"
import { firstSlip } from "./sentence.js"
import { me } from "./state.js"
import { explain } from "./terms.js"
import { PICTURES } from "./tour/pictures.js"
import { STOPS } from "./tour/stops.js"
import { choose, isLab, look } from "./view.js"

let before = null // {U, F} of the first slip of the usual scene, to compare with
let unseen = {}, hands = [0, 0, 0] // the scene that nobody has seen; hands raised for each answer
let at = 0, phase = "ask", chosen = null, sketch = [], card = null, watching = 0

export function openTour(stop = 1) {
  at = Math.max(0, Math.min(STOPS.length - 1, stop - 1))
  card ??= makeCard()
  card.hidden = false
  if (document.querySelector(".page").dataset.page) openPage("")
  if (isLab()) look("hero")
  begin()
  cancelAnimationFrame(watching)
  watching = requestAnimationFrame(watch)
}

function close() {
  cancelAnimationFrame(watching)
  card.hidden = true
  delete document.documentElement.dataset.tour
  for (const view of COVERED) cover(view).hidden = true
  by("tour-sketch").hidden = true
  readdress((asked) => asked.delete("tour"))
  by("tour").focus()
}

function makeCard() {
  const made = make("section", { id: "tour-card", "aria-label": "Tour" })
  made.addEventListener("keydown", (event) => { if (event.key === "Escape") close() })
  document.addEventListener("keydown", onDigit)
  document.querySelector("main").append(made)
  const canvas = make("canvas", { id: "tour-sketch", hidden: true })
  figureOf("area").append(canvas)
  connectSketch(canvas)
  return made
}

const figureOf = (view) => document.querySelector(`.view[data-view="${view}"]`)

// A scene is asked for, and its future hidden until the prediction is made
function begin() {
  const stop = STOPS[at]
  phase = "wait"
  chosen = null
  sketch = []
  hands = [0, 0, 0]
  unseen = stop.unseen && before ? stop.unseen[Math.floor(Math.random() * stop.unseen.length)] : {}
  readdress((asked) => asked.set("tour", at + 1))
  choose(stop.curve)
  order("preset", { preset: stop.preset })
  const values = { ...stop.values, ...unseen }
  if (Object.keys(values).length) order("scene", values)
  write()
}

const there = () => {
  const { preset, values, state } = me.status, stop = STOPS[at], wanted = Object.entries({ ...stop.values, ...unseen })
  return state === "finished" && preset === stop.preset && me.run?.whole && me.run.scene && !me.stale
    && wanted.every(([name, value]) => Number(values[name]) === value)
}

// With the usual scene, what others are compared with; the last stop begins again once that is known
function learn() {
  if (me.status.preset !== "fig6" || Object.keys({ ...STOPS[at].values, ...unseen }).length) return false
  before = firstSlip(me.run)
  return Boolean(STOPS[at].unseen)
}

// The places of the right answer first: of a scene that nobody has seen, from its run
function right() {
  if (!STOPS[at].unseen) return 0
  const now = firstSlip(me.run)
  return !now || now.U > before.U + 0.1 ? 1 : now.U < before.U - 0.1 ? 0 : 2
}

const NAMES = { E: ["a stiffness of", "GPa"], delta_bar: ["a press depth of", "δ₀"], phi_ratio: ["a grip of", "times the adhesion"] }
function filled(text) {
  const [[name, value] = ["E", 70]] = Object.entries(unseen), [head, unit] = NAMES[name]
  const now = phase === "wait" ? null : firstSlip(me.run)
  return text.replaceAll("{change}", `${head} ${minus(value)} ${unit}`).replaceAll("{before}", before ? fixed(before.U, 1) : "").replaceAll("{after}", now ? fixed(now.U, 1) : "no place")
}

function watch() {
  watching = requestAnimationFrame(watch)
  if (phase === "wait" && there()) {
    if (learn()) return begin()
    phase = "ask"
    goto(me.run.sheared)
    write()
    card.querySelector("button.answer")?.focus()
  }
  if (phase === "show" && me.run.along[Math.max(0, me.drawn)] >= STOPS[at].to) {
    goto(me.run.along.findIndex((place, k) => k >= me.run.sheared && place >= STOPS[at].to)) // a slow machine plays in leaps
    phase = "why"
    write()
  }
  hideFuture()
  drawSketch()
}

function answer(index) {
  chosen = index
  phase = "show"
  me.at = Math.max(0, me.run.sheared)
  me.following = false
  play(true)
  write()
}

const COVERED = ["forces", "area", "map"]
const covers = {}
const cover = (view) => covers[view] ??= figureOf(view).appendChild(make("div", { className: "future" }))

// What lies ahead of the increment shown stays hidden until the stop has been played
function hideFuture() {
  for (const view of COVERED) {
    const box = frameBox(figures[view]), { start, end } = figures[view].x_range, hidden = phase === "why" || phase === "turn" || !box || !me.run
    cover(view).hidden = hidden
    if (hidden) continue
    const now = phase === "wait" || me.run.sheared < 0 ? start : me.run.along[Math.max(me.run.sheared, me.drawn)]
    const x = box.left + ((now - start) / (end - start)) * box.width + 1, far = box.left + box.width + 2
    Object.assign(cover(view).style, { left: `${x}px`, top: `${box.top}px`, width: `${Math.max(0, far - x)}px`, height: `${box.height}px` })
  }
}

function write() {
  const stop = STOPS[at]
  document.documentElement.dataset.tour = phase
  const title = make("h2", { textContent: `${at + 1} of ${STOPS.length}: ${stop.name}` }), truth = phase === "wait" ? 0 : right()
  const end = makeButton({ textContent: "End tour", onclick: close })
  card.replaceChildren(make("div", { className: "top" }, title, end))
  if (phase === "wait") card.append(make("p", { textContent: "getting ready …" }))
  else if (phase !== "turn") {
    const question = make("p", { className: "question" })
    explain(question, filled(stop.question))
    if (stop.said && phase === "ask") card.append(make("ul", {}, ...stop.said.map((text) => make("li", { textContent: text }))))
    card.append(question)
    if (stop.sketch && phase === "ask") card.append(make("p", { className: "said", textContent: "Draw the curve you expect below if you like, then choose:" }))
    const row = make("div", { className: "answers" })
    for (const i of stop.order) {
      if (phase === "why" && i !== chosen && i !== truth) continue
      const button = makeButton({ className: "answer", textContent: stop.answers[i], disabled: phase !== "ask", onclick: () => answer(i) })
      if (hands[i]) button.append(make("span", { className: "hands", textContent: ` ${hands[i]} hand${hands[i] > 1 ? "s" : ""}` }))
      if (phase !== "ask" && (i === chosen || i === truth)) button.dataset.mark = i === truth ? "right" : "wrong"
      if (phase === "show" && i !== chosen) delete button.dataset.mark
      if (phase === "show" && i === chosen) button.dataset.mark = "chosen"
      row.append(button)
    }
    card.append(row)
  }
  if (phase === "show") card.append(make("p", { className: "said", textContent: "Watch …" }))
  if (phase === "why") {
    const why = make("span")
    explain(why, filled(stop.why))
    const said = make("p", {}, make("b", { textContent: chosen === truth ? "Yes. " : "Not so. " }), why), picture = make("canvas", { className: "picture-of" })
    said.setAttribute("role", "status")
    card.append(said, picture)
    PICTURES[stop.picture](picture, me.run, Math.max(me.run.sheared, me.drawn), before)
  }
  if (phase !== "why" && phase !== "turn") return
  const ways = [make("span", { className: "said", textContent: stop.ask })]
  if (phase === "why") ways.push(makeButton({ textContent: "Your turn", onclick: takeTurn }))
  if (at + 1 < STOPS.length) ways.push(makeButton({ textContent: `Next: ${STOPS[at + 1].name}`, onclick: () => openTour(at + 2) }))
  card.append(make("div", { className: "answers ways" }, ...ways))
  if (phase === "why") ways.at(-1).focus({ preventScroll: true })
}

// 1 to 3 choose an answer; with Shift they count a class's raised hands
function onDigit(event) {
  const place = ["Digit1", "Digit2", "Digit3"].indexOf(event.code), i = STOPS[at].order[place]
  if (place < 0 || phase !== "ask" || card.hidden || event.ctrlKey || event.metaKey || event.target.matches?.("input[type=text]")) return
  event.preventDefault()
  if (!event.shiftKey) return answer(i)
  hands[i]++
  write()
}

// Sliders and player are the visitor's, who begins at that of the stop
function takeTurn() {
  phase = "turn"
  write()
  by(STOPS[at].turn).focus()
}

// A curve drawn by hand over the view, kept while the run draws itself beside it
function connectSketch(canvas) {
  let drawing = false
  canvas.addEventListener("pointerdown", (event) => { drawing = true; sketch = []; canvas.setPointerCapture(event.pointerId) })
  canvas.addEventListener("pointermove", (event) => {
    if (!drawing) return
    const box = canvas.getBoundingClientRect()
    sketch.push([(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height])
  })
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { drawing = false })
}

function drawSketch() {
  const canvas = by("tour-sketch"), { sketch: wanted } = STOPS[at]
  canvas.hidden = !wanted || phase === "wait"
  canvas.dataset.open = phase === "ask"
  if (canvas.hidden) return
  const { clientWidth: width, clientHeight: height } = canvas
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height })
  const pen = canvas.getContext("2d")
  pen.clearRect(0, 0, width, height)
  pen.strokeStyle = colour("--slip")
  pen.lineWidth = 4
  pen.lineCap = pen.lineJoin = "round"
  pen.beginPath()
  for (const [x, y] of sketch) pen.lineTo(x * width, y * height)
  pen.stroke()
}
