// Pinned runs, drawn behind the run on screen.

import { charts } from "./charts.js"
import { beside } from "./curves.js"
import { drawnFrame, sideways } from "./punch.js"

const WIDE = 2.5, THIN = 1.2 // px: friction and area, load

const DASHES = [[6, 4], [2, 4], [2, 4, 6, 4], [6, 4, 2, 4]] // px, of the pins in turn

export const style = (slot) => ({ ink: `--pin-${slot}`, dash: DASHES[slot - 1] })

// Lines of some runs, each in the colour and dashes of its pin
const looking = (lines) => (
  { list: lines.map(({ pin, width = WIDE, x, y }) => ({ x, y, width, ...style(pin.slot) })) })

let lines = 0, surfaces = 0 // how many are drawn

// Curves and outlines in the map
export function drawLines(run, ghost, approach) {
  const pins = beside(run)
  if (!pins.length && !lines) return
  lines = pins.length
  const line = (pin, name, width) => {
    const { along: x, value: y } = pin.run.drawn(name, approach)
    return { pin, width, x, y }
  }
  const forces = (pin) => [line(pin, "F"), line(pin, "L", THIN)]
  charts.forces.fill("pins", looking(pins.flatMap(forces)))
  charts.area.fill("pins", looking(pins.map((pin) => line(pin, "A"))))
  charts.map.fill("pins", looking(approach ? [] : pins.flatMap(outline)))
}

// Both edges of contact over the path, until a leg turns; gaps where nothing is repelled
function outline(pin) {
  const { run } = pin, { stage } = run.curves
  const frames = run.frames((k) => k >= run.sheared && stage[k] === stage[run.sheared])
  const x = frames.map((k) => run.along[k])
  return run.head.flat ? [] : run.edgesOver(frames).map((y) => ({ pin, x, y, width: 2 }))
}

// The frame of a pinned run whose top has been pulled, or pressed, as far as that of the run on screen
const matched = ({ run: pinned }, run, k) =>
  (k < run.sheared ? Math.min(k, pinned.sheared) : pinned.nearest(run.along[k], Math.max(k, pinned.sheared)))

export function drawSurfaces(run, k) {
  const pins = beside(run).filter((pin) => !pin.run.head.flat)
  if (!pins.length && !surfaces) return
  surfaces = pins.length
  charts.punch.fill("pins", looking(pins.map((pin) => {
    const { drawn: x, gap: y } = drawnFrame(pin.run, matched(pin, run, k), sideways(run))
    return { pin, x, y, width: 2 }
  })))
}
