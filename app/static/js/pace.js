// How fast a run is played: its first stick and slip slower than the rest, so that there is time to see them.

import { AFTER, firstSlip } from "./sentence.js"

const STICK = 6 // s, at least, from the begin of shear to the first slip: two sentences of 2.5 s
const SLIP = 3 // s, at least, for the way that the sentence is about the slip

// Speed (nm/s) of the top at frame `at`, where `speed` is wanted
export function paceAt(run, at, speed) {
  const first = firstEnd(run), { step } = run.head
  if (first === null || at < run.sheared || at > first + AFTER / step) return speed
  return Math.min(speed, at < first ? ((first - run.sheared) * step) / STICK : AFTER / SLIP)
}

// The frame of the first slip after the approach, of any stage on a path through points; null where there is none
function firstEnd(run) {
  if (run.normal) return null
  if (run.head.abscissa !== "path") return firstSlip(run)?.at ?? null
  const at = run.nextSlip(run.sheared, 1)
  return at > run.sheared ? at : null
}
