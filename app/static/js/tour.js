// The tour beside the hero: stops, each with a prediction before the run draws itself. Loaded when it is asked for.

import { frameBox } from "./bokeh.js"
import { order } from "./channel.js"
import { colour } from "./colours.js"
import { by, fixed, make, makeButton, minus, onDrag, readdress, tell } from "./dom.js"
import { CURVES, figures } from "./figures.js"
import { openPage } from "./pages.js"
import { cleared, line } from "./pen.js"
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
  for (const view of CURVES) cover(view).hidden = true
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
  order("restore", { preset: stop.preset })
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

const waiting = () => (me.lost ? "The tour goes on as soon as the server answers again." : "getting ready …")

function watch() {
  watching = requestAnimationFrame(watch)
  if (phase === "wait") tell(card.lastElementChild, waiting())
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

const covers = {}
const cover = (view) => covers[view] ??= figureOf(view).appendChild(make("div", { className: "future" }))

// What lies ahead of the increment shown stays hidden until the stop has been played
function hideFuture() {
  for (const view of CURVES) {
    const box = frameBox(figures[view]), hidden = phase === "why" || phase === "turn" || !box || !me.run
    cover(view).hidden = hidden
    if (hidden) continue
    const ahead = phase === "wait" || me.run.sheared < 0, far = box.left + box.width + 2
    const x = (ahead ? box.left : box.X(me.run.along[Math.max(me.run.sheared, me.drawn)])) + 1
    Object.assign(cover(view).style, { left: `${x}px`, top: `${box.top}px`, width: `${Math.max(0, far - x)}px`, height: `${box.height}px` })
  }
}

const paragraph = (className, ...parts) => make("p", { className }, ...parts)

// A text with its terms explained
function told(tag, className, text) {
  const element = make(tag, { className })
  explain(element, filled(text))
  return element
}

function write() {
  const stop = STOPS[at], asking = phase === "ask", next = STOPS[at + 1]
  const title = make("h2", {}, `${at + 1} of ${STOPS.length}: ${stop.name}`)
  document.documentElement.dataset.tour = phase
  card.replaceChildren(make("div", { className: "top" }, title, makeButton({ onclick: close }, "End tour")))
  if (phase === "wait") return card.append(paragraph("", waiting()))
  if (asking && stop.said) card.append(make("ul", {}, ...stop.said.map((text) => make("li", {}, text))))
  if (phase !== "turn") card.append(told("p", "question", stop.question))
  if (asking && stop.sketch) card.append(paragraph("said", "Draw the curve you expect into the plot if you like, then choose:"))
  const answers = phase === "turn" ? [] : stop.order.map(answerButton).filter(Boolean)
  if (answers.length) card.append(make("div", { className: "answers" }, ...answers))
  if (phase === "show") card.append(paragraph("said", "Watch …"))
  if (asking || phase === "show") return null
  const ways = [make("span", { className: "said" }, stop.ask)]
  if (phase === "why") ways.push(makeButton({ onclick: takeTurn }, "Your turn"))
  if (next) ways.push(makeButton({ onclick: () => openTour(at + 2) }, `Next: ${next.name}`))
  const row = make("div", { className: "answers ways" }, ...ways)
  if (phase === "turn") return card.append(row)
  const yes = make("b", {}, chosen === right() ? "Yes. " : "Not so. ")
  const picture = make("canvas", { className: "picture-of" })
  card.append(make("p", { role: "status" }, yes, told("span", "", stop.why)), picture, row)
  PICTURES[stop.picture](picture, me.run, Math.max(me.run.sheared, me.drawn), before)
  return ways.at(-1).focus({ preventScroll: true })
}

// An answer with the hands raised for it; once the reason is told, only that chosen and the right one
function answerButton(i) {
  const reason = i === right() ? "right" : i === chosen && "wrong"
  const mark = { show: i === chosen && "chosen", why: reason }[phase]
  if (phase === "why" && !mark) return null
  const raised = hands[i] ? [make("span", { className: "hands" }, ` ${hands[i]} hand${hands[i] > 1 ? "s" : ""}`)] : []
  const given = { className: "answer", disabled: phase !== "ask", onclick: () => answer(i), data: mark ? { mark } : {} }
  return makeButton(given, STOPS[at].answers[i], ...raised)
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
  onDrag(canvas, ({ pointerId }) => {
    canvas.setPointerCapture(pointerId)
    return (sketch = [])
  }, (event) => {
    const box = canvas.getBoundingClientRect()
    sketch.push([(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height])
  })
}

function drawSketch() {
  const canvas = by("tour-sketch"), { sketch: wanted } = STOPS[at]
  canvas.hidden = !wanted || phase === "wait"
  canvas.dataset.open = phase === "ask"
  const pen = canvas.hidden ? null : cleared(canvas)
  if (!pen) return
  pen.lineCap = pen.lineJoin = "round"
  line(pen, sketch.map(([x, y]) => [x * canvas.clientWidth, y * canvas.clientHeight]), colour("--slip"), 4)
}
