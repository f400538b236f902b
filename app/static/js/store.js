// What this visitor sees, in declared fields, and the views of it. Setting a field marks the views that watch it; all
// that are marked draw together: words soon, pictures once in an animation frame, so that all of them are seen.

import { chartsWait, paintCharts } from "./charts.js"
import { by, root } from "./dom.js"

export const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches
export const embedded = new URLSearchParams(location.search).get("embed") === "1" // in a page of somebody else's
export const alone = "alone" in root.dataset // a Result that is played, without a server (app/stage.py)
// Whether a part of *More* is in sight: of the page, or because the tour shows it at this stop
export const sees = (part) => by("more").ariaPressed === "true" || me.shows === part
export const declared = {} // what Python declares, as main.js receives it

// {name: {give(), take(what was given)}}: what features carry over when the page is loaded again as it was
export const CARRIED = {}

const fields = {
  // the run on screen, the pale one behind it, the computed run that was on screen when the change began
  run: null, ghost: null, start: null,
  beside: [], more: {}, // runs drawn with it; {quantity: lists of values that its axis holds, too}
  at: 0, preview: null, drawn: -1, // the frame played at, pointed at, on screen
  picture: null, // {run, k} as drawn last
  said: "", // what happens in it, in words
  instead: null, // {run, k, paused}: drawn in place of the increment
  pointed: null, // {name, x, y}: the chart that the mouse points at, and px in it
  playing: !reduced, following: true, speed: 0, clock: 0, // clock: s of playing
  status: {}, waiting: [], // the last message of the server; {n, what, values} of scenes without an answer
  // no server; the sliders say another scene; the place of the path to go to once it is there
  lost: false, stale: false, place: null,
  entered: null, dragging: false, // {parameter: text} not yet sent; whether a slider is held
  move: { name: "" }, // parameters changed by hand: one object for as long as it is one movement
  rests: 400, // ms without a move, after which a hand rests although it holds on
  charted: null, approach: false, // the run whose curves are drawn; which part
  shows: "", // the part of *More* that is in sight without it
  look: 0, // counts changes of size, colours, units or options: everything is drawn anew
}

// A further field, which a feature declares
export function declare(values) {
  for (const name in values) {
    if (name in fields) throw new TypeError(`the field ${name} is declared twice`)
    fields[name] = values[name]
    watchers[name] = []
  }
}

const views = [], frames = [] // {draw, due}
const watchers = Object.fromEntries(Object.keys(fields).map((name) => [name, []])) // {field: those that watch it}

function watch(list, names, draw) {
  const made = { draw, due: true }
  for (const name of names) watchers[name].push(made)
  list.push(made)
  schedule()
}

// Call `draw` soon, and whenever one of these fields was set: for words and controls
export const view = (names, draw) => watch(views, names, draw)
// Call `draw` in the next animation frame, before the charts are painted
export const frame = (names, draw) => watch(frames, names, draw)

// Mark what watches these fields, as their contents have changed
export function touch(...names) {
  for (const name of names) for (const watcher of watchers[name]) watcher.due = true
  schedule()
}

export function set(values) {
  for (const name in values) {
    if (!(name in fields)) throw new TypeError(`${name} is no field of the store`)
    if (fields[name] === values[name]) continue
    fields[name] = values[name]
    touch(name)
  }
}

export const me = new Proxy(fields, { set: (_, name, value) => { set({ [name]: value }); return true } })
Object.defineProperty(fields, "fresh", { get: () => viewing || painting }) // something is not drawn yet, for tests
globalThis.punch ??= me // for the console, and for tests
root.punch = me

let viewing = false, painting = false // whether either is to come
function schedule() {
  if (viewing) return
  viewing = true
  queueMicrotask(runViews)
}

export const cost = { of: 0, ended: 0 } // ms that the last picture took, and when it was done

function runViews() {
  viewing = false
  drawAll(views)
  if (painting || !(frames.some(({ due }) => due) || chartsWait())) return
  painting = true
  requestAnimationFrame(paint)
}

function paint() {
  const begun = performance.now()
  drawAll(frames)
  paintCharts()
  const ended = performance.now()
  Object.assign(cost, { of: ended - begun, ended })
  painting = false
}

// Draw what waits at once, as before the page is printed
export function drawNow() {
  runViews()
  paint()
}

function drawAll(list) {
  for (const watcher of list) {
    if (!watcher.due) continue
    watcher.due = false
    try {
      watcher.draw()
    } catch (error) {
      reportError(error) // the other views are drawn
    }
  }
}

// Draw everything anew
export const redraw = () => { me.look++ }
// Draw the punch and pages anew
export const redrawPunch = () => touch("picture")

// Whether any of some values is another than before
export function memory() {
  let before = []
  return (...values) => {
    const other = values.some((value, i) => value !== before[i])
    before = values
    return other
  }
}

// The increment played at, of the run on screen; -1 before there is any
export const now = () => Math.min(Math.floor(me.at), (me.run?.length ?? 0) - 1)

// Whether the run of the last status goes no further
export const ended = () => ["finished", "skipped", "failed"].includes(me.status.state)

// Whether a run was computed, and does not follow a held slider
export const exact = (run) => Boolean(run) && !run.followed && !run.stored

// A change begins: the computed run on screen stays behind its successor, pale, unless there is nothing to compare
export function beginChange(compare = true) {
  if (!compare || exact(me.run)) me.start = compare ? me.run : null
}
