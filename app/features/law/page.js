// The page "Interface law": the law of the scene on screen, and every node of the increment shown as a dot on it.

import { valueAt } from "../../static/js/chart.js"
import { addChart, charts, line, marksOf } from "../../static/js/charts.js"
import { pictureOf, shades } from "../../static/js/colours.js"
import { tellLimits } from "../../static/js/curves.js"
import { by } from "../../static/js/dom.js"
import { lawOf } from "../../static/js/law.js"
import { fixed } from "../../static/js/quantities.js"
import { declared } from "../../static/js/store.js"

const FAINT = 0.02 // share of the tangential traction below which its factor over s is not resolved: nodes are left out
const FINE = 160 // pixels of a map, and steps of a curve, along an axis
const LOWEST = -1, HIGHEST = 6 // range of gaps, in delta_n
const OFFSET = "slip distance from the nearest site (nm)", GAP = "gap (nm)"
const DOTTED = { width: 2, dash: [2, 4] }
const LEAST = 0.86 // of a single spring's peak of its tangential factor

// {constants: of the law, phi_n, toughness: {angle, value} or null} of the scene on screen, and `ofLaw(law)`
let law = null, made = null

const range = () => ({ start: 0, end: 1 })
const riders = () => marksOf(declared.riders)

export function connect() {
  const map = (name, symbol) => {
    addChart(name, { x: range(), y: range(), across: OFFSET, up: GAP,
      parts: { map: { kind: "image", picture: null }, ...riders() } })
    charts[name].says = (place) => {
      const T = valueAt(charts[name].parts.map, place)
      const s = `s = ${fixed(place.x, 2)} nm`, gap = `gap = ${fixed(place.y, 2)} nm`
      return T === T ? [s, gap, `${symbol} = ${fixed(T, 3)} GPa`] : null
    }
  }
  const curve = (name, across, up, [start, end]) => addChart(name, { x: range(), y: { start, end }, across, up,
    parts: { zero: { kind: "across", ink: "--grid" }, spring: line("--soft", DOTTED), law: line("--text", { width: 2 }),
      ...riders() } })
  map("law_shear_map", "Tₜ")
  map("law_normal_map", "Tₙ")
  curve("law_shear_law", OFFSET, "Tₜ exp(gap/δₙ) δₜ/φₜ", [-1, 1])
  curve("law_normal_law", GAP, "Tₙ δₙ/(φₙ Σ)", [-0.6, 1.2])
  addChart("law_toughness", { x: { start: 0, end: 80 }, y: range(), across: "mode angle ψ: opening 0°, shear 90° (°)",
    up: "Γ and J (N/m)", parts: { griffith: line("--soft", DOTTED), gamma: line("--text", { width: 2 }),
      ...marksOf(declared.edges) } })
}

export function receive(news) {
  law = news.law ?? null
  if (law) draw()
}

// The factors of the law at places (nm): S0 and S1 of page.py, and the range of what is drawn
function ofLaw({ constants: [, , delta_n, delta_t, period, window, opening] }) {
  const factors = lawOf([1, 2, delta_n, delta_t, period, window, opening]), a = period * delta_t
  const sums = (s) => {
    const [T_x, T_z] = [0, 1].map(() => new Float64Array(s.length))
    factors(s, new Float64Array(s.length), T_x, T_z)
    const shear = T_x.map((T) => -T) // as in the bands below the punch, traction against the motion is positive
    factors(s, new Float64Array(s.length).fill(delta_n), T_x, T_z)
    return { shear, normal: T_z.map((T) => -T * Math.E) }
  }
  return { sums, a, delta_n, delta_t, opening }
}

const steps = (start, end) => Float64Array.from({ length: FINE + 1 }, (_, i) => start + (i / FINE) * (end - start))
const middles = (edges) => edges.subarray(1).map((edge, i) => 0.5 * (edge + edges[i]))

function draw() {
  made = ofLaw(law)
  const { sums, a, delta_n, delta_t, opening } = made
  const s = steps(-a / 2, a / 2), gap = steps(LOWEST * delta_n, HIGHEST * delta_n)
  const [across, upwards] = [s, gap].map((list) => ({ start: list[0], end: list.at(-1) }))
  const opened = (g) => (1 + (opening * g) / delta_n) * Math.exp(-g / delta_n)
  const pulled = (g) => (-g / delta_n) * Math.exp(-g / delta_n)
  const [normal, shear] = law.constants, { shear: along, normal: sites } = sums(middles(s))
  drawMap("law_shear_map", across, upwards, along.map((S) => (shear / 2) * S), middles(gap).map(opened))
  drawMap("law_normal_map", across, upwards, sites.map((S) => normal * S), middles(gap).map(pulled))
  const rise = sums(s).shear, largest = Math.max(LEAST, ...rise.map(Math.abs))
  made.peak = Math.abs(s[rise.indexOf(Math.max(...rise))]) // where sticking ends, nm
  charts.law_shear_law.range("x", across)
  charts.law_shear_law.range("y", { start: -1.15 * largest, end: 1.15 * largest })
  charts.law_shear_law.fill("law", { x: s, y: rise })
  charts.law_shear_law.fill("spring", { x: s, y: s.map((x) => (2 * x) / delta_t * Math.exp(-((x / delta_t) ** 2))) })
  charts.law_normal_law.range("x", upwards)
  charts.law_normal_law.fill("law", { x: gap, y: gap.map(pulled) })
  drawToughness(law)
}

// A map of a traction, GPa, that is one factor over the slip distance times one over the gap
function drawMap(name, { start, end }, { start: low, end: high }, along, over) {
  const values = Float64Array.from({ length: FINE * FINE }, (_, i) => along[i % FINE] * over[Math.floor(i / FINE)])
  const limits = [Math.min(-1e-9, ...values), Math.max(1e-9, ...values)], chart = charts[name]
  chart.range("x", { start, end })
  chart.range("y", { start: low, end: high })
  chart.fill("map", { picture: pictureOf(values, [FINE, FINE], shades(...limits)), limits, values, rows: FINE,
    columns: FINE, x: start, wide: end - start, y: low, high: high - low })
  tellLimits(name, ...limits)
}

function drawToughness({ phi_n, toughness }) {
  const chart = charts.law_toughness, { angle, value } = toughness ?? { angle: [], value: [] }
  chart.fill("griffith", { x: [chart.x.start, chart.x.end], y: [phi_n, phi_n] })
  chart.fill("gamma", { x: angle, y: value })
  chart.range("y", { start: 0, end: toughness ? 1.15 * Math.max(phi_n, ...value) : 1.5 * phi_n })
}

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
  const closed = Math.exp(-gap[center] / delta_n), opening = 1 + (made.opening * gap[center]) / delta_n
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
    const of = (name) => (edges.length ? [edges[i][name]] : [])
    charts.law_toughness.fill(label, { x: of("angle"), y: of("value") })
  }
}

export function frame(run, k) {
  if (!law) return
  drawEdges(run, k)
  // which may be another than that of the law
  const { middle, scene: { delta_n, delta_t, phi_n, phi_ratio } } = run.head
  const { a } = made, phi_t = phi_ratio * phi_n, nodes = run.frame(k), { x, gap, T_n, T_t } = nodes
  const s = Float64Array.from(x, (at) => at + middle - a * Math.round((at + middle) / a))
  const shear = s.map((_, i) => { // of the tangential traction at gap 0
    const left = (1 + made.opening * gap[i] / delta_n) * Math.exp(-gap[i] / delta_n)
    return phi_t > 0 && Math.abs(left) > FAINT ? (T_t[i] * delta_t) / (phi_t * left) : NaN
  })
  const normal = made.sums(s).normal.map((sum, i) => (T_n[i] * delta_n) / phi_n / sum)
  const held = (i) => (Math.abs(s[i]) <= made.peak ? "stick" : "slip")
  const groups = Object.groupBy(x.keys(), (i) => (nodes.state(i) === "free" ? "open" : held(i)))
  for (const state of ["stick", "slip", "open"]) {
    const pick = (list) => Array.from(groups[state] ?? [], (i) => list[i])
    const place = { x: pick(s), y: pick(gap) }
    charts.law_shear_map.fill(state, place)
    charts.law_normal_map.fill(state, place)
    charts.law_shear_law.fill(state, state === "open" ? { x: [], y: [] } : { x: place.x, y: pick(shear) })
    charts.law_normal_law.fill(state, { x: place.y, y: pick(normal) })
    by(`law-${state}`).textContent = place.x.length
  }
}
