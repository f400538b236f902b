// The tour beside the hero: stops, each with a prediction before the run draws itself. Loaded when it is asked for.

import { sceneChanges } from "./address.js"
import { charts, CURVES } from "./charts.js"
import { by, make, makeButton, readdress, tell } from "./dom.js"
import { openPage } from "./pages.js"
import { goto, play } from "./player.js"
import { fixed, minus } from "./quantities.js"
import { firstSlip } from "./sentence.js"
import { restore } from "./steer.js"
import { exact, frame, me, redraw, set, view } from "./store.js"
import { drawSprings } from "./tour/springs.js"
import { STOPS } from "./tour/stops.js"
import { choose, lettersAreKeys } from "./view.js"

const { dataset } = document.documentElement
let before = null // {U} of the first slip of the usual scene, to compare with
let unseen = null // the scene that nobody has seen
let at = 0, phase = "ask", chosen = null, card = null

export function openTour(stop = 1) {
  readdress((asked) => asked.delete("tour")) // it opens the tour, and whoever gets a link from here would be in it
  addEventListener("popstate", left)
  at = Math.max(0, Math.min(STOPS.length - 1, stop - 1))
  card ??= makeCard()
  card.hidden = false
  if (document.querySelector(".page").dataset.page) openPage("")
  begin()
}

function close() {
  card.hidden = true
  delete dataset.tour
  delete dataset.shows
  redraw()
  for (const name of CURVES) curtain(name).hidden = true
  removeEventListener("popstate", left)
  by("tour").focus()
}

// Back may bring another scene, which is not that of the question; where it closes a page the tour goes on
function left() {
  if (sceneChanges()) close()
}

function makeCard() {
  const made = make("section", { id: "tour-card", "aria-label": "Tour" })
  made.addEventListener("keydown", (event) => { if (event.key === "Escape") close() })
  document.addEventListener("keydown", onDigit)
  document.querySelector(".views").append(made)
  view(["status", "run", "lost", "stale", "drawn"], watch)
  frame(["drawn", "run", "look"], hideFuture)
  frame(["look"], drawReason)
  return made
}

const figureOf = (name) => document.querySelector(`.view[data-view="${name}"]`)

// A scene is asked for, and its future hidden until the prediction is made
function begin() {
  const stop = STOPS[at]
  phase = "wait"
  chosen = null
  unseen = stop.unseen && before ? stop.unseen[Math.floor(Math.random() * stop.unseen.length)] : null
  choose(stop.curve)
  restore({ preset: stop.preset, ...asTexts(wanted()) })
  write()
}

const wanted = () => ({ ...STOPS[at].values, ...unseen?.values })
const asTexts = (values) => Object.fromEntries(Object.entries(values).map(([name, value]) => [name, `${value}`]))

// Whether the server is at the scene of the stop
const atStop = () => {
  const { preset, values } = me.status
  return preset === STOPS[at].preset
    && Object.entries(wanted()).every(([name, value]) => Number(values[name]) === value)
}
const ready = () => me.status.state === "finished" && atStop() && me.run?.whole && exact(me.run)
  && !me.stale
const failed = () => me.status.state === "failed" && atStop()

// With the usual scene, what others are compared with; the last stop begins again once that is known
function learn() {
  if (me.status.preset !== "fig6" || Object.keys(wanted()).length) return false
  before = firstSlip(me.run)
  return Boolean(STOPS[at].unseen)
}

// The places of the right answer first: of a scene that nobody has seen, from its run
function right() {
  if (!STOPS[at].unseen) return 0
  const now = firstSlip(me.run)
  if (!now || now.U > before.U + 0.1) return 1
  return now.U < before.U - 0.1 ? 0 : 2
}

const NAMES = {
  E: ["a stiffness of", "GPa"], delta_bar: ["a press depth of", "δ₀"], phi_ratio: ["a grip of", "times the adhesion"],
}
function filled(text) {
  const [[name, value]] = Object.entries(unseen?.values ?? { E: 70 }), [head, unit] = NAMES[name]
  const now = phase === "wait" ? null : firstSlip(me.run)
  const parts = {
    change: `${head} ${minus(value)} ${unit}`, reason: unseen?.why ?? "",
    before: before ? fixed(before.U, 1) : "", after: now ? fixed(now.U, 1) : "no place",
  }
  return text.replaceAll(/{(\w+)}/g, (_, part) => parts[part])
}

const waiting = () => (me.lost ? "The tour continues when the server answers again."
  : failed() ? `The run of this stop failed: ${me.status.why} Go to another stop.` : "getting ready …")

function watch() {
  if (!card || card.hidden) return
  if (phase === "wait") tell(card.querySelector("p"), waiting())
  if (phase === "wait" && ready()) {
    if (learn()) return begin()
    phase = "ask"
    goto(me.run.sheared)
    write()
    card.querySelector("button.answer")?.focus()
  }
  if (phase === "show" && me.run.curves.U_x[Math.max(0, me.drawn)] >= STOPS[at].to) {
    // a slow machine plays in leaps
    goto(me.run.curves.U_x.findIndex((place, k) => k >= me.run.sheared && place >= STOPS[at].to))
    phase = "why"
    write()
  }
}

function answer(index) {
  chosen = index
  phase = "show"
  set({ at: Math.max(0, me.run.sheared), following: false })
  play(true)
  write()
}

const curtains = {}
const curtain = (name) => curtains[name] ??= figureOf(name).appendChild(make("div", { className: "future" }))

// What lies ahead of the increment shown stays hidden until it is the visitor's turn: it answers later stops
function hideFuture() {
  if (!card || card.hidden) return
  for (const name of CURVES) {
    const box = charts[name].box, hidden = phase === "turn" || !box || !me.run
    curtain(name).hidden = hidden
    if (hidden) continue
    const ahead = phase === "wait" || me.run.sheared < 0, far = box.left + box.width + 2
    const x = (ahead ? box.left : box.X(me.run.along[Math.max(me.run.sheared, me.drawn)])) + 1
    Object.assign(curtain(name).style,
      { left: `${x}px`, top: `${box.top}px`, width: `${Math.max(0, far - x)}px`, height: `${box.height}px` })
  }
}

const paragraph = (className, ...parts) => make("p", { className }, ...parts)

function write() {
  const stop = STOPS[at]
  const title = make("h2", {}, `${at + 1} of ${STOPS.length}: ${stop.name}`)
  Object.assign(dataset, { tour: phase, shows: stop.shows ?? "" })
  card.replaceChildren(make("div", { className: "top" }, title, makeButton({ onclick: close }, "End tour")))
  if (phase === "wait") card.append(paragraph("", waiting()))
  else if (phase === "turn") card.append(paragraph("question", stop.ask))
  else writeQuestion(stop)
  if (phase === "why") writeReason(stop)
  if (phase !== "show" && phase !== "ask") card.append(make("div", { className: "answers ways" }, ...ways()))
  if (phase === "why") card.querySelector(".ways").lastElementChild.focus({ preventScroll: true })
  hideFuture()
}

function writeQuestion(stop) {
  const asking = phase === "ask"
  if (asking && stop.hints) card.append(make("ul", {}, ...stop.hints.map((text) => make("li", {}, text))))
  card.append(paragraph("question", filled(stop.question)))
  card.append(make("div", { className: "answers" }, ...stop.order.map(answerButton).filter(Boolean)))
  if (phase === "show") card.append(paragraph("note", "Watch …"))
}

function writeReason(stop) {
  const yes = make("b", {}, chosen === right() ? "Yes. " : "Not so. ")
  card.append(make("p", { role: "status" }, yes, filled(stop.why)))
  if (stop.springs) card.append(make("canvas", { className: "springs" }))
  drawReason()
}

// Its picture, also in another size or theme
function drawReason() {
  const picture = card.querySelector(".springs")
  if (picture && !card.hidden) drawSprings(picture, me.run, Math.max(me.run.sheared, me.drawn))
}

// Buttons to the stop before, to the visitor's turn, and on; the last leads to the end
function ways() {
  const next = STOPS[at + 1], buttons = []
  if (at) buttons.push(makeButton({ onclick: () => openTour(at) }, "Previous"))
  if (phase === "why") buttons.push(makeButton({ onclick: takeTurn }, "Your turn"))
  if (next) buttons.push(makeButton({ onclick: () => openTour(at + 2) }, `Next: ${next.name}`))
  else if (phase === "turn") {
    buttons.push(makeButton({ onclick: () => openPage("load", { what: "sweep" }) }, "Friction over load"),
      makeButton({ onclick: close }, "Finish"))
  }
  return buttons
}

// An answer; once the reason is shown, only that chosen and the right one
function answerButton(i) {
  const reason = i === right() ? "right" : i === chosen && "wrong"
  const mark = { show: i === chosen && "chosen", why: reason }[phase]
  if (phase === "why" && !mark) return null
  const given = { className: "answer", disabled: phase !== "ask", onclick: () => answer(i), data: mark ? { mark } : {} }
  return makeButton(given, STOPS[at].answers[i])
}

// 1 to 3 choose an answer
function onDigit(event) {
  const place = ["Digit1", "Digit2", "Digit3"].indexOf(event.code), i = STOPS[at].order[place]
  if (place < 0 || !lettersAreKeys() || phase !== "ask" || card.hidden || event.ctrlKey || event.metaKey
    || event.target.matches?.("input[type=text]")) return
  event.preventDefault()
  answer(i)
}

// Sliders and player are the visitor's, who begins at that of the stop
function takeTurn() {
  phase = "turn"
  write()
  by(STOPS[at].turn).focus()
}
