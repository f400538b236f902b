// The theory page: fetched and shown when it is asked for, a figure to each idea drawn from its formula.

import { by } from "../dom.js"
import { file, glossary } from "../terms.js"

const WIDE = 220, HIGH = 96, LEFT = 26, BASE = 80, STEPS = 80

const place = (x, [a, b]) => LEFT + ((WIDE - LEFT - 6) * (x - a)) / (b - a)
const height = (y, [low, high]) => BASE - ((BASE - 8) * (y - low)) / (high - low)
// Points [x, y] in a space that takes x from a to b, and y from low, at the bottom, to high
const trace = (points, along, up, look = "") => {
  const places = points.map(([x, y]) => `${place(x, along).toFixed(1)} ${height(y, up).toFixed(1)}`)
  return `<path class="${look}" d="M${places.join("L")}"/>`
}
const curve = (y, [a, b], up, look) => {
  const places = Array.from({ length: STEPS + 1 }, (_, i) => a + ((b - a) * i) / STEPS)
  return trace(places.map((x) => [x, y(x)]), [a, b], up, look)
}
const line = (x1, y1, x2, y2, look = "axis") => `<path class="${look}" d="M${x1} ${y1}L${x2} ${y2}"/>`
// _ begins a subscript, as not every font has all of them
const text = (x, y, label, anchor = "middle") => {
  const parts = label.split(/_([\w,]+)/).map((part, i) => (
    i % 2 ? `<tspan dy="3" font-size="9">${part}</tspan>` : i ? `<tspan dy="-3">${part}</tspan>` : part))
  return `<text x="${x}" y="${y}" text-anchor="${anchor}">${parts.join("")}</text>`
}
const axes = (along, up, zero = BASE, at = LEFT, side = "end") => line(LEFT, zero, WIDE - 4, zero)
  + line(at, 6, at, BASE + 4) + text(WIDE - 4, zero < BASE ? zero - 8 : zero + 13, along, "end")
    + text(side === "end" ? at - 4 : at + 5, 13, up, side)
const node = (x, y) => `<circle cx="${x}" cy="${y}" r="6"/>`
const site = (x) => `<rect x="${x - 4}" y="72" width="8" height="8"/>`
const opening = (x) => -x * Math.exp(-x), sliding = (x) => x * Math.exp(-x * x)
const pressed = (x) => 1.5 * (1 - x * x) * Math.exp((-x * x) / 1.6)
// What figures take in, [along, up]
const OPEN = [[-0.45, 4.5], [-0.5, 0.72]], ACROSS = [[-2.6, 2.6], [-0.6, 1.6]], SLID = [[0, 3], [0, 1.1]]
const SAW = [[0, 0], [1, 1], [1, 0.45], [1.55, 1], [1.55, 0.45], [2.1, 1], [2.1, 0.45], [2.6, 0.95]]
const normal = () => axes("Δ_n", "T_n", height(0, OPEN[1]), place(0, OPEN[0]), "start") + curve(opening, ...OPEN)
const level = (force, label, look) => trace([[1, force], [2.6, force]], ...SLID, look)
  + text(194, height(force, SLID[1]) + 4, label, "start")

const IDEAS = {
  gaps: () =>
    [60, 110, 160].map(site).join("") + node(92, 30) + line(92, 30, 110, 72, "F") + line(92, 30, 92, 76, "pale")
    + line(92, 72, 110, 72, "pale")
    + text(84, 58, "Δ_n", "end") + text(101, 91, "Δ_t") + text(104, 27, "node", "start")
      + text(170, 80, "sites", "start"),
  sum: () =>
  [60, 110, 160].map((x) => site(x) + line(102, 30, x, 72, "F")).join("") + node(102, 30)
  + text(114, 20, "one node,", "start") + text(122, 35, "all its springs", "start"),
  normal: () => normal() + text(82, 88, "σ_max") + text(74, 15, "presses back", "start") + text(172, 78, "attracts"),
  tangential: () =>
  axes("Δ_t", "T_x", 44, 120) + curve(sliding, [-2.4, 2.4], [-0.5, 0.5]) + text(164, 17, "τ_max", "start"),
  strengths: () =>
  normal() + curve((x) => opening(x) / Math.E, ...OPEN, "F") + text(82, 88, "Δ_t = 0")
  + text(70, 42, "Δ_t = δ_t : weaker", "start"),
  forces: () =>
  axes("x", "T", height(0, ACROSS[1])) + curve(pressed, ...ACROSS)
  + line(place(-1, ACROSS[0]), 68, place(1, ACROSS[0]), 68, "A") + text(120, 84, "A") + text(120, 50, "presses")
  + text(180, 91, "attracts"),
  mean: () =>
  axes("U_x", "F") + trace(SAW, ...SLID) + level(1, "F_s", "pale") + level(0.725, "⟨F⟩", "F")
  + level(0.45, "F_k", "pale"),
  area: () => axes("F", "A") + curve((x) => 1 - 0.5 * x * x, [0, 1], [0, 1.1]) + text(34, 32, "A_0", "start"),
  threshold: () =>
  axes("A_s", "F_s") + curve((x) => 0.3 + 0.7 * x, [0, 1], [0, 1.1]) + text(36, 74, "F_s,nc without contact", "start")
  + text(140, 20, "slope τ_c", "end"),
  fold: () =>
  axes("U_x", "u") + `<path d="M30 76Q150 70 170 44"/><path class="pale" d="M170 44Q150 34 104 32"/>`
  + line(170, 44, 170, 16, "F") + `<path d="M170 16Q190 12 214 11"/>` + text(84, 62, "at rest")
  + text(164, 24, "slip", "end") + text(100, 28, "unstable", "end"),
}

const theory = file("theory.html")

export async function openTheory() {
  by("theory").showModal()
  try {
    by("theory-text").innerHTML = (await theory()) + (await glossary())
  } catch {
    return by("theory-text").replaceChildren("The page could not be loaded; close it and try again.")
  }
  for (const figure of by("theory-text").querySelectorAll("[data-idea]")) {
    figure.innerHTML = `<svg viewBox="0 0 ${WIDE} ${HIGH}" aria-hidden="true">${IDEAS[figure.dataset.idea]()}</svg>`
  }
}
