// The live sentence beside the hero: what happens now, and what the last change has done.

import { by } from "./dom.js"
import { changeSaid, nowSaid } from "./sentence.js"
import { me } from "./state.js"

const HOLD = 700 // ms for which a sentence stays, unless a slip happens
let said = { key: "", at: 0 }, compared = [] // what is on screen since when; the runs last compared

export function tellNow(run, k) {
  const now = nowSaid(run, k), time = performance.now(), urgent = now.key.startsWith("slip") || !me.playing
  if (now.key !== said.key && (urgent || time - said.at > HOLD)) {
    said = { key: now.key, at: time }
    by("sentence").textContent = now.text
  }
  if (compared[0] === run && compared[1] === me.ghost && compared[2] === run.whole) return
  compared = [run, me.ghost, run.whole]
  by("why").textContent = changeSaid(run, me.ghost)?.text ?? ""
}
