// Draws the picture: a frame, the curves and the map of the run on screen. Nothing is drawn again that is as it was.

import { drawBands } from "./bands.js"
import { charts } from "./charts.js"
import { beside, drawCurves, drawMap } from "./curves.js"
import { by } from "./dom.js"
import { isPlayed } from "./player.js"
import { drawFrame, drawnFrame, fitFrames, sideways } from "./punch.js"
import { cost, frame, me, memory, set, touch } from "./store.js"
import { drawStory, tellNow } from "./story.js"
import { tellFrame } from "./words.js"

const QUIET = 150 // ms between two drawings of a growing run: it needs the processor itself
const HELD = 250 // ms between two drawings of the map while a slider is held: the curves come first
const REST = 1.5 // times as long as a picture took, until the next while playing: leaves an old laptop time for others

const WIDE = 2.5, THIN = 1.2 // px, of pinned runs: friction and area, load

const increment = memory(), curves = memory(), map = memory()
let curvesAt = 0, mapAt = 0 // ms, when they were drawn
let timer = 0

export function connect() {
  frame(["run", "ghost", "pins", "at", "preview", "instead", "playing", "dragging", "following", "look"], draw)
  frame(["picture"], drawPunch)
  charts.punch.fill("story", { draw: drawStory })
  charts.punch.under = drawBands
}

// The increment to show: that pointed at, or played at
const shown = () => Math.max(0, Math.min(Math.floor(me.preview ?? me.at), me.run.length - 1))

function draw() {
  const { run, instead } = me, time = performance.now()
  if (instead) return drawIncrement(instead.run, instead.k)
  if (!run?.length || (run.sheared < 0 && !me.following && me.at > run.length - 1)) return tellPicture()
  const k = shown()
  by("scrub").max = run.whole ? run.length - 1 : Math.max(run.length - 1, Number(by("scrub").max) || 0)
  if (run.sheared >= 0) {
    drawPart(run, k, time)
    drawStage(run, k, time)
  }
  if (isPlayed() && time < cost.ended + REST * cost.of && me.picture?.run === run) return
  if (!increment(run, k, run.whole, me.ghost, me.pins, me.playing, me.dragging || run.few, me.look)) {
    if (run.few && !me.dragging) tellNow(run, k) // the hand rests: the sentence is that of this picture
    return
  }
  drawIncrement(run, k)
  by("scrub").value = k
}

// The curves of the part of the path that frame k belongs to
function drawPart(run, k, time) {
  const approach = run.approaching(k), grows = run === me.charted && !run.whole && approach === me.approach
  if (grows && time - curvesAt < QUIET) return again(QUIET)
  if (!curves(run, run.length, run.whole, me.ghost, me.pins, approach, me.look)) return
  curvesAt = time
  fitFrames(run)
  drawCurves(run, me.ghost, approach)
  drawPins(run, approach)
  set({ approach, charted: run })
}

// The map of the stage that frame k belongs to
function drawStage(run, k, time) {
  if (map(run, run.length, run.stageOfMap(k), me.look)) me.mapped = false
  if (me.mapped) return
  const growing = run.whole ? 0 : QUIET, pause = me.dragging ? HELD : growing
  if (time - mapAt < pause) return again(pause)
  mapAt = time
  drawMap(run, k)
  me.mapped = true
}

function again(pause) {
  clearTimeout(timer)
  timer = setTimeout(() => touch("run"), pause)
}

// The picture stays until the increment to show has come; once the hand rests, so does its sentence
function tellPicture() {
  if (me.picture && !me.playing && !me.dragging) tellNow(me.picture.run, me.picture.k)
}

// All that shows frame k of a run, or of a motion through a slip
function drawIncrement(run, k) {
  drawFrame(run, k)
  drawPinnedSurfaces(run, k)
  tellNow(run, k)
  tellFrame(run, k)
  me.picture = { run, k }
}

// The punch is painted anew, whatever of it has changed
function drawPunch() {
  if (!me.picture) return
  const { run, k } = me.picture
  charts.punch.changed = true
  if (run !== me.run) return
  if (me.drawn < 0) document.querySelector(".page").dataset.drawn = "" // figures come into sight
  me.drawn = k
}

// Lines of pinned runs, each in the colour and dashes of its pin
const lines = (list) => (
  { list: list.map(({ pin: { ink, dash }, width = WIDE, x, y }) => ({ x, y, width, ink, dash })) })

// Pinned runs behind the run on screen: their curves, and outlines in the map, which is not painted without need
let pinned = 0 // how many are drawn
function drawPins(run, approach) {
  const pins = beside(run)
  if (!pins.length && !pinned) return
  pinned = pins.length
  const line = (pin, name, width) => {
    const { along: x, value: y } = pin.run.drawn(name, approach)
    return { pin, width, x, y }
  }
  charts.forces.fill("pins", lines(pins.flatMap((pin) => [line(pin, "F"), line(pin, "L", THIN)])))
  charts.area.fill("pins", lines(pins.map((pin) => line(pin, "A"))))
  charts.map.fill("pins", lines(approach ? [] : pins.flatMap(outline)))
}

// Both edges of contact over the path, until a leg turns; gaps where nothing is repelled
function outline(pin) {
  const { run } = pin, { stage } = run.curves
  const frames = run.frames((k) => k >= run.sheared && stage[k] === stage[run.sheared])
  const x = frames.map((k) => run.along[k])
  return run.head.flat ? [] : run.edgesOver(frames).map((y) => ({ pin, x, y, width: 2 }))
}

// The frame of a pinned run whose top has been pulled, or pressed, as far as that of the run on screen
const matched = ({ run: of }, run, k) =>
  (k < run.sheared ? Math.min(k, of.sheared) : of.nearest(run.along[k], Math.max(k, of.sheared)))

function drawPinnedSurfaces(run, k) {
  charts.punch.fill("pins", lines(beside(run).filter((pin) => !pin.run.head.flat).map((pin) => {
    const { drawn: x, gap: y } = drawnFrame(pin.run, matched(pin, run, k), sideways(run))
    return { pin, x, y, width: 2 }
  })))
}
