// Which run is on screen, and its playing and scrubbing, without asking the server.

import { heard, order } from "./channel.js"
import { by, closest } from "./dom.js"
import { AFTER, firstOfPath } from "./events.js"
import { spoken } from "./quantities.js"
import { Run } from "./run.js"
import { chunkFrom } from "./skeleton.js"
import { restore, sendNext } from "./steer.js"
import { alone, ended, exact, me, now, reduced, set, touch, view } from "./store.js"

let coming = null // the run that takes the place of what is on screen once it is whole

export function connect() {
  view(["playing", "dragging", "stale", "lost", "run", "following", "preview"], roll)
  view(["playing", "instead"], () => {
    by("play").textContent = (me.instead ? !me.instead.paused : me.playing) ? "Pause" : "Play"
  })
  view(["run"], () => { by("play").disabled = !me.run })
  view(["dragging"], () => {
    clearTimeout(completing)
    completing = setTimeout(() => { if (!me.dragging && me.run?.few) showPredicted(false) }, AFTERWARDS)
  })
}

// A chunk of the run on screen, or of the one to come
export function receive(chunk) {
  if (chunk.run === me.run?.number) me.run.add(chunk)
  else if (!replaced(chunk)) return
  if (me.following) me.at = me.run.length - 1
  else if (me.place) toPlace()
  touch("run")
}

// Add a chunk of a run that is not on screen yet, and return whether it takes the screen. It does at once; but where a
// predicted or a stored run of the same scene is shown, only when it is complete, so that nothing jumps
function replaced(chunk) {
  if (coming?.number !== chunk.run) coming = new Run(chunk.run, chunk.head)
  coming.add(chunk)
  if (!coming.whole && standsIn(me.run, chunk)) return false
  begin(coming)
  return true
}

// Whether a run on screen stands in for the one of a chunk
function standsIn(run, { state }) {
  return run?.stored ? !me.stale : Boolean(run?.followed || run?.checked) && state === "refining"
}

const asked = [] // functions that receive whether the run on screen has frames of the solver now
// Whether the run on screen has frames of the solver, in a while: those of a prediction come when somebody wants them
export function framed() {
  if (me.lost || !(me.run.followed || me.run.checked)) return Promise.resolve(!me.lost)
  order("release", { exact: true })
  return new Promise((answer) => { asked.push(answer) })
}

let predicted = null, count = 0 // the skeleton of the last prediction; how many runs were made of them
const AFTERWARDS = 50 // ms after a slider is let go, which is on screen by then, until all increments are computed
const MEASURED = 60 // increments of a prediction that the axes are fitted to, beside those at slips
let completing = 0

// The skeleton of where a slider is, or was a moment ago; first the server hears where it is now. checked: numbers of
// states, folds and landings of a prediction that is exact
export function follow({ acknowledged, skeleton, checked }) {
  heard(acknowledged)
  sendNext()
  if (!me.run?.length || me.waiting.some(({ what }) => checked || what !== "scene")) return // of another experiment
  predicted = skeleton
  showPredicted(me.dragging && !checked, checked)
}

// A predicted run at the displacement on screen; few: with few increments, on the axes of the run before. One that is
// checked has the approach, too
function showPredicted(few, checked) {
  const { run: before } = me, U_x = before.sheared >= 0 && now() >= before.sheared ? before.curves.U_x[now()] : 0
  const chunk = chunkFrom(predicted, few, U_x), run = new Run(--count, chunk.head)
  const shown = closest(chunk.columns.U_x, U_x)
  Object.assign(run, { followed: !checked, checked, few })
  const { slip, index } = chunk.columns, every = Math.ceil(slip.length / MEASURED)
  const measured = (k) => k % every === 0 || index[k] === 0 || slip[k] || slip[k + 1]
  run.add(chunk, few ? [0, shown] : [...slip.keys()].filter(measured))
  if (few) run.keepSpans(before)
  begin(run)
  if (checked) toPlace()
  else set({ at: shown, following: false, place: null })
}

// A stored run takes the screen until the computed one is whole
export function standIn(run) {
  begin(run)
  if (me.following) set({ at: me.playing ? run.beginning : run.length - 1, following: false })
  else if (me.place) toPlace()
}

// A run takes the screen; the one that was there when the change began stays behind it, pale
function begin(run) {
  coming = null
  if (me.start === null || me.start.sheared >= 0) me.ghost = me.start
  // its increments are others
  if (me.run?.length && !me.following && (!exact(me.run) || me.run.head.step !== run.head.step)) {
    me.place ??= me.run.place(now())
  }
  set({ run, preview: null })
  if (!run.checked) for (const answer of asked.splice(0)) answer(!run.followed)
}

// The increment of this run where that shown before would be
function toPlace() {
  const there = me.run.atPlace(me.place)
  if (there !== null) set({ at: there, place: null })
}

export const isPlayed = () => me.playing && !me.dragging && (!me.stale || me.lost || me.run?.stored)
  && !me.following && me.run?.sheared >= 0 && me.preview === null

let last = null // ms, of the last step of playing; null: it does not play
function roll() {
  if (last !== null || !isPlayed()) return
  last = performance.now()
  requestAnimationFrame(step)
}

function step(time) {
  const passed = Math.max(0, Math.min((time - last) / 1000, 0.1))
  last = isPlayed() ? time : null
  if (last === null) return
  requestAnimationFrame(step) // first: what `advance` changes is then drawn in its own frame
  advance(passed)
}

// A run begins slowly, so that there is time to see its first stick and slip
const STICK = 6 // s, at least, from the begin of shear to the first slip: two sentences of 2.5 s
const SLIP = 3 // s, at least, for the way that the sentence is about the slip

// Speed (nm/s) of the top at frame `at`, where `speed` is wanted
export function paceAt(run, at, speed) {
  const first = firstOfPath(run)?.at ?? null, { step: size } = run.head
  if (first === null || at < run.sheared || at > first + AFTER / size) return speed
  return Math.min(speed, at < first ? ((first - run.sheared) * size) / STICK : AFTER / SLIP)
}

let seen = 0 // number of the run that has been played to its end
function advance(passed) {
  const { run } = me, { step: size } = run.head
  me.clock += passed
  const speed = seen === run.number ? me.speed : paceAt(run, me.at, me.speed)
  me.at += (passed * speed) / size
  const whole = run.stored || run.followed || ended()
  if (whole && me.at > run.length - 1 + me.speed / size) { // after a second at the end
    seen = run.number
    me.at = run.beginning
  }
}

export function play(on) {
  me.playing = on
  if (!on) { // a run that is computed goes on, but what is on screen stays
    set({ following: false, at: Math.min(me.at, (me.run?.length ?? 1) - 1) })
    summarise("Paused")
  } else {
    me.preview = null // where the mouse rests on a curve
    by("announcement").textContent = ""
  }
}

export function toggle() {
  if (me.instead) me.instead = { ...me.instead, paused: !me.instead.paused }
  else play(!me.playing)
}

export const move = (frames) => goto(Math.floor(me.at) + frames)

export const toSlip = (way) => me.run && goto(me.run.nextSlip(Math.floor(me.at), way))

export function goto(k) {
  if (me.playing) play(false)
  set({ following: false, preview: null, place: null, at: Math.max(0, Math.min(k, (me.run?.length ?? 1) - 1)) })
  if (me.run?.curves.slip[now()]) summarise("Slip")
  else by("announcement").textContent = "" // what was announced at another increment is not true of this one
}

// A sentence for those who hear the page: at rest only, as a sentence for every frame is a flood
function summarise(what) {
  const { run } = me, k = now()
  if (k < 0) return
  const { U_x, F, L, A, slip, slip_at } = run.values(k)
  const at = slip && !run.normal && !run.approaching(k) ? slip_at : U_x // as the sentence says it
  by("announcement").textContent = `${what} at a displacement of ${spoken("U_x", at)}: `
    + `friction ${spoken("F", F)}, load ${spoken("L", L)}, `
    + (run.head.flat ? "all in contact." : `contact ${spoken("A", A)} wide.`)
}

export function reset() {
  const plain = by("speed").querySelector("[selected]")
  by("speed").value = plain.value
  set({ ghost: null, start: null, following: !alone, preview: null, place: null, playing: !reduced,
    speed: Number(plain.value), ...(alone && { at: me.run.beginning }) })
  restore({})
}
