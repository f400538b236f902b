// Receives frames, and plays and scrubs them without asking the server.

import { drawBands } from "./bands.js"
import { heard, order } from "./channel.js"
import { by, digits, fixed } from "./dom.js"
import { drawCurves, drawMap, painted } from "./figures.js"
import { paceAt } from "./pace.js"
import { framePage } from "./pages.js"
import { tellFrame } from "./readout.js"
import { Run } from "./run.js"
import { Picture } from "./picture.js"
import { drawFrame, fitFrames } from "./punch.js"
import { exact, frameDrawn, me, now, QUIET, reduced } from "./state.js"
import { checkTruth, tellState } from "./status.js"
import { drawStory, tellNow } from "./story.js"
import { drawFringes } from "./fringes.js"

const HELD = 250 // ms between two pictures of the map while a slider is held: the curves come first
const REST = 1.5 // times as long as a picture took, until the next while playing: leaves an old laptop time for others

let coming = null // the run that takes the place of what is on screen once it is whole
let bornAt = 0, freshAt = 0, mappedAt = 0 // ms, when the run came on screen, and when curves and map were drawn last
let stage = null // of the map

export function receive(chunk) {
  if (chunk.run === me.run?.number) me.run.add(chunk)
  else if (!replaced(chunk)) return
  if (me.following) me.at = me.run.length - 1
  else if (me.place) toPlace()
  me.fresh = true // drawn with the next picture of the screen: chunks may come faster than those
}

// Take in a chunk of another run than that on screen. One that replaces what is shown in its place while a slider is
// held does so when it is whole, so that nothing jumps; any other at once. Whether it has
function replaced(chunk) {
  if (coming?.number !== chunk.run) coming = new Run(chunk.run, chunk.head)
  const { status } = me, known = status.run === chunk.run
  if (!coming.length && known && status.after && me.origin?.number === status.after[0])
    coming.takeOver(me.origin, status.after[1])
  coming.add(chunk)
  const waits = me.run?.stored ? !me.stale : me.run && !exact(me.run) && !(known && status.state === "running")
  if (waits && !coming.whole) return false
  begin(coming)
  coming = null
  return true
}

// A picture of where the hand is, or was a moment ago
export function follow(message) {
  if (!me.run?.length) return
  const picture = new Picture(message, me.run, me.status.values)
  heard(picture.heard)
  begin(picture)
  coming = null
  Object.assign(me, { at: picture.shown, following: false, fresh: true })
  tellState()
  if (!painting) drawDue(performance.now()) // not an animation frame later
}

// A stored run takes the screen until the computed one is whole
export function standIn(run) {
  begin(run)
  if (me.following) Object.assign(me, { at: me.playing ? Math.max(0, run.sheared) : run.length - 1, following: false })
  else if (me.place) toPlace()
  me.fresh = true
  tellState()
}

// A new run takes the screen; what was there when the change began stays behind, pale
function begin(run) {
  if (me.anchor !== null) me.ghost = me.behind === null || me.behind.sheared >= 0 ? me.behind : me.ghost
  me.anchor = null
  // its increments are others
  if (me.run?.length && !me.following && (!exact(me.run) || me.run.head.step !== run.head.step)) {
    me.place ??= me.run.place(now())
  }
  me.run = run
  if (me.status.run === run.number) run.scene = me.status.scene
  by("play").disabled = false
  checkTruth()
  bornAt = performance.now()
  me.preview = null
}

// The increment on screen: that pointed at, or played at
const shown = () => Math.max(0, Math.min(Math.floor(me.preview ?? me.at), me.run.length - 1))

// The curves of the part of the path that it belongs to
function drawPart(run) {
  me.approach = run.approaching(shown())
  drawCurves(run, me.ghost, me.approach)
}

// The increment of this run where that shown before would be
function toPlace() {
  const there = me.run.atPlace(me.place)
  if (there !== null) Object.assign(me, { at: there, place: null })
}

function showFresh() {
  if (me.run.sheared >= 0) {
    fitFrames(me.run)
    drawPart(me.run)
    me.begun = me.run.number
    checkTruth()
    me.mapped = false
  }
  by("scrub").max = Math.max(me.run.length - 1, Number(by("scrub").max) || 0)
  if (me.run.sheared >= 0 || me.following) showFrame()
}

async function drawFresh(time) {
  me.fresh = "drawing"
  freshAt = time
  await drawPicture(showFresh)
  if (me.fresh === "drawing") me.fresh = false // nothing came meanwhile
}

// The map takes longest: it is painted in an animation frame of its own
async function drawLate(time) {
  stage = me.run.stageOfMap(me.drawn)
  mappedAt = time
  await drawPicture(() => drawMap(me.run, me.drawn))
  me.mapped = true
}

let moved = false // another increment is to be shown
let painting = false // Bokeh has changes that are not on screen
let onCanvases = null // {run, k, ofPage: whether it is the increment of the page} that the canvases do not show yet

export const show = () => { moved = true }
export const isPainting = () => painting

// Make changes; once Bokeh has painted them, draw what lies on canvases over and under its figures
export async function drawPicture(change) {
  painting = true
  try {
    await painted(change)
    if (onCanvases) drawCanvases(onCanvases)
  } finally {
    painting = false
    onCanvases = null
  }
}

function drawCanvases({ run, k, ofPage }) {
  if (ofPage && me.drawn < 0) document.querySelector(".page").dataset.drawn = "" // figures come into sight
  if (ofPage) me.drawn = k
  drawFringes(run, k)
  drawStory(run, k)
  drawBands(run, k)
  if (!ofPage) return
  framePage()
  frameDrawn(run, k)
}

function showFrame() {
  const { run } = me
  if (!run?.length) return
  const k = shown()
  moved = false
  drawIncrement(run, k)
  onCanvases.ofPage = true
  if (run.sheared >= 0 && me.begun === run.number) {
    if (me.approach !== run.approaching(k)) drawPart(run)
    if (stage !== run.stageOfMap(k)) me.mapped = false
  }
  by("scrub").value = k
}

// All that shows frame k of a run, or of a motion through a slip
export function drawIncrement(run, k) {
  drawFrame(run, k)
  onCanvases = { run, k, ofPage: false }
  tellNow(run, k)
  tellFrame(run, k)
}

let before = 0
export function tick(time) {
  const passed = Math.min((time - before) / 1000, 0.1)
  before = time
  if (isPlayed()) advance(passed, time)
  if (!painting && me.run?.length) drawDue(time)
  requestAnimationFrame(tick)
}

const isPlayed = () => me.playing && !me.dragging && (!me.stale || me.lost || me.run?.stored) && !me.run?.followed
  && !me.following
  && me.run?.sheared >= 0 && me.preview === null

// What is not on screen yet, one thing in an animation frame
function drawDue(time) {
  const { run } = me, since = (then) => run.whole || time - then > QUIET
  const mapDue = !me.mapped && me.begun === run.number && since(Math.max(mappedAt, bornAt))
  if (me.fresh === true && (me.begun !== run.number || since(freshAt))) drawFresh(time)
  else if (mapDue && !(me.dragging && time - mappedAt < HELD)) drawLate(time)
  else if (moved) drawNext()
}

let seen = 0 // number of the run that has been played to its end
function advance(passed, time) {
  const { step } = me.run.head, last = me.run.length - 1
  me.clock += passed
  const speed = seen === me.run.number ? me.speed : paceAt(me.run, me.at, me.speed)
  me.at += (passed * speed) / step
  const ended = me.run.stored || ["finished", "skipped"].includes(me.status.state)
  if (ended && me.at > last + me.speed / step) { // after a second at the end
    seen = me.run.number
    me.at = me.run.beginning
  }
  if (Math.min(Math.floor(me.at), last) !== Math.min(me.drawn, last) && time > Math.max(next, me.quiet)) show()
}

let next = 0 // ms, when another picture may be drawn
async function drawNext() {
  const begun = performance.now()
  let changed = begun, woken = begun // when the changes were made, and when Bokeh began to paint them, ms
  await drawPicture(() => {
    requestAnimationFrame(() => { woken = performance.now() })
    showFrame()
    changed = performance.now()
  })
  const done = performance.now()
  next = done + REST * (changed - begun + done - woken)
}

export function play(on) {
  me.playing = on
  if (!on) {
    me.at = Math.min(me.at, (me.run?.length ?? 1) - 1)
    show()
    summarise("Paused")
  } else by("told").textContent = ""
  if (!me.run?.stored && ["running", "paused", "warming"].includes(me.status.state)) order(on ? "go" : "pause")
  namePlay()
  tellState()
}

let reel = null // {paused} of a slow motion on screen, which the button and its key pause
export function setReel(given) {
  reel = given
  namePlay()
}

export function toggle() {
  if (!reel) return play(!me.playing)
  reel.paused = !reel.paused
  namePlay()
}

const namePlay = () => { by("play").textContent = (reel ? !reel.paused : me.playing) ? "Pause" : "Play" }

export function move(frames) {
  const target = Math.floor(me.at) + frames
  if (frames > 0 && target >= (me.run?.length ?? 0) && me.status.state === "paused") {
    me.following = true
    order("one")
  } else goto(target)
}

export const toSlip = (way) => me.run && goto(me.run.nextSlip(Math.floor(me.at), way))

export function goto(k) {
  if (me.playing) play(false)
  Object.assign(me, { following: false, preview: null, at: Math.max(0, Math.min(k, (me.run?.length ?? 1) - 1)) })
  show()
  if (me.run?.curves.slip[now()]) summarise("Slip")
  else by("told").textContent = "" // what was announced at another increment is not true of this one
}

// A sentence for those who hear the page: at rest only, as what is said at every frame is a flood
function summarise(what) {
  const { run } = me, k = now()
  if (k < 0) return
  const v = run.values(k)
  by("told").textContent = `${what} at a displacement of ${fixed(v.U_x, 1)} nanometres: friction ${digits(v.F)}, `
    + `load ${digits(v.L)} newtons per metre, `
      + (run.head.flat ? "all in contact." : `contact ${fixed(v.A, 0)} nanometres wide.`)
}

export function reset() {
  Object.assign(me, { ghost: null, behind: null, anchor: null, following: true, preview: null, playing: !reduced })
  const plain = by("speed").querySelector("[selected]")
  by("speed").value = plain.value
  me.speed = Number(plain.value)
  order("restore", {})
  namePlay()
}
