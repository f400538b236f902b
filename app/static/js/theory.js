// Closed forms over the curves of the run on screen (solver/analysis/theory.py), with *More*: asked for once per run.

import { order, take } from "./channel.js"
import { by, say, tell } from "./dom.js"
import { figureShown, fill } from "./figures.js"
import { exact, me, sees, touch, view } from "./store.js"

const NOTHING = { U_x: [], value: [] }
const known = new WeakMap() // run: its closed forms, {name, of, along, x, y, limit}
let asked = null // the run that they were asked for

export function connectTheory() {
  take("theory", ({ run, curves }) => {
    if (asked?.number !== run) return
    known.set(asked, curves)
    touch("charted")
  })
  view(["charted", "run", "status", "approach", "dragging", "lost", "look"], draw)
}

function draw() {
  const { charted: run } = me, seen = sees("more") && exact(run) && run === me.run ? run : null
  if (seen && !known.has(seen) && seen.whole && seen.number === me.status.run && asked !== seen && !me.lost) {
    asked = seen
    order("theory", { run: seen.number })
  }
  const along = seen && (me.approach ? "delta" : seen.head.abscissa)
  const limits = [["forces", "F"], ["area", "A"]].map(([figure, of]) => {
    const form = known.get(seen)?.find((each) => each.of === of && each.along === along)
    drawOne(figure, form)
    return form ? `Dashed in black: ${form.name}. ${form.limit}` : ""
  })
  say("theory-limits", limits.join(" ").trim())
}

function drawOne(figure, form) {
  const key = by(`theory-${figure}`)
  key.hidden = !form
  if (form) {
    tell(key.querySelector("b"), form.name)
    key.title = form.limit
  }
  if (!figureShown(figure)) return
  fill(figure, "theory", form ? { U_x: form.x, value: form.y } : NOTHING)
}
