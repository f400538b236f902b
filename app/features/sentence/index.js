// The live sentence beside the picture, and what the last change has done.

import { by, tell } from "../../static/js/dom.js"
import { frame, me, memory } from "../../static/js/store.js"
import { changeSentence, nowSentence, phaseSentence, saidNext } from "./sentence.js"

// While the hand rests it is that of the picture, also where the increment to show has not come yet
export const connect = () => frame(["picture", "playing", "dragging", "run", "ghost"], () => {
  if (me.picture) tellNow(me.picture.run, me.picture.k)
})

const compared = memory() // the runs
let sentence = { key: "", text: "", k: 0, since: -Infinity } // on screen

// The live sentence beside the hero: the phase while it plays, what happens at rest; and what the last change has done
function tellNow(run, k) {
  const moving = me.playing || me.dragging, next = moving ? phaseSentence(run, k) : nowSentence(run, k)
  const said = saidNext(sentence, next, { moving, k, run, dragging: me.dragging, time: performance.now() })
  tell(by("sentence"), said.text)
  me.said = said.text
  sentence = said
  if (!compared(run, me.ghost, run.whole)) return
  const changed = changeSentence(run, me.ghost)?.text ?? ""
  tell(by("why"), changed)
  by("announcement").textContent = changed // the text on the run before is out of date
}
