// How fast a run is played: its first stick and slip slower than the rest, so that there is time to see them.

import { AFTER, firstOfPath } from "./sentence.js"

const STICK = 6 // s, at least, from the begin of shear to the first slip: two sentences of 2.5 s
const SLIP = 3 // s, at least, for the way that the sentence is about the slip

// Speed (nm/s) of the top at frame `at`, where `speed` is wanted
export function paceAt(run, at, speed) {
  const first = firstOfPath(run)?.at ?? null, { step } = run.head
  if (first === null || at < run.sheared || at > first + AFTER / step) return speed
  return Math.min(speed, at < first ? ((first - run.sheared) * step) / STICK : AFTER / SLIP)
}
