// The words of a scene and an increment. Forces are per metre of depth; the area is in nm, and over w.

import { isShown } from "./colours.js"
import { by, tell } from "./dom.js"
import { fixed, named, spoken, withUnit } from "./quantities.js"
import { me } from "./store.js"

const labelOf = (name) => document.querySelector(`label[for="${name}-entry"]`)
export const inWords = (name) => labelOf(name)?.firstChild.textContent.trim() || name

export const titleOf = (preset) => document.querySelector(`#preset option[value="${preset}"]`)?.textContent ?? preset

// Names of the parameters in which a scene, as an address has it, differs from its preset
export const changedIn = (address) => Object.keys(address).filter((name) => name in me.status.values)

const MAIN = ["delta_bar", "phi_ratio", "E"]

// Parameters of the scene on screen: the preset, those with a slider, and what differs from the preset
export function parameters({ values, address, preset } = me.status) {
  const changed = changedIn(address), names = new Set([...MAIN, ...changed])
  const text = [...names].map((name) => named(name, values[name])).join(", ")
  return `${titleOf(preset)}${changed.length ? ", changed" : ""}: ${text}`
}

// What happens on screen, for those who hear the page: the sentence, and the numbers
export function summary(run, k, said) {
  const { U_x, F, L, A } = run.values(k), area = run.head.flat ? "" : `, contact ${spoken("A", A)} wide`
  return `Now: ${said} Displacement ${spoken("U_x", U_x)}, friction ${spoken("F", F)}, `
    + `load ${spoken("L", L)}${area}.`
}

// What is on screen at rest, for those who hear the page
export function tellSummary() {
  const { picture, said, playing, dragging } = me
  if (picture && !playing && !dragging) tell(by("now"), summary(picture.run, picture.k, said))
}

// The increment on screen in numbers: above the player with *More*, and for those who hear the page
export function tellFrame(run, k) {
  const v = run.values(k), stage = run.stage(k)
  by("scrub").setAttribute("aria-valuetext", `${run.leg(k)} increment ${v.index}`)
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
    : `This increment: residual ${v.residual.toExponential(0)} nm, ${v.evaluations} force evaluations.`
  texts.forEach((text, i) => { by("readout").children[i].textContent = text })
}
