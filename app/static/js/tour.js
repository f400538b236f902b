// The tour: six stops, each with a prediction before the run draws itself. Loaded when it is asked for.

import { frameBox } from "./bokeh.js"
import { order } from "./channel.js"
import { colour } from "./colours.js"
import { by, readdress } from "./dom.js"
import { figures } from "./figures.js"
import { openPage } from "./pages.js"
import { goto, play } from "./player.js"
import { me } from "./state.js"
import { explain } from "./terms.js"

// preset and values: the scene; to: nm of the path at which a stop ends; answers: the right one first, shown shuffled
// in an order of its own; sketch: the view on which the curve may be drawn beforehand; turn: the slider to play with
const STOPS = [
  {
    name: "Stick", preset: "fig6", values: {}, to: 10, order: [1, 0, 2],
    question: "The top is pulled sideways, slowly. What will the friction force do first?",
    answers: ["grow in proportion to the pull", "stay zero until the punch slides", "jump to its full value at once"],
    why: "Nothing slides yet: the punch leans over, and its surface clings to the lattice sites. The force is that of a spring.",
    turn: "E", ask: "Move the stiffness: how does the slope change?",
  },
  {
    name: "Peel", preset: "fig7-case2", values: {}, to: 12.5, order: [1, 0, 2],
    question: "Still no slip, but the edges of the contact begin to let go. Which one more?",
    answers: ["the trailing edge, behind", "the leading edge, in front", "both the same"],
    why: "The pull opens the gap behind the contact and closes it in front, so that the trailing edge peels by several sites, the leading one by one.",
    turn: "delta_bar", ask: "Pull instead of pushing (indentation below zero): are the edges more alike?",
  },
  {
    name: "Slip and reattach", preset: "fig6", values: {}, to: 20, order: [2, 0, 1], sketch: "area",
    question: "The pull goes on until the punch slips. What will the contact area do at the slip?",
    answers: ["grow: contact comes back", "fall", "stay as it is"],
    why: "A slip by one lattice site releases most of the lean that had peeled the edges: they close again, and the next stick begins.",
    turn: "phi_ratio", ask: "Weaken the grip: how far does the area come back then?",
  },
  {
    name: "Pull instead of push", preset: "fig7-case1", values: {}, to: 16, order: [1, 2, 0],
    question: "The top is held above the surface, so that the punch hangs on its adhesion. Will there be friction?",
    answers: ["yes, even when nothing is repelled any more", "no: friction needs a load", "only as long as the area is not zero"],
    why: "Attraction holds the surfaces in registry as well: the friction force is there at L < 0, and even where A = 0.",
    turn: "delta_bar", ask: "Pull farther: when does it let go for good?",
  },
  {
    name: "Oil it", preset: "fig7-case3", values: {}, to: 12, order: [0, 2, 1],
    question: "A lubricant leaves a tenth of the grip. What will the slips be like?",
    answers: ["early, and nearly all of the area comes back", "late and large", "there will be none"],
    why: "Little lean is stored before the grip gives way, so little has been peeled, and all of it can come back.",
    turn: "phi_ratio", ask: "Where do the slips disappear altogether?",
  },
  {
    name: "Stiffen it", preset: "fig6", values: { E: 700 }, to: 20, order: [2, 1, 0],
    question: "A punch ten times stiffer. How large is the force at which it slips, in newtons per metre?",
    answers: ["larger", "the same", "smaller"],
    why: "The force rises, though over the stiffness (F/(wE)) it falls: a stiff punch hardly leans, so that all of the contact gives way together.",
    turn: "E", ask: "Compare with a soft one: where does one part let go before the other?",
  },
]

let at = 0, phase = "ask", chosen = null, sketch = [], card = null, watching = 0

export function openTour(stop = 1) {
  at = Math.max(0, Math.min(STOPS.length - 1, stop - 1))
  card ??= makeCard()
  card.hidden = false
  if (document.querySelector(".page").dataset.page) openPage("")
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

const make = (tag, props = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), props)
  element.append(...children)
  return element
}

function makeCard() {
  const made = make("section", { id: "tour-card" })
  made.setAttribute("aria-label", "Tour")
  made.addEventListener("keydown", (event) => { if (event.key === "Escape") close() })
  document.querySelector(".page").append(made)
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
  readdress((asked) => asked.set("tour", at + 1))
  order("preset", { preset: stop.preset })
  if (Object.keys(stop.values).length) order("scene", stop.values)
  write()
}

const there = () => {
  const { preset, values, state } = me.status, stop = STOPS[at]
  return state === "finished" && preset === stop.preset && me.run?.whole
    && Object.entries(stop.values).every(([name, value]) => Number(values[name]) === value)
}

function watch() {
  watching = requestAnimationFrame(watch)
  if (phase === "wait" && there()) {
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
    const x = box.left + ((now - start) / (end - start)) * box.width + 1, right = box.left + box.width + 2
    Object.assign(cover(view).style, { left: `${x}px`, top: `${box.top}px`, width: `${Math.max(0, right - x)}px`, height: `${box.height}px` })
  }
}

function write() {
  const stop = STOPS[at]
  document.documentElement.dataset.tour = phase
  const title = make("h2", { textContent: `${at + 1} of ${STOPS.length}: ${stop.name}` })
  const end = make("button", { type: "button", textContent: "End tour", onclick: close })
  card.replaceChildren(make("div", { className: "top" }, title, end))
  if (phase === "wait") card.append(make("p", { textContent: "getting ready …" }))
  else if (phase !== "turn") {
    const question = make("p")
    explain(question, stop.question)
    card.append(question)
    if (stop.sketch && phase === "ask") card.append(make("p", { className: "said", textContent: "Draw the curve you expect into the view “Contact area” if you like, then choose:" }))
    const row = make("div", { className: "answers" })
    for (const i of stop.order) {
      const button = make("button", { type: "button", className: "answer", textContent: stop.answers[i], disabled: phase !== "ask", onclick: () => answer(i) })
      if (phase !== "ask" && (i === chosen || i === 0)) button.dataset.mark = i === 0 ? "right" : "wrong"
      if (phase === "show" && i !== chosen) delete button.dataset.mark
      if (phase === "show" && i === chosen) button.dataset.mark = "chosen"
      row.append(button)
    }
    card.append(row)
  }
  if (phase === "show") card.append(make("p", { className: "said", textContent: "Watch …" }))
  if (phase === "why") {
    const why = make("span")
    explain(why, stop.why)
    const said = make("p", {}, make("b", { textContent: chosen === 0 ? "Yes. " : "Not so. " }), why)
    said.setAttribute("role", "status")
    card.append(said)
  }
  if (phase !== "why" && phase !== "turn") return
  const ways = [make("span", { className: "said", textContent: stop.ask })]
  if (phase === "why") ways.push(make("button", { type: "button", textContent: "Your turn", onclick: takeTurn }))
  if (at + 1 < STOPS.length) ways.push(make("button", { type: "button", textContent: `Next: ${STOPS[at + 1].name}`, onclick: () => openTour(at + 2) }))
  card.append(make("div", { className: "answers" }, ...ways))
  if (phase === "why") ways.at(-1).focus()
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
