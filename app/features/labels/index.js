// Labels over the punch: who pulls, what holds, what lets go.

import { arrow, line, size, write } from "../../static/js/pen.js"
import { BAR } from "../../static/js/punch.js"
import { fixed, withUnit } from "../../static/js/quantities.js"
import { me, sees } from "../../static/js/store.js"
import { OVER } from "../../static/js/story.js"

const REST = 46 // px, a drive that is not stretched
const TURNS = 12 // of its spring
const ARROW = 90 // px, the longest
const LENS = 0.5 // of the width, beyond which the lens does not reach as the page opens
const WIDE = 52 // times the size of the text, from which there is room for whole sentences
const PATCHES = 8 // with a bracket each; more are described in words

export const connect = () => OVER.push((view) => {
  if (!view.run.head.flat) drawEdges(view)
  drawForces(view)
})

// The spring of the drive from the top to the stage, which stays in view; to scale. Returns where it begins, px
function drawDrive(view, right, y) {
  const { pen, box, narrow, X, frame, run, k, ink } = view, stretch = run.curves.U_x[k] - run.top(k)
  const drawn = X(frame.times * stretch) - X(0)
  const long = Math.min(0.3 * box.width, Math.max(0.2 * REST, REST + drawn)), left = right - long
  const turns = Array.from({ length: TURNS + 1 }, (_, i) =>
    [left + (i * long) / TURNS, y + (i % TURNS ? 5 * (-1) ** i : 0)])
  line(pen, [[left, box.top + BAR], ...turns], ink.text, 1.5)
  line(pen, [[right, y - 9], [right, y + 9]], ink.soft, 4)
  const text = `drive ${stretch < 0 ? "compressed" : "stretched"} by ${fixed(Math.abs(stretch), 1)} nm`
  if (!narrow && Math.abs(stretch) > 0.05) write(view, text, right, y + 1.3 * size(), { align: "right" })
  return left
}

// What the hand does: F to the side at the top, against it at the interface, and L down or up; lengths over the largest
// in view
function drawForces(view) {
  const { box, narrow, run, k, ink } = view
  const full = Math.max(run.strongest, me.run.strongest)
  const { F, L, U_x, delta } = run.values(k), none = (force) => !(Math.abs(force) > 1e-6 * full), row = 1.3 * size()
  const long = Math.min(ARROW, 0.3 * box.height, 0.16 * box.width), y = box.top + BAR + 0.9 * row
  const spring = Number(run.scene.drive_t) // NaN where the drive is rigid
  const edge = box.left + box.width - 12, right = spring ? drawDrive(view, edge, y) - 10 : edge
  const to = `to δ = ${fixed(delta, 1)} nm`, down = `lowered ${to}`, stage = run.driven ? "stage " : ""
  const moves = { approach: down, reload: down, unload: `raised ${to}`,
    back: `${stage}moved back to ${fixed(U_x, 1)} nm` }[run.stage(k)] ?? `${stage}moved ${fixed(U_x, 1)} nm`
  const pull = none(F) || run.apart ? 0 : (F / full) * long
  arrow(view, [pull > 0 ? right - pull : right, y], [pull, 0], ink.shear)
  const way = (pull > 0) === (run.stage(k) !== "back") ? "pulled" : "held back"
  const wide = box.width - (edge - right) > (spring ? 1.6 : 1) * WIDE * size()
  const pulled = `${!wide ? "" : `${moves}, ${way} by `}F = ${withUnit("F", F)}`
  write(view, pull ? pulled : moves, right - Math.abs(pull) - (pull ? 8 : 0), y,
    { of: pull ? ink.shear : ink.text, align: "right", bold: true })
  if (none(L) || run.apart) return
  const deep = (Math.abs(L) / full) * long, at = box.left + (narrow ? 0.06 : LENS) * box.width
  const from = y + (spring ? 2 : 0.8) * row // under the key, the text of F and the drive
  if (L > 0) arrow(view, [at, from], [0, deep], ink.normal)
  else arrow(view, [at, from + deep], [0, -deep], ink.normal)
  const text = narrow ? `L = ${withUnit("F", L)}` : `load L = ${withUnit("F", L)}, ${L > 0 ? "presses" : "holds it up"}`
  write(view, text, at + 12, from + Math.max(0.6 * row, 0.5 * deep), { of: ink.normal, align: "left" })
}

// Under the surface: friction on the punch, a bracket for each stretch that is repelled, and how far either edge has
// peeled
function drawEdges(view) {
  const { box, narrow, X, Y, frame, run, k, ink } = view, row = 1.3 * size()
  const patches = run.patches(k), bottom = box.top + box.height
  const y = Math.min(Math.max(Y(0), Y(Math.min(...frame.gap))) + 12, bottom - 1.8 * size())
  if (!patches.length) {
    const held = frame.T_n.some((_, i) => frame.state(i) === "adhering")
    const text = !held ? "the surfaces do not reach each other" : narrow ? "attraction alone"
      : "no contact, A = 0: held by attraction alone"
    const ends = write(view, text, X(0), y + size())
    return held && drawFriction(view, ...ends, y + size())
  }
  const place = (edge) => {
    const i = Math.floor(edge - run.headOf(k).first), t = edge - run.headOf(k).first - i
    return X(frame.drawn[i] * (1 - t) + frame.drawn[Math.min(i + 1, frame.drawn.length - 1)] * t)
  }
  const drawn = patches.map((ends) => ends.map(place)), left = drawn[0][0], right = drawn.at(-1)[1]
  if (drawn.length <= PATCHES) for (const ends of drawn) bracket(view, ends, y)
  const places = patches.length > 1 ? ` in ${patches.length} places` : ""
  const A = `${narrow ? "A" : "contact A"} = ${fixed(run.curves.A[k], 0)} nm${narrow ? "" : " wide"}${places}`
  const [from, to] = write(view, A, (left + right) / 2, y + 0.8 * size(), { of: ink.area })
  drawFriction(view, Math.min(left, from), Math.max(right, to), y)
  // while the top moves up or down contact grows and shrinks anyway
  const sliding = ["shear", "back"].includes(run.stage(k))
  if (!sees("edges") || !sliding || k <= run.sheared || narrow || patches.length > 1) return
  const start = run.edges(run.sheared)
  if (!start) return
  const [a, b] = run.edges(k), peeled = [a - start[0], start[1] - b]
  const low = Math.min(y + 0.8 * size() + row, bottom - 0.7 * size()) // in sight under a deep punch, too
  const labels = peeled.map((sites) => {
    const nm = Math.abs(sites) * run.head.spacing
    return Math.abs(sites) < 0.05 ? "" : `${fixed(nm, nm < 10 ? 1 : 0)} nm ${sites > 0 ? "let go" : "gained"}`
  })
  if (labels[0]) write(view, labels[0], Math.min(left, from - 8, X(0) - 20), low, { align: "right", stays: true })
  if (labels[1]) write(view, labels[1], Math.max(right, to + 8, X(0) + 20), low, { align: "left", stays: true })
}

function bracket({ pen, ink }, [left, right], y) {
  line(pen, [[left, y - 6], [left, y], [right, y], [right, y - 6]], ink.area, 2)
}

// What the substrate does to the punch: as large as the pull, against it, beside the contact
function drawFriction(view, left, right, y) {
  const { box, narrow, run, k, ink } = view, F = run.curves.F[k], full = run.strongest
  const long = (F / full) * Math.min(ARROW, 0.3 * box.height, 0.16 * box.width)
  if (!(Math.abs(long) > 2)) return
  const from = F > 0 ? left - 10 : right + 10
  arrow(view, [from, y], [-long, 0], ink.shear)
  if (!narrow)
    write(view, "friction", from - long + (F > 0 ? -8 : 8), y,
      { of: ink.shear, align: F > 0 ? "right" : "left", bold: true, stays: true })
}
