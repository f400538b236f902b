// The values of the moment in large, in projector mode.

import { by, minus } from "./dom.js"

export const projected = () => document.documentElement.dataset.view === "projector"

export function tellLarge(run, k) {
  if (!projected()) return
  const v = run.values(k), { force, middle, flat } = run.places[k][0].head
  const [friction, contact] = by("large").querySelectorAll("b")
  friction.textContent = `F = ${minus(Number((v.F_bar * force).toPrecision(3)))} N/m`
  contact.textContent = `A = ${Math.round(v.A_bar * 2 * middle)} nm`
  contact.parentElement.hidden = flat
}
