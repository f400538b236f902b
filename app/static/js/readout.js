// The increment on screen in numbers: under the views with tools, for those who hear the page, and beside the sliders.

import { isShown } from "./colours.js"
import { by, tell } from "./dom.js"
import { fixed, named, spoken, withUnit } from "./quantities.js"
import { me } from "./store.js"
import { areaText, forceText, summary } from "./words.js"

export function tellFrame(run, k) {
  const v = run.values(k), stage = run.stage(k)
  by("scrub").setAttribute("aria-valuetext", `${run.leg(k)} increment ${v.index}: ${spoken("U_x", v.U_x)}`)
  if (!me.playing && !me.dragging) tell(by("now"), summary(run, k, by("sentence").textContent))
  if (!isShown(by("readout"))) return
  const slipped = v.slip ? (run.normal || run.approaching(k) ? ", JUMP" : ", SLIP") : ""
  const looped = stage !== "approach" && run.head.span[0] < 0 && !run.normal
  const work = looped ? `work since shear began ${fixed(v.work - run.curves.work[run.sheared], 0)} nJ/m` : ""
  const top = run.driven ? ` (top ${withUnit("U_x", run.top(k))})` : ""
  const texts = [
    `${run.leg(k)} ${v.index}: ${named("U_x", v.U_x)}${top},`, `${named("delta", v.delta)},`,
    `${forceText(v, "F")},`, `${forceText(v, "L")},`, `${areaText(v)}${slipped}`,
    work,
  ]
  by("solver").lastElementChild.textContent =
    `This increment: residual ${v.residual.toExponential(0)} nm, ${v.evaluations} force evaluations.`
  texts.forEach((text, i) => { by("readout").children[i].textContent = text })
}
