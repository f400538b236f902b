// The frames of a run, as they arrive from the server (format: packing.pack) and as they are asked for by the views.

import { opened } from "./channel.js"

export const BESIDE = 1e6 // runs with higher numbers are pinned ones, as app/session/beside.py
export const FILM = 2e6 // those with still higher ones are motions through a slip, as app/session/film.py
const WEAK = 0.1 // of the peak attraction: the views reach as far as anything stronger acts
const NONE = 1e-6 // of the peak attraction: a flat surface at zero gap feels no more than round-off
// Curves in units: of which column, and what its unit is; runs that go on with another stiffness have several
export const REAL = { // N/m, nm
  F: ["F_bar", (head) => head.force], L: ["L_bar", (head) => head.force], F_slip: ["slip_F", (head) => head.force],
  A: ["A_bar", (head) => 2 * head.middle],
}

// One packed chunk (ArrayBuffer) as {run, head, columns: {name: Float32Array}, fields: {name: Int16Array (n, m)}};
// nothing is copied
export function unpack(buffer) {
  let { head, start } = opened(buffer, 4)
  const take = (kind, count) => {
    start += kind.BYTES_PER_ELEMENT * count
    return new kind(buffer, start - kind.BYTES_PER_ELEMENT * count, count)
  }
  const named = (names, kind, count) => Object.fromEntries(names.map((name) => [name, take(kind, count)]))
  const columns = named(head.columns, Float32Array, head.frames)
  const fields = named(Object.keys(head.scales), Int16Array, head.frames * head.nodes)
  return { run: new DataView(buffer).getUint32(0, true), head, columns, fields }
}

// Weak attraction counts as free beyond the peak of the law, not where it passes through zero
const acts = ({ adhesion, free, delta_n }, T_n, gap) => gap <= delta_n || T_n <= -free * adhesion

function state(head, T_n, gap) {
  if (!acts(head, T_n, gap)) return "free"
  if (head.flat && Math.abs(T_n) < NONE * head.adhesion) return "contact"
  return T_n > 0 ? "repulsive" : "adhering"
}

export class Run {
  constructor(number, head) {
    this.number = number
    this.head = head
    this.places = [] // frame k -> [block, row]
    this.curves = Object.fromEntries([...head.columns, ...Object.keys(REAL)].map((name) => [name, []]))
    this.whole = false
    this.sheared = -1 // the frame at which shear begins, once it is there
    this.T_high = 0 // GPa, strongest repulsion of the shear frames
    this.T_low = 0
    this.T_most = 0 // GPa, strongest traction of either kind, and the most negative
    this.T_least = 0
    this.T_out = 0 // GPa, the strongest tangential traction against +x, and along it
    this.T_back = 0
    this.strongestForce = 0 // N/m, of F and L
    this.lowest = 0 // nm, the smallest gap
    this.reach = 0 // nm from the middle within which anything acts while sheared
    this.worked = 0 // nJ/m, work of the top in the runs before, from which this one goes on
  }

  get length() {
    return this.places.length
  }

  // Append one chunk
  add(chunk) {
    const { frames, last } = chunk.head
    this.whole = last
    const start = this.length
    for (const name of this.head.columns) this.curves[name].push(...chunk.columns[name])
    for (let k = start; k < start + frames; k++) this.curves.work[k] += this.worked
    for (const name in REAL) {
      const [bar, unit] = REAL[name], by = unit(chunk.head)
      for (const value of chunk.columns[bar]) this.curves[name].push(value * by)
      if (name === "F" || name === "L") this.strongestForce = this.curves[name].slice(start).reduce((a, b) => Math.max(a, Math.abs(b)), this.strongestForce)
    }
    for (let k = 0; k < frames; k++) {
      this.places.push([chunk, k])
      this.dip(chunk, k)
      if (this.sheared < 0 && this.curves.stage[start + k] > 0) this.sheared = start + k
      if (this.sheared >= 0) this.measure(chunk, k)
    }
  }

  dip({ head: { nodes, scales }, fields: { gap } }, row) {
    const lowest = gap.subarray(row * nodes, (row + 1) * nodes).reduce((a, b) => Math.min(a, b), 0)
    this.lowest = Math.min(this.lowest, lowest * scales.gap)
  }

  measure({ head, fields: { T_z, T_x } }, row) {
    const { nodes, first, spacing, middle, scales } = head
    const weak = (WEAK * head.adhesion) / scales.T_z
    let high = 0, low = 0, left = nodes, right = -1, held = 0, pulled = 0
    for (let i = 0; i < nodes; i++) {
      const value = T_z[row * nodes + i]
      held = Math.min(held, T_x[row * nodes + i])
      pulled = Math.max(pulled, T_x[row * nodes + i])
      if (value > high) high = value
      if (value < low) low = value
      if (value > 0 || value < -weak) {
        if (left > i) left = i
        right = i
      }
    }
    this.T_high = Math.max(this.T_high, high * scales.T_z)
    this.T_low = Math.min(this.T_low, low * scales.T_z)
    this.T_out = Math.max(this.T_out, -held * scales.T_x)
    this.T_back = Math.min(this.T_back, -pulled * scales.T_x)
    this.T_most = Math.max(this.T_most, this.T_high, this.T_out)
    this.T_least = Math.min(this.T_least, this.T_low, this.T_back)
    if (right >= 0) {
      const from = (first + left) * spacing - middle, to = (first + right) * spacing - middle
      this.reach = Math.max(this.reach, -from, to)
    }
  }

  // What is said of the run that frame k belongs to: of one that goes on from others, not the same for all
  headOf(k) {
    return this.places[k][0].head
  }

  // Names of the parameters that are not the same for all frames after the approach
  get changing() {
    const scenes = [...new Set(this.places.slice(Math.max(0, this.sheared)).map(([{ head }]) => head.scene))]
    return Object.keys(this.head.scene).filter((name) => scenes.some((scene) => scene[name] !== scenes[0][name]))
  }

  // The fields of frame k over the patch: x (deformed, nm), gap (nm), T_n and T_t (GPa); T_t > 0 points against +x; and
  // state(i), how node i is drawn.
  // All nodes of a flat surface are alike: they are drawn less than a spacing from where they were, to fill the view
  frame(k) {
    const [{ head, fields }, row] = this.places[k]
    const { nodes, first, spacing, middle, scales, flat } = head
    const real = (name, factor) => Float32Array.from(
      fields[name].subarray(row * nodes, (row + 1) * nodes), (value) => value * factor * scales[name])
    const x = real("u_x", 1).map((u, i) => (first + i) * spacing - middle + (flat ? u - spacing * Math.round(u / spacing) : u))
    const gap = real("gap", 1), T_n = real("T_z", 1)
    return { x, gap, T_n, T_t: real("T_x", -1), state: (i) => state(head, T_n[i], gap[i]) }
  }

  // Displacement u_x of the first node, nm; of a flat surface that of all
  u(k) {
    const [{ head, fields }, row] = this.places[k]
    return fields.u_x[row * head.nodes] * head.scales.u_x
  }

  // Least displacement u_x of all nodes of frame k, nm
  least(k) {
    const [{ head: { nodes, scales }, fields: { u_x } }, row] = this.places[k]
    return u_x.subarray(row * nodes, (row + 1) * nodes).reduce((a, b) => Math.min(a, b)) * scales.u_x
  }

  // Stretches of repulsion in frame k, [from, to] as numbers of nodes with fractions
  patches(k) {
    const [{ head: { nodes, first }, fields: { T_z } }, row] = this.places[k], T = T_z.subarray(row * nodes, (row + 1) * nodes)
    const beyond = (i, j) => (j in T ? T[i] / (T[i] - T[j]) : 0), found = []
    T.forEach((value, i) => {
      if (value <= 0) return
      if (!(T[i - 1] > 0)) found.push([first + i - beyond(i, i - 1), 0])
      if (!(T[i + 1] > 0)) found.at(-1)[1] = first + i + beyond(i, i + 1)
    })
    return found
  }

  // Outermost places of repulsion in frame k; null where nothing is repelled
  edges(k) {
    const found = this.patches(k)
    return found.length ? [found[0][0], found.at(-1)[1]] : null
  }

  // Largest of F and L after the approach, N/m
  get strongest() {
    const { F, L } = this.curves
    if (this.weighed !== F.length) {
      const from = Math.max(0, this.sheared)
      this.most = [F, L].reduce((most, list) => list.reduce((a, b, k) => (k < from ? a : Math.max(a, Math.abs(b))), most), 0)
      this.weighed = F.length
    }
    return this.most
  }

  values(k) {
    return Object.fromEntries(Object.entries(this.curves).map(([name, curve]) => [name, curve[k]]))
  }

  // Whether frame k is shown among the approach, along delta, rather than what follows; all of a run that ends there
  approaching(k) {
    return !this.normal && (this.sheared < 0 || k < this.sheared || this.head.span[0] === this.head.span[1])
  }

  // The frames [from, to) that are drawn together, and what along: the approach or what follows, both where delta changes
  part(approach) {
    const whole = this.normal || this.head.span[0] === this.head.span[1]
    const [from, to] = approach ? [0, this.sheared < 0 || whole ? this.length : this.sheared] : [whole ? 0 : Math.max(0, this.sheared), this.length]
    return { from, to, abscissa: approach ? "delta" : this.head.abscissa }
  }

  // {along, value} of a curve over a part, times `factor`
  drawn(name, approach, factor = 1) {
    const { from, to, abscissa } = this.part(approach)
    return { along: Float32Array.from(this.curves[abscissa].slice(from, to)), value: Float32Array.from(this.curves[name].slice(from, to), (v) => v * factor) }
  }

  // Nothing acts anywhere after the approach
  get apart() {
    return this.whole && this.sheared >= 0 && this.reach === 0
  }

  // A curve of the frames after the approach, times `factor`
  shear(name, factor = 1) {
    return this.sheared < 0 ? [] : Float32Array.from(this.curves[name].slice(this.sheared), (value) => value * factor)
  }

  // What curves are drawn along: U_x, or delta where that is what changes; nm
  get along() {
    return this.curves[this.head.abscissa]
  }

  get normal() {
    return this.head.abscissa === "delta"
  }

  // Where frame k lies on its path, whatever the size of the increments
  place(k) {
    const stage = this.stage(k)
    return { stage, at: this.curves[this.head.along[this.curves.stage[k]]][k] }
  }

  // The frame closest to a place; null while it may still come
  atPlace({ stage, at }) {
    let best = null
    for (let k = 0; k < this.length; k++) {
      if (this.stage(k) === stage && (best === null || Math.abs(this.place(k).at - at) < Math.abs(this.place(best).at - at))) best = k
    }
    return this.whole ? best ?? this.length - 1 : best < this.length - 1 ? best : null
  }

  stage(k) {
    return this.head.stages[this.curves.stage[k]]
  }

  // The frames of another run up to k, as the beginning of this one that goes on from there
  takeOver(other, k) {
    this.places = other.places.slice(0, k + 1)
    for (const name in this.curves) this.curves[name] = other.curves[name].slice(0, k + 1)
    for (const name of ["sheared", "T_high", "T_low", "T_most", "T_least", "T_out", "T_back", "strongestForce", "lowest", "reach"]) this[name] = other[name]
    this.worked = this.curves.work.at(-1)
  }

  // Work of the top over the closed cycle of a loop, nJ/m, once it is closed
  get dissipated() {
    const { stage, work } = this.curves
    const end = (name) => stage.lastIndexOf(this.head.stages.indexOf(name))
    return this.whole && end("forth") > 0 ? work[end("forth")] - work[end("shear")] : null
  }

  // [place along the path, value] at every slip (of one stage) of a part, times `factor`
  slips(name, factor = 1, stage = null, approach = false) {
    const at = [[], []], { from, to } = this.part(approach)
    this.curves.slip.forEach((slipped, k) => {
      if (!slipped || k < from || k >= to || (stage !== null && this.curves.stage[k] !== stage)) return
      at[0].push(this.stage(k) === "press" ? this.curves.U_x[k] : this.curves.slip_at[k])
      at[1].push(this.curves[name][Math.max(k - 1, from)] * factor)
    })
    return at
  }

  // The frame nearest to a place along the path, nm, in the part of frame `now`; of several the one closest to it
  nearest(place, now) {
    const { from, to, abscissa } = this.part(this.approaching(now)), along = this.curves[abscissa], close = this.head.step / 2
    let best = from
    for (let k = from; k < to; k++) {
      const nearer = Math.abs(along[k] - place) - Math.abs(along[best] - place)
      if (nearer < -close || (nearer < close && Math.abs(k - now) < Math.abs(best - now))) best = k
    }
    return best
  }

  // Normal traction (GPa) over place and displacement, of the stage of frame `shown`; free places and increments
  // still to come are NaN
  map(shown) {
    const stage = this.stageOfMap(shown)
    const frames = this.places.map((_, k) => k).filter((k) => this.curves.stage[k] === stage)
    const blocks = [...new Set(frames.map((k) => this.places[k][0].head))]
    const from = Math.min(...blocks.map((head) => head.first))
    const to = Math.max(...blocks.map((head) => head.first + head.nodes))
    const approach = this.approaching(shown), [start, end] = this.extent(approach)
    const step = approach ? this.head.approach[2] : this.head.step, along = this.curves[this.part(approach).abscissa]
    const columns = Math.round((end - start) / step) + 1
    const rows = to - from
    const image = new Float32Array(rows * columns).fill(NaN)
    for (const k of frames) {
      const [{ head, fields }, row] = this.places[k]
      const c = Math.round((along[k] - start) / step)
      for (let i = 0; i < head.nodes; i++) {
        const j = row * head.nodes + i, value = fields.T_z[j] * head.scales.T_z
        if (acts(head, value, fields.gap[j] * head.scales.gap)) image[(head.first - from + i) * columns + c] = value
      }
    }
    return { image, rows, columns, start, step, unrested: this.unrested(frames, along, step), low: (from - 0.5) * this.head.spacing - this.head.middle }
  }

  // [middle, width] of every stretch of the path without a frame, for the surface never came to rest there
  unrested(frames, along, step) {
    const found = []
    frames.slice(1).forEach((k, i) => {
      const [a, b] = [along[frames[i]], along[k]], missed = Math.abs(b - a) - step
      if (missed > 0.6 * step && this.curves.slip[k]) found.push([(a + b) / 2, missed])
    })
    return found
  }

  // Edges of what is repelled (place along the path, x, nm) in the stages that the map does not show: the other branches of
  // a loop, each edge a line that ends with NaN
  otherEdges(shown) {
    const stage = this.stageOfMap(shown), { from, to, abscissa } = this.part(this.approaching(shown)), { spacing, middle } = this.head
    const lines = { U_x: [], x: [] }
    for (const other of new Set(this.curves.stage.slice(from, to))) {
      if (other === stage || this.head.stages[other] === "press") continue
      for (const side of [0, 1]) {
        for (let k = from; k < to; k++) {
          if (this.curves.stage[k] !== other) continue
          lines.U_x.push(this.curves[abscissa][k])
          lines.x.push((this.edges(k)?.[side] ?? NaN) * spacing - middle)
        }
        lines.U_x.push(NaN)
        lines.x.push(NaN)
      }
    }
    return lines
  }

  stageOfMap(shown) {
    if (this.approaching(shown)) return 0
    const now = this.curves.stage[Math.max(shown, this.sheared)]
    return this.head.stages[now] === "press" ? this.head.stages.indexOf("shear") : now
  }

  // What the curves extend over: what was planned, and farther where a punch that still adheres is retracted on
  extent(approach) {
    const { span, step } = this.head
    if (approach) return this.head.approach.slice(0, 2)
    const low = this.along.reduce((a, b) => Math.min(a, b), span[0])
    return [this.sheared >= 0 && low < span[0] - 0.5 * step ? low : span[0], span[1]]
  }
}
