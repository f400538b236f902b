// The tour beside the hero: stops, each with a prediction before the run draws itself. Loaded when it is asked for.

import { order } from "../../static/js/channel.js"
import { charts, CURVES } from "../../static/js/charts.js"
import { by, focused, make, makeButton, one, readdress, tell } from "../../static/js/dom.js"
import { firstSlip } from "../../static/js/events.js"
import { drawAtoms } from "../../static/js/lattice.js"
import { cleared, inks } from "../../static/js/pen.js"
import { goto, play } from "../../static/js/player.js"
import { differing, fixed, minus } from "../../static/js/quantities.js"
import { restore } from "../../static/js/steer.js"
import { exact, frame, me, redraw, set, view } from "../../static/js/store.js"
import { choose } from "../../static/js/view.js"
import { inWords } from "../../static/js/words.js"
import { sceneChanges } from "../history/index.js"
import { openPage } from "../pages/index.js"
import { ownStop, slipValue, STOPS } from "./stops.js"

const known = {} // {base: first slip of a scene that another one is compared with}
let unseen = null // the scene that nobody has seen
let at = 0, phase = "ask", chosen = null, card = null
const OWN = -1 // the place of a question that a teacher has written
const here = () => (at === OWN ? ownStop(me.lesson) : STOPS[at])
const baseOf = ({ preset, values }) => JSON.stringify([preset, values])

// Open the tour at a stop; by default at the first one, or where the class is. A teacher takes the class along
export function openTour(stop = 0) {
  const there = me.lesson?.stop ?? -1
  if (!stop && there >= 0) return enterStop(there - 1)
  enterStop(Math.max(0, Math.min(STOPS.length - 1, stop - 1)))
  return lead()
}

function enterStop(place) {
  readdress((asked) => asked.delete("tour")) // it opens the tour, and whoever gets a link from here would be in it
  addEventListener("popstate", left)
  at = place
  card ??= makeCard()
  card.hidden = false
  if (one(".sheet:not([hidden])")) openPage("")
  begin()
}

const shown = () => card && !card.hidden
let led = 0, leading = false // number of the question that the class was at last; whether this page brought it there
function lead() {
  if (!me.lesson?.leads) return
  leading = true
  order("lead", { stop: at + 1, phase: "ask" })
}

// The class is at another stop, or its answers have come
export function follow() {
  const { leads, stop, asked, phase: theirs } = me.lesson, moved = asked !== led
  if (stop === undefined) {
    if (leads && shown() && at !== OWN) lead() // the tour was open before the class
    return
  }
  led = asked
  if (moved && leading) leading = false
  else if (moved) return enterStop(stop - 1)
  if (!shown() || phase !== "ask" || stop !== at + 1) return
  if (theirs === "run") show()
  else if (card.dataset.phase === theirs) tellAnswered()
  else write()
}

const inClass = () => me.lesson?.stop === at + 1
const student = () => inClass() && !me.lesson.leads && me.lesson.phase !== "run"
const teacher = () => inClass() && me.lesson.leads
let voted = {} // {asked, chosen}: of the question that this page has answered
const answeredBy = () => {
  const { answered, here: of } = me.lesson
  return `${answered} of ${of} answered`
}
function tellAnswered() {
  const said = card.querySelector(".counted")
  if (said) tell(said, answeredBy())
}

function close() {
  card.hidden = true
  Object.assign(me, { tour: "", shows: "" })
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
  one(".views").append(made)
  view(["status", "run", "lost", "stale", "drawn"], watch)
  frame(["drawn", "run", "look"], hideFuture)
  frame(["look"], drawReason)
  return made
}

// A scene is asked for, and its future hidden until the prediction is made
function begin() {
  const stop = here()
  phase = "wait"
  chosen = student() && voted.asked === me.lesson.asked ? voted.chosen : null
  unseen = stop.unseen && baseOf(stop) in known ? stop.unseen[pick(stop.unseen.length)] : null
  choose(stop.curve)
  restore({ preset: stop.preset, ...asTexts(wanted()) })
  write()
}

// One of so many scenes: a class has the same one
const pick = (count) => Math.floor((me.lesson ? parseInt(me.lesson.code, 36) : Math.random() * count) % count)

const wanted = () => ({ ...here().values, ...unseen?.values })
const asTexts = (values) => Object.fromEntries(Object.entries(values).map(([name, value]) => [name, `${value}`]))

// Whether the server is at the scene of the stop
const atStop = () => {
  const { preset, values } = me.status
  return preset === here().preset && !differing(wanted(), values).length
}
const ready = () => me.status.state === "finished" && atStop() && me.run?.whole && exact(me.run)
  && !me.stale
const failed = () => me.status.state === "failed" && atStop()

// A stop about a scene that nobody has seen begins again once it is known what that is compared with
function learn() {
  if (unseen) return false
  known[baseOf(here())] = firstSlip(me.run)
  return Boolean(here().unseen)
}

// Before and now: what a stop about a scene that nobody has seen asks of their first slips
const compared = () => [known[baseOf(here())], firstSlip(me.run)].map((slip) => slipValue(here().of, slip))

// The place of the right answer: of a scene that nobody has seen, from its run
function right() {
  if (!here().unseen) return 0
  const [then, now] = compared()
  if (then === now || Math.abs(now - then) < here().same(then)) return 2
  return now < then ? 0 : 1
}

const NAMES = {
  E: ["a stiffness of", "GPa"], delta_bar: ["a press depth of", "δ₀"], phi_ratio: ["a grip of", "times the adhesion"],
}
function filled(text) {
  if (!here().unseen) return text
  const changes = Object.entries(unseen?.values ?? {}).map(([name, value]) => {
    const [head, unit] = NAMES[name] ?? [`${inWords(name)} =`, ""]
    return `${head} ${minus(value)} ${unit}`.trim()
  })
  const [then, now] = compared().map((value) => (Number.isFinite(value) ? fixed(value, 1) : "no place"))
  const parts = { change: changes.join(", "), reason: unseen?.why ?? "", before: then, after: now }
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
  const to = phase === "show" ? Math.min(here().to ?? (firstSlip(me.run)?.U ?? Infinity) + 1, me.run.along.at(-1)) : 0
  if (phase === "show" && me.run.curves.U_x[Math.max(0, me.drawn)] >= to) {
    // a slow machine plays in leaps
    goto(me.run.curves.U_x.findIndex((place, k) => k >= me.run.sheared && place >= to))
    phase = "why"
    write()
  }
}

const mayAnswer = () => phase === "ask" && !teacher() && chosen === null && !(student() && me.lesson.phase === "shown")

function answer(index) {
  if (!mayAnswer()) return
  chosen = index
  if (!student()) return show()
  voted = { asked: me.lesson.asked, chosen }
  order("vote", { answer: index })
  write()
}

function show() {
  phase = "show"
  set({ at: Math.max(0, me.run.sheared), following: false })
  play(true)
  write()
}

const curtains = {}
const curtain = (name) => curtains[name] ??= charts[name].view.appendChild(make("div", { className: "future" }))

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
  const stop = here()
  const title = make("h2", {}, at === OWN ? stop.name : `${at + 1} of ${STOPS.length}: ${stop.name}`)
  const held = card.contains(focused())
  Object.assign(me, { tour: phase, shows: stop.shows ?? "" })
  card.dataset.at = phase
  card.dataset.phase = (inClass() && me.lesson.phase) || ""
  card.replaceChildren(make("div", { className: "top" }, title, makeButton({ onclick: close }, "End tour")))
  if (phase === "wait") card.append(paragraph("", waiting()))
  else if (phase === "turn") card.append(paragraph("question", stop.ask))
  else writeQuestion(stop)
  if (phase === "why") writeReason(stop)
  if (phase !== "show" && phase !== "ask") card.append(make("div", { className: "answers ways" }, ...ways()))
  if (phase === "why") card.querySelector(".ways").lastElementChild?.focus({ preventScroll: true })
  if (held && !card.contains(focused()))
    (card.querySelector(".lead") ?? card.querySelector("button")).focus()
  hideFuture()
}

function writeQuestion(stop) {
  const asking = phase === "ask"
  if (asking && stop.hints) card.append(make("ul", {}, ...stop.hints.map((text) => make("li", {}, text))))
  card.append(paragraph("question", filled(stop.question)))
  card.append(make("div", { className: "answers" }, ...stop.order.map(answerButton).filter(Boolean)))
  if (phase === "show") card.append(paragraph("note", "Watch …"))
  if (asking && student() && chosen !== null)
    card.append(make("p", { className: "note", role: "status" }, "Your answer counts. Watch the screen."))
  if (asking && teacher()) card.append(...buttonsToLead())
}

// What the teacher sees under a question: how many have answered, then how they did, then the run
function buttonsToLead() {
  const next = me.lesson.counts ? "run" : "shown", text = me.lesson.counts ? "Run" : "Show the answers"
  const go = () => {
    order("lead", { stop: at + 1, phase: next })
    if (next === "run") show()
  }
  return [make("p", { className: "note counted", role: "status" }, answeredBy()),
    make("div", { className: "answers ways" }, makeButton({ className: "lead", onclick: go }, text))]
}

function writeReason(stop) {
  const { counts, answered } = (teacher() && me.lesson) || {}
  const all = counts ? `${counts[right()]} of ${answered} chose the right answer. ` : ""
  const yes = make("b", {}, chosen === null ? all : chosen === right() ? "Yes. " : "Not so. ")
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
  if (me.lesson && !me.lesson.leads) return phase === "why" ? [makeButton({ onclick: takeTurn }, "Your turn")] : []
  if (at > 0) buttons.push(makeButton({ onclick: () => openTour(at) }, "Previous"))
  if (phase === "why") buttons.push(makeButton({ onclick: takeTurn }, "Your turn"))
  if (next) buttons.push(makeButton({ onclick: () => openTour(at + 2) }, `Next: ${next.name}`))
  else if (phase === "turn" && at !== OWN) {
    buttons.push(makeButton({ onclick: () => openPage("load", { what: "sweep" }) }, "Friction over load"),
      makeButton({ onclick: close }, "Finish"))
  }
  return buttons
}

// An answer; once the reason is shown, only that chosen and the right one
function answerButton(i) {
  const reason = i === right() ? "right" : i === chosen && "wrong"
  const mark = { ask: i === chosen && "chosen", show: i === chosen && "chosen", why: reason }[phase]
  if (phase === "why" && !mark) return null
  const given = { className: "answer", disabled: !mayAnswer(), onclick: () => answer(i), data: mark ? { mark } : {} }
  const made = makeButton(given, here().answers[i])
  const { counts, answered } = (teacher() && me.lesson) || {}
  if (counts) {
    made.append(make("b", { className: "votes" }, `${counts[i]}`))
    made.style.setProperty("--part", counts[i] / Math.max(1, answered))
  }
  return made
}

// Sliders and player are the visitor's, who begins at that of the stop
function takeTurn() {
  phase = "turn"
  write()
  by(here().turn).focus()
}

const SPRUNG = 9 // nodes seen with their springs in a reason of the tour
// The picture that argues the reason at some stops of the tour: the trailing edge of frame k of a run
function drawSprings(canvas, run, k) {
  const pen = cleared(canvas), { clientWidth: width, clientHeight: height } = canvas
  if (!pen || run.head.flat) return
  const shape = run.frame(k), edges = run.edges(k), { first, spacing } = run.headOf(k)
  const i = edges ? Math.floor(edges[0] - first) : shape.gap.findIndex((gap) => gap === Math.min(...shape.gap))
  const middle = shape.x[Math.max(0, i)] + 2 * spacing, scale = width / (SPRUNG * spacing), low = 0.72 * height
  const x = (nm) => 0.5 * width + (nm - middle) * scale, y = (nm) => low - nm * scale * 0.8
  drawAtoms({ pen, frame: shape, run, k, ink: inks() }, x, y, scale,
    middle - (SPRUNG * spacing) / 2, middle + (SPRUNG * spacing) / 2)
}
