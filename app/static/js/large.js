// The values of the moment in large, in projector mode.

import { by, minus } from "./dom.js"

const NOUGHT = 1e-6 // of the largest force of the run: round-off
export const projected = () => document.documentElement.dataset.view === "projector"

export function tellLarge(run, k) {
  if (!projected()) return
  const v = run.values(k), { force, middle, flat } = run.places[k][0].head
  const [friction, contact] = by("large").querySelectorAll("b")
  const [name, word] = run.normal || run.approaching(k) ? ["L", "load "] : ["F", "friction "] // what the path is about
  const value = v[`${name}_bar`], told = Math.abs(value) < NOUGHT * run.strongest ? 0 : Number((value * force).toPrecision(3))
  friction.previousSibling.textContent = word
  friction.textContent = `${name} = ${minus(told)} N/m`
  contact.textContent = `A = ${Math.round(v.A_bar * 2 * middle)} nm`
  contact.parentElement.hidden = flat
}
