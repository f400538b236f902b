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

const PULLED_OFF = { key: "off end", text: "It pulls off: the contact cannot hold this pull any longer." }

// Whether frame k is the last one of a run that ends there, under a held load: then the status says where
const pullsOff = (run, k) => run.whole && k === run.length - 1 && me.status.state === "finished" && me.status.why
  && run.scene.hold === "load" && !run.followed

// The live sentence beside the hero: the phase while it plays, what happens at rest; and what the last change has done
function tellNow(run, k) {
  const moving = me.playing || me.dragging
  const next = pullsOff(run, k) ? PULLED_OFF : moving ? phaseSentence(run, k) : nowSentence(run, k)
  const said = saidNext(sentence, next, { moving, k, run, dragging: me.dragging, time: performance.now() })
  tell(by("sentence"), said.text)
  me.said = said.text
  sentence = said
  if (!compared(run, me.ghost, run.whole)) return
  const changed = changeSentence(run, me.ghost)?.text ?? ""
  tell(by("why"), changed)
  by("announcement").textContent = changed // the text on the run before is out of date
}
