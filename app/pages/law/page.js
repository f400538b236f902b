// The page "Interface law": every node of the increment shown, as a dot on the law drawn by page.py.

import { by } from "../../static/js/dom.js"
import { fill } from "../../static/js/figures.js"

const FAINT = 1e-3 // share of the tangential traction below which its factor over s is not resolved

let law // {spacing, peak: where sticking ends, nm} of the scene on screen

export const receive = (news) => { law = news.law }

export function frame(run, k) {
  if (!law) return
  // which may be another than that of the law
  const { middle, scene: { delta_n, delta_t, phi_n, phi_ratio } } = run.head
  const a = law.spacing, phi_t = phi_ratio * phi_n, nodes = run.frame(k), { x, gap, T_n, T_t } = nodes
  const s = new Float32Array(x.length), shear = new Float32Array(x.length), normal = new Float32Array(x.length)
  for (let i = 0; i < x.length; i++) {
    const place = x[i] + middle
    s[i] = place - a * Math.round(place / a)
    // of the tangential traction at gap 0
    const left = (1 + law.opening * gap[i] / delta_n) * Math.exp(-gap[i] / delta_n)
    shear[i] = phi_t > 0 && Math.abs(left) > FAINT ? (T_t[i] * delta_t) / (phi_t * left) : NaN
    let sum = 0
    for (let j = Math.ceil((s[i] - 5 * delta_t) / a); j * a <= s[i] + 5 * delta_t; j++)
      sum += Math.exp(-(((j * a - s[i]) / delta_t) ** 2))
    normal[i] = (T_n[i] * delta_n) / phi_n / sum
  }
  const stateOf = (i) => (nodes.state(i) === "free" ? "open" : Math.abs(s[i]) <= law.peak ? "stick" : "slip")
  const groups = Object.groupBy(x.keys(), stateOf)
  for (const state of ["stick", "slip", "open"]) {
    const pick = (list) => Float32Array.from(groups[state] ?? [], (i) => list[i])
    const columns = { s: pick(s), gap: pick(gap) }
    fill("law_shear_map", state, columns)
    fill("law_normal_map", state, columns)
    fill("law_shear_law", state, state === "open" ? { s: [], value: [] } : { s: columns.s, value: pick(shear) })
    fill("law_normal_law", state, { gap: columns.gap, value: pick(normal) })
    by(`law-${state}`).textContent = columns.s.length
  }
}
