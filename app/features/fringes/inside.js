// What is inside the layer, summed from the tractions of a frame and a table of how each of their modes reaches into it
// (solver/analysis/interior.py), sent once for a geometry.

import { order, take } from "../../static/js/channel.js"
import { redrawPunch } from "../../static/js/store.js"

const GEOMETRY = ["nu", "height", "width", "nodes"] // of a scene, as feature.py
const KEPT = 3 // of each
const LOST = 2000 // ms after which a table that did not come is asked for again
const FACTORS = 6 // of a mode: of sigma_xx, sigma_zz, sigma_xz, each even and odd (tasks.layer_table)
const BY_SHEAR = [false, false, true] // whether the even factor belongs to T_x, or to T_z
// Weights of these three
export const XX = [1, 0, 0]
export const ZZ = [0, 1, 0]
export const XZ = [0, 0, 1]
export const APART = [-1, 1, 0]
export const SHEARED = [0, 0, 2]

// those made last, by what they are of: tables; cosines and sines of modes over places
const tables = new Map(), waves = new Map()
const keep = (map, key, value) => {
  if (map.size >= KEPT) map.delete(map.keys().next().value)
  map.set(key, value)
  return value
}
let asked = "", since = 0

take("table", (message) => {
  const table = tableOf(message)
  keep(tables, keyOf(table.geometry, table.asked), table)
  asked = ""
  redrawPunch()
})

export function tableOf({ body, ...table }) {
  return { ...table, factors: Float32Array.from(new Int16Array(body), (value) => value * table.scale) }
}

const keyOf = (geometry, { rows, modes, depth }) => JSON.stringify([geometry, rows, modes, depth])

// The table {rows, modes, depth (nm)} of the scene on screen, once it is there
export function tableFor(scene, wanted) {
  const key = keyOf(GEOMETRY.map((name) => scene[name]), wanted), table = tables.get(key), now = performance.now()
  if (!table && (!asked || now - since > LOST)) {
    asked = key
    since = now
    order("layer", wanted)
  }
  return table
}

// Another table of the same layer, the one made last, while the one asked for is computed
export function tableMeanwhile(scene, { rows }) {
  const key = JSON.stringify(GEOMETRY.map((name) => scene[name]))
  return [...tables.values()].findLast(({ geometry, asked: of }) =>
    JSON.stringify(geometry) === key && of.rows === rows)
}

// Weighted sums over the places x (nm from the middle) and every so many rows of a table, in frame k of a run: of each
// of `weights` a Float32Array (rows, x.length), the row at the surface first; GPa
export function sumsIn(run, k, { counts, factors }, x, weights, every = 1) {
  const T = tractionsOf(run, k, counts[0]), modes = wavesOver(x, counts[0], run.headOf(k)), wide = x.length
  const sums = weights.map(() => new Float32Array(Math.ceil(counts.length / every) * wide))
  const terms =
    weights.map((weight) => weight.flatMap((w, f) =>
      (w ? [[f, w, T[BY_SHEAR[f] ? 0 : 1], T[BY_SHEAR[f] ? 1 : 0]]] : [])))
  let at = 0
  counts.forEach((count, r) => {
    if (r % every) {
      at += count * FACTORS
      return
    }
    const from = (r / every) * wide, rows = sums.map((sum) => sum.subarray(from, from + wide))
    for (let m = 0; m < count; m++, at += FACTORS) {
      const { cos, sin } = modes[m]
      for (let n = 0; n < rows.length; n++) {
        let p = 0, q = 0
        for (const [f, w, own, other] of terms[n]) {
          const even = w * factors[at + 2 * f], odd = w * factors[at + 2 * f + 1]
          p += even * own.cos[m] - odd * other.sin[m]
          q -= even * own.sin[m] + odd * other.cos[m]
        }
        const row = rows[n]
        for (let i = 0; i < wide; i++) row[i] += p * cos[i] + q * sin[i]
      }
    }
  })
  return sums
}

// [T_x, T_z] by modes: c + i s of T = Re sum (c + i s) exp(i q x), all but the first counted twice
function tractionsOf(run, k, modes) {
  const { head, of } = run.sent(k), { first, scales, scene: { nodes: n } } = head, base = turnsOf(n)
  return ["T_x", "T_z"].map((name) => {
    const cos = new Float64Array(modes), sin = new Float64Array(modes), part = of(name)
    if (head.flat) cos[0] = part[0] * scales[name] // of nodes that are alike some were sent
    else part.forEach((value, i) => {
      const each = (value * scales[name]) / n
      if (each === 0) return
      for (let m = 0, turn = 0; m < modes; m++) {
        cos[m] += (m ? 2 : 1) * each * base.cos[turn]
        sin[m] -= (m ? 2 : 1) * each * base.sin[turn]
        turn = (turn + first + i) % n
      }
    })
    return { cos, sin }
  })
}

const turns = {} // cosines and sines of n parts of a turn
function turnsOf(n) {
  const angle = (i) => (2 * Math.PI * i) / n
  return (turns[n] ??= { cos: Float64Array.from({ length: n }, (_, i) => Math.cos(angle(i))),
    sin: Float64Array.from({ length: n }, (_, i) => Math.sin(angle(i))) })
}

function wavesOver(x, modes, { middle, scene: { width } }) {
  const step = (2 * Math.PI) / width, key = [step, modes, x.length, x[0], x.at(-1), middle].join()
  const over = (m, of) => Float32Array.from(x, (v) => of(m * step * (v + middle)))
  return waves.get(key)
    ?? keep(waves, key, Array.from({ length: modes }, (_, m) => ({ cos: over(m, Math.cos), sin: over(m, Math.sin) })))
}

// Middles of so many equal parts of -half..half
export const middles = (count, half) => Array.from({ length: count }, (_, i) => ((2 * i + 1) / count - 1) * half)
