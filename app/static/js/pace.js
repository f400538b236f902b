// How fast a run is played: its first stick and slip slower than the rest, so that there is time to see them.

import { AFTER, firstSlip } from "./sentence.js"

const STICK = 6 // s, at least, from the begin of shear to the first slip: two sentences of 2.5 s
const SLIP = 3 // s, at least, for the way that the sentence is about the slip

// Speed (nm/s) of the top at frame `at`, where `speed` is wanted
export function paceAt(run, at, speed) {
  const first = run.normal ? null : firstSlip(run), { step } = run.head
  if (!first || at < run.sheared || at > first.at + AFTER / step) return speed
  return Math.min(speed, at < first.at ? ((first.at - run.sheared) * step) / STICK : AFTER / SLIP)
}
