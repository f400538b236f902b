// The page "Interface law": every node of the increment shown, as a dot on the law drawn by page.py.

import { by } from "../../static/js/dom.js"
import { fill } from "../../static/js/figures.js"

const FAINT = 0.02 // share of the tangential traction below which its factor over s is not resolved: nodes are left out

let law // {spacing, peak: where sticking ends, nm} of the scene on screen

export const receive = (news) => { law = news.law }

// J (N/m) and the mode angle (degrees) of the trailing and the leading edge of frame k, as `solver.release_rates`: from
// the middle of the contact outwards, the work of both tractions, and what the springs in the middle store. None where
// several parts are in contact, or a node in contact has passed to another site
function edgesOf(run, k) {
  const { first, spacing, middle } = run.headOf(k), { delta_n, delta_t, phi_n, phi_ratio } = run.head.scene
  const patches = run.patches(k), { x, gap, T_n, T_t } = run.frame(k)
  if (patches.length !== 1) return []
  const [from, to] = patches[0].map((at) => at - first), center = Math.round((from + to) / 2)
  const u = x.map((place, i) => place - ((first + i) * spacing - middle))
  if (u.some((shift, i) => i >= from && i <= to && Math.abs(shift) > spacing / 2)) return []
  const closed = Math.exp(-gap[center] / delta_n), opening = 1 + (law.opening * gap[center]) / delta_n
  const normal = (phi_n / delta_n ** 2) * (1 - gap[center] / delta_n) * closed
  const shear = ((2 * phi_ratio * phi_n) / delta_t ** 2) * opening * closed
  return [-1, 1].map((step) => {
    let J_n = T_n[center] ** 2 / (2 * normal), J_t = shear > 0 ? T_t[center] ** 2 / (2 * shear) : 0
    for (let i = center; i + step in x; i += step) {
      J_n -= 0.5 * (T_n[i] + T_n[i + step]) * (gap[i + step] - gap[i])
      J_t += 0.5 * (T_t[i] + T_t[i + step]) * (u[i + step] - u[i])
    }
    const angle = Math.atan2(Math.sqrt(Math.max(J_t, 0)), Math.sqrt(Math.max(J_n, 0)))
    return { angle: (angle * 180) / Math.PI, value: J_n + J_t }
  })
}

function drawEdges(run, k) {
  const edges = edgesOf(run, k)
  for (const [i, label] of ["trailing", "leading"].entries()) {
    const of = (name) => Float32Array.from(edges.length ? [edges[i][name]] : [])
    fill("law_toughness", label, { angle: of("angle"), value: of("value") })
  }
}

export function frame(run, k) {
  if (!law) return
  drawEdges(run, k)
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
  const held = (i) => (Math.abs(s[i]) <= law.peak ? "stick" : "slip")
  const stateOf = (i) => (nodes.state(i) === "free" ? "open" : held(i))
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
