// The increment on screen in numbers. Forces are per metre of depth; the area is in nm, and over w.

import { isShown } from "../../static/js/colours.js"
import { by, make, tell } from "../../static/js/dom.js"
import { fixed, named, spoken, withUnit } from "../../static/js/quantities.js"
import { frame, me, view } from "../../static/js/store.js"

export function connect() {
  by("computed").after(make("p", { id: "increment", className: "extra" }))
  frame(["picture"], tellFrame)
  view(["picture", "said", "playing", "dragging"], tellSummary)
}

// What happens on screen, for those who hear the page: the sentence, and the numbers
function summary(run, k, said) {
  const { U_x, F, L, A } = run.values(k), area = run.head.flat ? "" : `, contact ${spoken("A", A)} wide`
  return `Now: ${said} Displacement ${spoken("U_x", U_x)}, friction ${spoken("F", F)}, `
    + `load ${spoken("L", L)}${area}.`
}

// What is on screen at rest, for those who hear the page
function tellSummary() {
  const { picture, said, playing, dragging } = me
  if (picture && !playing && !dragging) tell(by("now"), summary(picture.run, picture.k, said))
}

// The increment on screen in numbers: above the player with *More*, and for those who hear the page
function tellFrame() {
  const { run, k } = me.picture ?? {}
  if (!run) return
  const v = run.values(k), stage = run.stage(k)
  if (!isShown(by("readout"))) return
  const slipped = v.slip ? (run.normal || run.approaching(k) ? ", JUMP" : ", SLIP") : ""
  const looped = stage !== "approach" && run.head.span[0] < 0 && !run.normal
  const work = looped ? `work since shear began ${fixed(v.work - run.curves.work[run.sheared], 0)} nJ/m` : ""
  const top = run.driven ? ` (top ${withUnit("U_x", run.top(k))})` : ""
  const texts = [
    `${run.leg(k)} ${v.index}: ${named("U_x", v.U_x)}${top},`, `${named("delta", v.delta)},`,
    `${named("F", v.F)},`, `${named("L", v.L)},`, `${named("A", v.A)} (Ā = ${fixed(v.A_bar * 1000, 1)}·10⁻³)${slipped}`,
    work,
  ]
  by("increment").textContent = run.followed ? "This increment is predicted from the run before."
    : run.checked ? "This increment lies between states that were checked."
    : `This increment: residual ${v.residual.toExponential(0)} nm, ${v.evaluations} force evaluations.`
  texts.forEach((text, i) => { by("readout").children[i].textContent = text })
}
