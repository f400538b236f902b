// The page "What matters": a bar for each parameter, and in the hero which nodes hold the contact until the first slip.

import { frameBox } from "../../static/js/bokeh.js"
import { ask, order } from "../../static/js/channel.js"
import { by, digits, make, makeButton, minus, on } from "../../static/js/dom.js"
import { figures, fill } from "../../static/js/figures.js"
import { inks } from "../../static/js/pen.js"
import { leaveBehind, me } from "../../static/js/state.js"
import { forceUnit, inWords } from "../../static/js/words.js"

const MORE = 1.05 // times the value, that a click asks for
const OF_ZERO = 0.05 // of the depth, where that is zero
const HIGH = 26 // px, the mark of the node that holds most
const WIDE = 1.96 // standard deviations: 95 %
const COLUMNS = { U_s: 0, F_s: 1, A_s: 2 }

const DRAWS = 100 // runs
const SAID = { U_s: "Uₛ", F_s: "Fₛ", L_s: "Lₛ", A_s: "Aₛ" }

let band = null // {bands: {F, L, A: {x, y}}, linear, drawn: {U_s, F_s, L_s, A_s: [low, high]}, differ, draws, lost, force, width}
let shown = "" // of which band, in which unit, the curves' bands are
let found = null // {values: {parameter: now}, bars: {parameter: [U_s, F_s, A_s]}, first, nodes: shares of F_s}

export function connect() {
  for (const id of ["matters-of", "matters-spread"]) on(id, "input", draw)
  on("matters-spread", "input", () => band && ask({ percent: 0 }))
  on("matters-draw", "click", () => ask({ percent: band ? 0 : percent() }))
  on("matters-try", "click", () => ask({ percent: percent(), draws: DRAWS }))
}

const percent = () => Number(by("matters-spread").value)

export function told({ matters, band: given, busy }) {
  for (const id of ["matters-draw", "matters-try"]) by(id).disabled = !matters || (busy ?? null) !== null
  band = given ?? null
  by("matters-draw").setAttribute("aria-pressed", band !== null)
  by("matters-tried").textContent = band?.drawn ? tried() : ""
  if (matters === found) return
  found = matters ?? null
  draw()
}

export function closed() {
  found = band = null
  drawBand(me.run, false)
}

// What so many runs say, where that is something else than the derivatives do
function tried() {
  const unit = forceUnit([me.run]), over = { U_s: [1, "nm"], A_s: [band.width, "nm"] }
  const said = (name, ends) => {
    const [size, text] = over[name] ?? [(unit.names.F === "F" ? band.force : 1) * unit.factor, unit.text]
    return `${ends.map((value) => digits(value * size, 4)).join(" … ")} ${text}`
  }
  const both = band.differ.map((name) => `${SAID[name]} ${said(name, band.drawn[name])}, not ${said(name, band.linear[name])}`)
  const lost = band.lost ? ` ${band.lost} others slip in another way, or not at all.` : ""
  if (both.length) return `${band.draws} runs say otherwise, 95 times in 100: ${both.join("; ")}.${lost}`
  return `${band.draws} runs agree: Fₛ ${said("F_s", band.drawn.F_s)}, 95 times in 100.${lost}`
}

// Behind the curves, in their unit, while the shear is on screen
function drawBand(run, there) {
  if (!run || me.dragging) return
  const unit = forceUnit([run]), force = (unit.names.F === "F" ? band?.force : 1) * unit.factor
  const now = there && band ? `${run.number} ${force} ${JSON.stringify(band.linear)}` : ""
  if (now === shown) return
  shown = now
  for (const [view, name, size] of [["forces", "F", force], ["forces", "L", force], ["area", "A", band?.width]]) {
    const { x, y } = now ? band.bands[name] : { x: [], y: [] }
    fill(view, `band_${name}`, { U_x: x.map((at) => at ?? NaN), value: y.map((value) => (value ?? NaN) * size) })
  }
}

const signed = (value) => `${value < 0 ? "−" : "+"}${Math.abs(value) < 0.005 ? "0" : Math.abs(value).toFixed(2)} %`

function draw() {
  const column = COLUMNS[document.querySelector("#matters-of :checked").value]
  const rows = Object.entries(found?.bars ?? {}).map(([name, all]) => [name, all[column]]).filter(([, value]) => value !== null)
  rows.sort(([, a], [, b]) => Math.abs(b) - Math.abs(a))
  const most = Math.max(...rows.map(([, value]) => Math.abs(value)), 1e-9)
  by("matters-bars").replaceChildren(...rows.map(([name, value]) => {
    const bar = make("i", { className: value < 0 ? "less" : "more" })
    bar.style.setProperty("--part", Math.abs(value) / most)
    return makeButton({ title: `${minus(found.values[name])}, five per cent more`, onclick: () => raise(name) },
      make("span", {}, inWords(name) + (found.values[name] === 0 ? " (by 0.01)" : "")), bar, make("b", {}, signed(value)))
  }))
  const zero = rows.filter(([name]) => found.values[name] === 0)
  tellBand(rows.map(([, value]) => value), zero.map(([name]) => `, ${inWords(name)} to ± ${percent() / 100}`).join(""))
}

// What is left of the first slip if no parameter is known exactly: independent normal deviations, linearly
function tellBand(shares, besides) {
  const spread = percent(), of = document.querySelector("#matters-of :checked").parentElement.textContent
  const wide = WIDE * spread * Math.hypot(...shares)
  by("matters-band").textContent = shares.length && spread > 0 ? `(one standard deviation${besides}): ${of} is known to ± ${Number(wide.toPrecision(2))} %, 95 times in 100.` : ""
}

function raise(name) {
  const now = Number(me.status.values[name])
  leaveBehind()
  order("scene", { [name]: `${Number((now === 0 ? OF_ZERO : now + Math.abs(now) * (MORE - 1)).toPrecision(5))}` })
}

// Over the punch, with every frame: how much each node holds
export function frame(run, k) {
  drawBand(run, !run.normal && !run.approaching(k))
  const box = found && !run.head.flat ? frameBox(figures.punch) : null
  if (!box) return
  const { x } = run.frame(k), { first } = run.headOf(k), { nodes } = found, ink = inks(), pen = by("story").getContext("2d")
  const most = Math.max(...nodes.map(Math.abs), 1e-12), wide = Math.max(2, 0.7 * box.across * run.head.spacing)
  x.forEach((at, i) => {
    const share = nodes[first + i - found.first] ?? 0, high = (Math.abs(share) / most) * HIGH
    if (high < 0.5) return
    pen.fillStyle = share > 0 ? ink.shear : ink.slip
    pen.fillRect(box.X(at) - wide / 2, box.Y(0) + 3, wide, high)
  })
}
