// A run that slides, from its skeleton (format: app/service/skeletons.py): every increment is computed here, as
// solver/following/skeleton.py and solver/continuation/trace.py do it.

import { lawOf } from "./law.js"
import { inflated } from "./packed.js"

const STENCIL = 6 // states for interpolation
const FEW = 120 // increments of a run while a slider is held, beside those at slips: a few pixels apart
const SCALES = { gap: 1, u_x: 1, T_z: 1, T_x: 1 } // fields are in nm and GPa
const copied = (of) => Object.fromEntries(Object.entries(of).map(([name, now]) => [name, Float32Array.from(now)]))
const OF_SLIP = ["slip_at", "slip_F", "slip_L", "slip_A"] // columns of its load and what was there just before

// The message of a skeleton, in a while: {..., skeleton}
export const skeletonLater = async ({ body, ...rest }) => ({ ...rest, skeleton: skeletonOf(await inflated(body)) })

// {head, branches, lowered: those of the approach, law} of the inflated bytes, an ArrayBuffer
function skeletonOf(buffer) {
  const length = new DataView(buffer).getUint32(0, true), rest = buffer.slice(4 + length)
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)))
  const { nodes, held, shear, lowered } = head
  const { branches, bytes } = branchesOf(rest, shear, 2 * nodes + held)
  const above = lowered && branchesOf(rest.slice(bytes), lowered, 2 * lowered.kept).branches
  for (const branch of above ?? []) branch.states = branch.states.map((left) => wholeOf(left, lowered.kept, nodes))
  return { head, branches, lowered: above ?? [], law: lawOf(head.law) }
}

// A state from those nodes that are kept: the others are their mirror image, u_x with the other sign
const wholeOf = (left, kept, nodes) => Float64Array.from({ length: 2 * nodes }, (_, i) => {
  const at = i % nodes, own = at < kept, k = own ? at : nodes - 1 - at
  return i < nodes ? (own ? left[k] : -left[k]) : left[kept + k]
})

// {branches, how many bytes they have}
function branchesOf(buffer, { branches: kinds, unit }, size) {
  const count = kinds.reduce((sum, { states }) => sum + states, 0), loads = new Float64Array(buffer, 0, count)
  const row = new Int32Array(buffer, 8 * count, size), after = 8 * count + row.byteLength
  const states = statesOf(row, stepsOf(new Uint8Array(buffer, after, 2 * (count - 1) * size)), unit)
  let from = 0
  const branches = kinds.map(({ states: n, ...kind }) => {
    const branch = { ...kind, loads: loads.subarray(from, from + n), states: states.slice(from, from + n) }
    from += n
    return { ...branch, places: Array.from(branch.loads, (load) => placeIn(branch, load)) }
  })
  return { branches, bytes: after + 2 * (count - 1) * size }
}

// Steps from their low bytes and their high ones: 2 k for k >= 0, -2 k - 1 for others
function stepsOf(bytes) {
  const n = bytes.length / 2, both = (i) => bytes[i] | (bytes[n + i] << 8)
  return Int32Array.from({ length: n }, (_, i) => (both(i) >> 1) ^ -(bytes[i] & 1))
}

// States, nm, from steps of the steps between nodes, those of later states being changes
function statesOf(row, rows, unit) {
  const size = row.length, units = new Int32Array(size)
  return Array.from({ length: 1 + rows.length / size }, (_, k) => {
    const steps = k ? rows.subarray((k - 1) * size, k * size) : row
    for (let i = 0, step = 0, sum = 0; i < size; i++) units[i] += sum += step += steps[i]
    return Float64Array.from(units, (value) => value * unit)
  })
}

// Where a load lies on a branch, 0 to 1; towards a slip the root of the distance, in which states are smooth
function placeIn({ loads, slips, periodic }, load) {
  const part = (load - loads[0]) / (loads.at(-1) - loads[0] || 1), within = Math.min(Math.max(part, 0), 1)
  return periodic ? part : slips ? 1 - Math.sqrt(1 - within) : within
}

// Weights of the values at `nodes` in that of their polynomial at x
const lagrange = (nodes, x) =>
  nodes.map((a, i) => nodes.reduce((w, b, j) => (i === j ? w : (w * (x - b)) / (a - b)), 1))

// Fill v with a weighted sum of states; most often there are six
function combine(v, w, states) {
  const [a, b, c, d, e, f] = states, [p, q, r, s, t, u] = w
  if (w.length === STENCIL) {
    for (let i = 0; i < v.length; i++)
      v[i] = p * a[i] + q * b[i] + r * c[i] + s * d[i] + t * e[i] + u * f[i]
  } else for (let i = 0; i < v.length; i++) v[i] = w.reduce((sum, weight, k) => sum + weight * states[k][i], 0)
}

// Fill v with the state of a branch at a load
function stateOf(branch, load, v) {
  const { places, states, periodic } = branch, n = places.length - periodic, size = Math.min(STENCIL, n)
  const at = placeIn(branch, load), turns = periodic ? Math.floor(at) : 0
  const after = places.findIndex((place) => place >= at - turns)
  const first = (after < 0 || after > n ? n : after) - (size >> 1)
  const begin = periodic ? first : Math.min(Math.max(first, 0), n - size)
  const index = Array.from({ length: size }, (_, k) => begin + k), turn = (i) => (periodic ? Math.floor(i / n) : 0)
  const weights = lagrange(index.map((i) => places[i - n * turn(i)] + turn(i)), at - turns)
  combine(v, weights, index.map((i) => states[i - n * turn(i)]))
  const moved = weights.reduce((sum, w, k) => sum + w * turn(index[k]), turns) // by periods
  if (moved) for (let i = 0; i < v.length; i++) v[i] += moved * (states.at(-1)[i] - states[0][i])
}

// Fill v with u_x and gap of all nodes, and U_z, nm, at a load: of the branch that holds it, moved on by whole periods
function fillUnknowns({ head: { period, nodes }, branches }, load, v) {
  const last = branches.at(-1), end = last.loads.at(-1)
  const shift = period ? Math.max(0, Math.ceil((load - end) / period)) * period : 0
  stateOf(branches.find(({ loads }) => load - shift <= loads.at(-1)) ?? last, load - shift, v)
  if (shift) for (let i = 0; i < nodes; i++) v[i] += shift
}

// Numbers of the increments of a picture, which has few: even ones, those at slips, the one at U_x and the last
function fewOf({ step, shear: { slips } }, last, every, U_x) {
  const even = Array.from({ length: Math.floor(last / every) + 1 }, (_, k) => k * every)
  const beside = slips.flatMap(([load]) => [Math.floor(load / step), Math.ceil(load / step)])
  const within = (k) => Math.min(Math.max(k, 0), last)
  return [...new Set([...even, ...[...beside, Math.round(U_x / step), last].map(within)])].toSorted((a, b) => a - b)
}

// The increments of the approach: [index, delta]
function loweredTo({ approach: [from, to, step], lowered }) {
  return Array.from({ length: lowered ? lowered.increments + 1 : 0 }, (_, k) => [k, Math.min(to, from + k * step)])
}

// The increments of a run as a chunk of frames (packed.js), with the approach where it is known: all; or, where `few`,
// those of a picture. Curves are made now, fields when they are looked at
export function chunkFrom(skeleton, few = false, U_x = 0) {
  const { head, lowered } = skeleton, { nodes, step, stages } = head, last = Math.floor(head.span[1] / step + 1e-9)
  const every = few ? Math.ceil((last + 1) / FEW) : 1, above = loweredTo(head)
  const places = [...above, ...fewOf(head, last, every, U_x).map((index) => [index, index * step])]
  const frames = places.length, filled = (name) => [name, new Float32Array(frames)]
  const columns = Object.fromEntries(head.columns.map(filled))
  const v = new Float64Array(2 * nodes + head.held), gap = v.subarray(nodes, 2 * nodes) // of one increment at a time
  const T_x = new Float64Array(nodes), T_z = new Float64Array(nodes)
  const evaluate = (k) => {
    const [, load] = places[k]
    if (k < above.length) stateOf(lowered.find(({ loads }) => load <= loads.at(-1)) ?? lowered.at(-1), load, v)
    else fillUnknowns(skeleton, load, v)
    skeleton.law(v, gap, T_x, T_z)
    return { u_x: v.subarray(0, nodes), gap, T_x, T_z } // until the next increment
  }
  places.forEach(([index, load], k) => {
    evaluate(k)
    const down = k < above.length, kind = stages.indexOf(down ? "approach" : "shear")
    const delta = down ? load : head.held ? -v.at(-1) : head.approach[1]
    const values = { stage: kind, index, U_x: down ? 0 : load, delta, ...forcesOf(head, T_x, T_z) }
    for (const name in values) columns[name][k] = values[name]
  })
  OF_SLIP.forEach((name, i) => columns[name].set(columns[["U_x", "F_bar", "L_bar", "A_bar"][i]]))
  markSlips(head.lowered?.slips ?? [], above, 0, columns)
  markSlips(head.shear.slips, places.slice(above.length), above.length, columns)
  const rows = [] // the fields of those increments that were looked at
  const fieldsAt = (row) => (rows[row] ??= copied(evaluate(row)))
  return { head: { ...head, last: true, frames, scales: SCALES, step: every * step }, columns, fieldsAt }
}

// Slips in their increments, which begin with frame `first`; of several in one the first counts
function markSlips(slips, places, first, columns) {
  for (const values of slips.toReversed()) {
    const k = places.findIndex(([, load]) => load >= values[0])
    if (k < 0) continue
    columns.slip[first + k]++
    OF_SLIP.forEach((name, i) => { columns[name][first + k] = values[i] })
  }
}

function forcesOf({ each, closed, least, scene: { nodes, E } }, T_x, T_z) {
  let F = 0, L = 0, A = 0, here = (closed ? T_z.at(-1) : 0) - least
  for (let i = 0; i < T_z.length + !closed; i++) {
    const after = (T_z[i] ?? 0) - least, repelled = Math.max(here, 0) + Math.max(after, 0)
    F -= T_x[i] ?? 0
    L += T_z[i] ?? 0
    if (repelled > 0) A += repelled / (Math.abs(here) + Math.abs(after)) // T_z is linear between nodes
    here = after
  }
  return { F_bar: (F * each) / nodes / E, L_bar: (L * each) / nodes / E, A_bar: (A * each) / nodes }
}
