// The values of the moment in large, in projector mode.

import { by, minus } from "./dom.js"

const NOUGHT = 1e-6 // of the largest force of the run: round-off
export const projected = () => document.documentElement.dataset.view === "projector"

export function tellLarge(run, k) {
  if (!projected()) return
  const v = run.values(k)
  const [friction, contact] = by("large").querySelectorAll("b")
  const [name, word] = run.normal || run.approaching(k) ? ["L", "load "] : ["F", "friction "] // what the path is about
  const told = Math.abs(v[name]) < NOUGHT * run.strongest ? 0 : Number(v[name].toPrecision(3))
  friction.previousSibling.textContent = word
  friction.textContent = `${name} = ${minus(told)} N/m`
  contact.textContent = `A = ${Math.round(v.A)} nm`
  contact.parentElement.hidden = run.head.flat
}
