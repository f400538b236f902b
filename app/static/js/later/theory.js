// The theory page: fetched and shown when it is asked for, a figure to each idea drawn from its formula.

import { by } from "../dom.js"
import * as glossary from "./glossary.js"

const WIDE = 220, HIGH = 96, LEFT = 26, BASE = 80, STEPS = 80

// A curve y(x) for x from a to b, which takes the space from top (y = high) to bottom (y = low)
function curve(y, [a, b], [low, high], look = "") {
  const points = Array.from({ length: STEPS + 1 }, (_, i) => {
    const x = a + ((b - a) * i) / STEPS
    return `${(LEFT + ((WIDE - LEFT - 6) * (x - a)) / (b - a)).toFixed(1)} ${(BASE - ((BASE - 8) * (y(x) - low)) / (high - low)).toFixed(1)}`
  })
  return `<path class="${look}" d="M${points.join("L")}"/>`
}
const line = (x1, y1, x2, y2, look = "axis") => `<path class="${look}" d="M${x1} ${y1}L${x2} ${y2}"/>`
const text = (x, y, said, anchor = "middle") => `<text x="${x}" y="${y}" text-anchor="${anchor}">${said}</text>`
const axes = (along, up, zero = BASE) => line(LEFT, zero, WIDE - 4, zero) + line(LEFT, 6, LEFT, BASE + 4)
  + text(WIDE - 6, Math.min(zero + 13, HIGH - 2), along, "end") + text(LEFT - 4, 13, up, "end")
const node = (x, y) => `<circle cx="${x}" cy="${y}" r="6"/>`
const site = (x) => `<rect x="${x - 4}" y="72" width="8" height="8"/>`
const opening = (x) => -x * Math.exp(-x), sliding = (x) => x * Math.exp(-x * x)
const pressed = (x) => 1.5 * (1 - x * x) - 1.1 * Math.exp(-(((Math.abs(x) - 1.15) / 0.2) ** 2))
const saw = (x) => 0.4 + 0.6 * (x < 1 ? x : (x - 1) % 0.5 * 1.1 + 0.45)

const IDEAS = {
  gaps: () => [60, 110, 160].map(site).join("") + node(92, 30) + line(92, 30, 110, 72, "F") + line(92, 30, 92, 76, "pale") + line(92, 72, 110, 72, "pale")
    + text(84, 58, "Δₙ", "end") + text(101, 92, "Δₜ") + text(104, 27, "node", "start") + text(170, 80, "sites", "start"),
  sum: () => [60, 110, 160].map((x) => site(x) + line(102, 30, x, 72, "F")).join("") + node(102, 30) + text(114, 27, "one node, all its springs", "start"),
  normal: () => axes("Δₙ", "Tₙ", 39) + curve(opening, [-0.45, 4.5], [-0.5, 0.72]) + text(64, 75, "σₘₐₓ at δₙ", "start") + text(40, 15, "presses back", "start") + text(150, 55, "attracts"),
  tangential: () => axes("Δₜ", "Tₓ", 44) + curve(sliding, [-2.4, 2.4], [-0.5, 0.5]) + text(178, 15, "τₘₐₓ at δₜ/√2", "end"),
  strengths: () => axes("Δₙ", "Tₙ", 39) + curve(opening, [-0.45, 4.5], [-0.5, 0.72]) + curve((x) => opening(x) / Math.E, [-0.45, 4.5], [-0.5, 0.72], "F") + text(74, 75, "Δₜ = 0", "start") + text(86, 30, "Δₜ = δₜ: weaker", "start"),
  forces: () => axes("x", "T", 56) + curve(pressed, [-1.8, 1.8], [-1, 2]) + line(68, 68, 164, 68, "A") + text(116, 82, "A") + text(116, 50, "presses") + text(186, 88, "pulls"),
  mean: () => axes("Uₓ", "F") + curve(saw, [0, 2.5], [0, 1.05]) + line(104, 13, WIDE - 6, 13, "pale") + line(104, 34, WIDE - 6, 34, "F") + line(104, 53, WIDE - 6, 53, "pale") + text(100, 17, "Fₛ", "end") + text(154, 68, "Fₖ") + text(WIDE - 8, 30, "⟨F⟩", "end"),
  area: () => axes("F", "A") + curve((x) => 1 - 0.5 * x * x, [0, 1], [0, 1.1]) + text(40, 28, "A₀", "start"),
  threshold: () => axes("Aₛ", "Fₛ") + curve((x) => 0.3 + 0.7 * x, [0, 1], [0, 1.1]) + text(36, 76, "Fₛ,ₙ꜀ at no contact", "start") + text(150, 26, "slope τ꜀", "end"),
  fold: () => axes("Uₓ", "u") + `<path d="M30 76Q150 70 170 44"/><path class="pale" d="M170 44Q150 34 104 32"/>` + line(170, 44, 170, 16, "F") + `<path d="M170 16Q190 12 214 11"/>` + text(92, 66, "at rest") + text(164, 24, "slip", "end") + text(100, 28, "unstable", "end"),
}

const page = glossary.file("theory.html")

export async function openTheory() {
  by("theory").showModal()
  try {
    by("theory-text").innerHTML = (await page()) + (await glossary.text())
  } catch {
    return by("theory-text").replaceChildren("The page could not be loaded; close it and try again.")
  }
  for (const figure of by("theory-text").querySelectorAll("[data-idea]")) {
    figure.innerHTML = `<svg viewBox="0 0 ${WIDE} ${HIGH}" aria-hidden="true">${IDEAS[figure.dataset.idea]()}</svg>`
  }
}
