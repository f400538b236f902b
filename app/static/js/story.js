// The story over the punch: who pulls, what holds, what lets go. One canvas above the figure, drawn with every frame.

import { frameBox } from "./bokeh.js"
import { by, fixed, minus } from "./dom.js"
import { figures, overlays } from "./figures.js"
import { drawLattice, drawLens } from "./lens.js"
import { arrow, cleared, inks, size, wide, write } from "./pen.js"
import { me } from "./state.js"

const LINES = 24 // of the mesh in the body, from the surface to the top
const BAR = 9 // px, height of the top of the layer
const ARROW = 90 // px, the longest
const MARKED = 1.0 // nm of the path for which a slip stays marked
const NARROW = 440 // px, for text of 13 px: in a narrower view words are few
const LENS = 0.47 // of the width, beyond which the lens does not reach as the page opens
const GAIN = 0.005 // a change of the area by less is not told

// Draw everything that belongs to frame k of a run: over the punch, or over that of a pinned run
export function drawStory(run, k, canvas = by("story"), figure = figures.punch) {
  const box = frameBox(figure), pen = cleared(canvas), main = figure === figures.punch
  if (!box || !pen) return
  const { x_range, y_range } = figure
  const X = (x) => box.left + ((x - x_range.start) / (x_range.end - x_range.start)) * box.width
  const Y = (y) => box.top + ((y_range.end - y) / (y_range.end - y_range.start)) * box.height
  const frame = run.frame(k), slip = lastSlip(run, k)
  const view = { narrow: box.width < (NARROW * size()) / 13, pen, box, X, Y, frame, run, k, slip, main, ink: inks() }
  pen.save()
  pen.beginPath()
  pen.rect(box.left, box.top, box.width, box.height)
  pen.clip()
  if (run.head.flat) drawLattice(view)
  else {
    drawMesh(view)
    if (slip) drawMoved(view)
    drawEdges(view)
  }
  drawTop(view)
  pen.restore()
  drawForces(view)
  if (main && !run.head.flat) drawLens(view)
  if (main) tellSlip(view)
}

// Lines of the material, upright before loading: from a surface node to where it hangs on the top
function drawMesh({ pen, box, X, Y, frame, run, k, ink }) {
  const { nodes, first, spacing, middle } = run.headOf(k), every = Math.max(1, Math.round(nodes / LINES))
  const U_x = run.curves.U_x[k]
  pen.strokeStyle = ink.body
  pen.globalAlpha = 0.55
  pen.lineWidth = 1
  pen.beginPath()
  for (let i = Math.floor(every / 2); i < nodes; i += every) {
    pen.moveTo(X(frame.x[i]), Y(frame.gap[i]))
    pen.lineTo(X((first + i) * spacing - middle + U_x), box.top + BAR)
  }
  pen.stroke()
  pen.globalAlpha = 1
}

// The rigid top: a bar whose marks move with it, and what it does
function drawTop({ pen, box, X, run, k, slip, main, ink }) {
  const U_x = run.curves.U_x[k], delta = run.curves.delta[k], { x_range } = figures.punch
  pen.fillStyle = ink.soft
  pen.fillRect(box.left, box.top, box.width, BAR)
  pen.strokeStyle = ink.page
  pen.lineWidth = 1.5
  pen.beginPath()
  const pitch = run.head.flat ? run.head.spacing / 4 : 20, shift = U_x % pitch
  for (let x = Math.ceil((x_range.start - shift) / pitch) * pitch; x + shift < x_range.end; x += pitch) {
    pen.moveTo(X(x + shift) - 3, box.top + BAR)
    pen.lineTo(X(x + shift) + 3, box.top)
  }
  pen.stroke()
  const told = {
    approach: `pushed down: δ = ${fixed(delta, 1)} nm ↓`, reload: `pushed down: δ = ${fixed(delta, 1)} nm ↓`,
    unload: `lifted: δ = ${fixed(delta, 1)} nm ↑`, back: `← pulled back: Uₓ = ${fixed(U_x, 1)} nm`,
  }[run.stage(k)] ?? `pulled: Uₓ = ${fixed(U_x, 1)} nm →`
  const y = box.top + BAR + 12
  if (main || !slip) write({ pen, ink, box }, told, box.left + box.width - 8, y, { align: "right", bold: true })
  else write({ pen, ink, box }, slipSaid(run, slip.at), box.left + 8, y, { of: ink.slip, align: "left", bold: true })
}

// What the hand must do, at the top: F to the side, L down or up, in lengths over the largest of the runs in view
function drawForces(view) {
  const { box, narrow, run, k, ink } = view
  const full = Math.max(...[run, me.run, ...overlays.punches(me.run, 0).map(([, of]) => of)].map((of) => of.strongest))
  const long = Math.min(ARROW, 0.3 * box.height)
  if (!(full > 0) || run.apart) return
  const F = run.curves.F[k], L = run.curves.L[k]
  const top = box.top + BAR, line = 1.25 * size()
  const x = box.left + 0.82 * box.width, y = top + (narrow ? 2.1 : 2.6) * line
  arrow(view, [x - (F / full) * long * 0.5, y], [(F / full) * long, 0], ink.shear)
  const [left] = write(view, `${narrow ? "F" : "friction F"} = ${Math.abs(F) < 1e-6 * full ? "0" : said(F)}`, x, y + line, { of: ink.shear })
  if (Math.abs(L) < 1e-6 * full) return
  const text = narrow ? `L = ${said(L)}` : `load L = ${said(L)}, ${L > 0 ? "pushes" : "pulls"}`
  const below = narrow ? write(view, text, x, y + 2 * line, { of: ink.normal })[0] : left // in a column with F, its arrow beside that
  const at = narrow ? Math.min(left, below, x - 0.5 * long) - 12 : box.left + 0.55 * box.width
  const from = narrow ? y : top + 3, deep = (Math.abs(L) / full) * long
  if (L > 0) arrow(view, [at, from], [0, deep], ink.normal)
  else arrow(view, [at, from + deep], [0, -deep], ink.normal)
  if (narrow) return
  // beside the lens where it is at first and what is said of F; where there is no room for that, below
  const half = wide(view, text) / 2, low = box.left + LENS * box.width + half, high = left - 8 - half
  const [x_L, y_L] = low < high ? [Math.min(Math.max(at, low), high), y] : [Math.max(at, low), y + 2.1 * line]
  write(view, text, x_L, Math.max(from + deep + line, y_L), { of: ink.normal })
}

// A force per depth in the unit that needs the fewest digits
export function said(force) {
  const small = Math.abs(force) < 0.1
  return `${minus(Number((small ? 1000 * force : force).toPrecision(3)))} ${small ? "mN/m" : "N/m"}`
}

// Under the surface: the width that is repelled, how far either edge has peeled, and what only attracts
function drawEdges(view) {
  const { pen, box, narrow, X, Y, frame, run, k, ink } = view
  const edges = run.edges(k), bottom = box.top + box.height
  let y = Math.min(Math.max(Y(0), Y(Math.min(...frame.gap))) + 12, bottom - 1.6 * size())
  const back = run.stage(k) === "back"
  if (!edges) {
    const held = frame.T_n.some((_, i) => frame.state(i) === "adhering")
    write(view, !held ? "the surfaces do not reach each other" : narrow ? "A = 0: attraction alone" : "nothing is repelled: A = 0, held by attraction alone", X(0), y + size())
    return
  }
  const place = (edge) => {
    const { first } = run.headOf(k), i = Math.floor(edge - first), t = edge - first - i
    return X(frame.x[i] * (1 - t) + frame.x[Math.min(i + 1, frame.x.length - 1)] * t)
  }
  const [left, right] = edges.map(place), A = run.curves.A[k]
  const repelled = narrow ? `A ${fixed(A, 0)} nm` : `A = ${fixed(A, 0)} nm is repelled`
  const start = run.sheared >= 0 && k >= run.sheared ? run.edges(run.sheared) : null
  const peeled = start ? [edges[0] - start[0], start[1] - edges[1]] : [0, 0]
  const names = back ? ["leading", "trailing"] : ["trailing", "leading"]
  const told = peeled.map((sites, i) => `${names[i]}${narrow ? "" : " edge"}${Math.abs(sites) < 0.05 ? "" : ` ${sites > 0 ? "−" : "+"}${Math.abs(sites).toFixed(1)}${narrow ? "" : " sites"}`}`)
  // between what is said of the edges, which stays in sight; or on a line of its own, where there is room for two
  const from = Math.max(left, box.left + wide(view, told[0]) + 12), to = Math.min(right, box.left + box.width - wide(view, told[1]) - 12)
  const half = wide(view, repelled) / 2 + 6, fits = 2 * half < to - from, deep = bottom - Y(0) > 2.6 * size()
  if (!fits && deep) y = Math.min(y, bottom - 2.65 * size())
  view.told = y - 6
  pen.strokeStyle = ink.area
  pen.lineWidth = 2
  pen.beginPath()
  pen.moveTo(left, y - 6)
  pen.lineTo(left, y)
  pen.lineTo(right, y)
  pen.lineTo(right, y - 6)
  pen.stroke()
  const middle = fits ? Math.min(Math.max((left + right) / 2, from + half), to - half) : (left + right) / 2
  if (fits || deep) write(view, repelled, middle, y + (fits ? 0.8 : 2.1) * size(), { of: ink.area })
  write(view, told[0], left - 8, y + 0.8 * size(), { align: "right" })
  write(view, told[1], right + 8, y + 0.8 * size(), { align: "left" })
  if (!narrow && y > Y(0)) drawAttracted(view, edges)
}

// The zones that pull, on either side, where there is room for the words
function drawAttracted(view, [left, right]) {
  const { X, Y, frame, run, k, ink } = view, { first } = run.headOf(k)
  const zones = [[0, left - first], [right - first, frame.x.length]]
  for (const [from, to] of zones) {
    let total = 0, weight = 0
    for (let i = Math.max(0, Math.ceil(from)); i < to && i < frame.x.length; i++) {
      if (frame.state(i) !== "adhering") continue
      total += -frame.T_n[i] * frame.x[i]
      weight -= frame.T_n[i]
    }
    if (!(weight > 0)) continue
    const x = total / weight, out = x < 0 ? -1 : 1
    write(view, "attracts: not in A", X(x) + out * size(), Y(0) - size(), { of: ink.adhering, align: out < 0 ? "right" : "left" })
  }
}

// The slip that led to frame k or to one shortly before: {at: its frame, age: 0 .. 1}, or null
function lastSlip(run, k) {
  if (run.followed) return null // of its motion two frames are known
  const { slip } = run.curves, reach = Math.max(1, Math.round(MARKED / run.head.step))
  for (let at = k; at > 0 && at > k - reach; at--) if (slip[at]) return { at, age: (k - at) / reach }
  return null
}

// By how many sites every node of frame `at` has moved since the frame before; the same node in either
export function movedSites(run, at) {
  const [now, before] = [at, at - 1].map((k) => ({ head: run.headOf(k), x: run.frame(k).x }))
  const shift = now.head.first - before.head.first, { spacing, flat } = now.head
  if (flat) return Float32Array.from(now.x, () => Math.round((run.u(at) - run.u(at - 1)) / spacing))
  return now.x.map((x, i) => (i + shift in before.x ? Math.round((x - before.x[i + shift]) / spacing) : 0))
}

// The nodes that slipped flash, and fade as the top goes on
function drawMoved({ pen, X, Y, frame, run, k, slip, ink }) {
  const moved = movedSites(run, slip.at), shift = run.headOf(k).first - run.headOf(slip.at).first
  pen.strokeStyle = ink.slip
  pen.lineWidth = 14
  pen.lineCap = "round"
  pen.globalAlpha = 0.6 * (1 - slip.age)
  pen.beginPath()
  let drawing = false
  frame.x.forEach((x, i) => {
    const point = [X(x), Y(frame.gap[i])]
    if (moved[i + shift] && drawing) pen.lineTo(...point)
    else if (moved[i + shift]) pen.moveTo(...point)
    drawing = Boolean(moved[i + shift])
  })
  pen.stroke()
  pen.globalAlpha = 1
}

const COUNTS = ["no", "one", "two", "three", "four", "five", "six"]
export function slipSaid(run, at, brief = false) {
  const moved = movedSites(run, at), frame = run.frame(at)
  const acting = [...moved.keys()].filter((i) => frame.state(i) !== "free")
  const gone = acting.filter((i) => moved[i])
  const before = run.curves.A_bar[at - 1], now = run.curves.A_bar[at], change = now / before - 1
  const area = before === 0 ? (now > 0 ? ", contact again" : "") : now === 0 ? ", A falls to 0"
    : Math.abs(change) < GAIN ? "" : `, A ${change > 0 ? "+" : "−"}${(100 * Math.abs(change)).toPrecision(2)} %`
  if (!gone.length) return run.stage(at) === "unload" ? "pull-off" : `jump${area}`
  const sites = Math.abs(moved[gone[gone.length >> 1]]), nm = fixed(sites * run.head.spacing, 1)
  const part = gone.length < 0.95 * acting.length ? `${gone.length} of ${acting.length} nodes` : ""
  const far = part && brief ? "" : `${part && " by "}${COUNTS[sites] ?? sites} site${sites === 1 ? "" : "s"}${brief ? "" : ` (${nm} nm)`}`
  return `slip: ${part}${far}${run.head.flat ? "" : area}`
}

// told: how high what is said under the surface begins
function tellSlip({ run, slip, narrow, told = Infinity, Y }) {
  const low = Math.min(Y(0) - (narrow ? 0.5 : 2.2) * size(), told - 2)
  by("event").style.top = `${Math.max(low, 5 * size())}px` // never over the caption
  by("slip").hidden = by("slow").hidden = !slip
  if (slip) by("slip").textContent = slipSaid(run, slip.at, narrow)
}

// The frame of the last slip up to frame k, or null
export function slipAt(run, k) {
  const at = run.curves.slip.findLastIndex((slipped, i) => slipped && i <= k && i > 0)
  return at < 0 ? null : at
}

// The frame of the next slip that way, or k itself
export function nextSlip(run, k, way) {
  const { slip } = run.curves
  for (let at = k + way; at >= 0 && at < slip.length; at += way) if (slip[at] && at >= run.sheared) return at
  return k
}
