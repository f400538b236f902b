// Draws the picture: a frame, the curves of the run on screen. Nothing is drawn again that is as it was.

import { drawBands } from "./bands.js"
import { charts } from "./charts.js"
import { drawCurves } from "./curves.js"
import { by } from "./dom.js"
import { isPlayed } from "./player.js"
import { drawFrame, fitFrames } from "./punch.js"
import { cost, frame, me, memory, set, touch } from "./store.js"
import { connectStory, drawStory } from "./story.js"

const QUIET = 150 // ms between two drawings of a growing run: it needs the processor itself
const REST = 1.5 // times as long as a picture took, until the next while playing: leaves an old laptop time for others

const increment = memory(), curves = memory()
let curvesAt = 0 // ms, when they were drawn
let timer = 0

export function connect() {
  frame(["run", "ghost", "beside", "at", "preview", "instead", "playing", "dragging", "following", "look"], draw)
  frame(["picture"], drawPunch)
  charts.punch.fill("story", { draw: drawStory })
  connectStory()
  charts.punch.under = drawBands
}

// The increment to show: that pointed at, or played at
export const shown = () => Math.max(0, Math.min(Math.floor(me.preview ?? me.at), me.run.length - 1))

function draw() {
  const { run, instead } = me, time = performance.now()
  if (instead) return drawIncrement(instead.run, instead.k)
  if (!run?.length || (run.sheared < 0 && !me.following && me.at > run.length - 1)) return
  const k = shown()
  by("scrub").max = run.whole ? run.length - 1 : Math.max(run.length - 1, Number(by("scrub").max) || 0)
  if (run.sheared >= 0) drawPart(run, k, time)
  if (isPlayed() && time < cost.ended + REST * cost.of && me.picture?.run === run) return
  if (!increment(run, k, run.whole, me.ghost, me.beside, me.playing, me.dragging || run.few, me.look)) return
  drawIncrement(run, k)
  by("scrub").value = k
}

// The curves of the part of the path that frame k belongs to
function drawPart(run, k, time) {
  const approach = run.approaching(k), grows = run === me.charted && !run.whole && approach === me.approach
  if (grows && time - curvesAt < QUIET) return again(QUIET)
  if (!curves(run, run.length, run.whole, me.ghost, me.beside, approach, me.look)) return
  curvesAt = time
  fitFrames(run)
  drawCurves(run, me.ghost, approach)
  set({ approach, charted: run })
}

function again(pause) {
  clearTimeout(timer)
  timer = setTimeout(() => touch("run"), pause)
}

// All that shows frame k of a run, or of a motion through a slip
function drawIncrement(run, k) {
  drawFrame(run, k)
  by("scrub").setAttribute("aria-valuetext", `${run.leg(k)} increment ${run.curves.index[k]}`)
  me.picture = { run, k }
}

// The punch is painted anew, whatever of it has changed
function drawPunch() {
  if (!me.picture) return
  const { run, k } = me.picture
  charts.punch.changed = true
  if (run !== me.run) return
  me.drawn = k
}
