// A run: its frames as they arrive (packed.js), and its curves and map as views ask for them.

import { Frames } from "./frames.js"

export const WEAK = 0.1 // of the peak attraction: the views reach as far as anything stronger acts
// Curves in units: of which column, and what its unit is
const REAL = { // N/m, nm
  F: ["F_bar", (head) => head.force], L: ["L_bar", (head) => head.force], F_slip: ["slip_F", (head) => head.force],
  L_slip: ["slip_L", (head) => head.force], A: ["A_bar", (head) => 2 * head.middle],
}
// What stretches the drive along a coordinate: a force, and which parameter its stiffness is (MPa/nm)
const DRIVES = { U_x: ["F", "drive_t"], delta: ["L", "drive_n"] }

// Times what an axis of arrows or tractions has room for, from which on it gets more; so many times what it needs
const BEYOND = 1.1, ROOM = 1.3
const SPAN = { // of the frames of a run, from the first of shear on by default
  T_high: 0, T_low: 0, // GPa, strongest repulsion, and attraction
  T_out: 0, T_back: 0, // GPa, the strongest tangential traction against +x, and along it
  lowest: 0, // nm, the smallest gap of all frames
  reach: 0, // nm from the middle within which anything acts
  strongest: 0, // N/m, of F and L: of the frames of shear once there are any
}
export const SPANS = Object.keys(SPAN)
const least = (list) => list.reduce((a, b) => Math.min(a, b), 0)
const largest = (list) => list.reduce((a, b) => Math.max(a, b), 0)

export class Run extends Frames {
  constructor(number, head) {
    super()
    this.number = number
    this.head = head
    this.curves = Object.fromEntries([...head.columns, ...Object.keys(REAL)].map((name) => [name, []]))
    this.whole = false
    this.transient = false // whether its last frames are not at rest
    this.sheared = -1 // the frame at which shear begins, once it is there
    Object.assign(this, SPAN)
  }

  get length() { return this.places.length }

  get scene() { return this.head.scene }

  // Numbers of the frames that a test of them holds for
  frames(test) { return [...this.places.keys()].filter(test) }

  // Append one chunk; measured: the rows that the spans are to hold, all by default
  add(chunk, measured = chunk.columns.U_x.keys()) {
    const { frames, last } = chunk.head
    this.whole = last
    for (const name of this.head.columns) this.curves[name].push(...chunk.columns[name])
    for (const name in REAL) {
      const [bar, unit] = REAL[name], by = unit(chunk.head)
      for (const value of chunk.columns[bar]) this.curves[name].push(value * by)
    }
    const { length } = this
    for (let row = 0; row < frames; row++) this.places.push([chunk, row])
    for (const row of measured) this.measure(length + row)
  }

  // The axes of the run before stay while a slider moves, but for arrows and bands, which would leave the view
  keepSpans(before) {
    const { strongest, T_high, T_low, T_out, T_back } = this
    for (const name of SPANS) this[name] = before[name]
    for (const k of this.curves.F.keys()) this.weigh(k)
    this.strongest = Math.max(this.strongest, strongest)
    for (const [name, value] of Object.entries({ T_high, T_low, T_out, T_back }))
      if (value * this[name] > BEYOND * this[name] ** 2) this[name] = ROOM * value
  }

  // Take frame k into what is known of all of them
  measure(k) {
    const { stage } = this.curves, { head, of } = this.sent(k), { first, spacing, middle, scales } = head
    this.lowest = Math.min(this.lowest, least(of("gap")) * scales.gap)
    if (this.sheared < 0 && stage[k] > 0) Object.assign(this, { sheared: k, strongest: 0 })
    this.weigh(k)
    if (this.sheared < 0) return
    const T_z = of("T_z"), T_x = of("T_x"), weak = (WEAK * head.adhesion) / scales.T_z
    // nodes of a flat are alike; at gap 0 they have no traction
    const touch = head.flat && of("gap")[0] * scales.gap <= head.delta_n
    const tells = (value) => touch || value > 0 || value < -weak, left = T_z.findIndex(tells)
    this.T_high = Math.max(this.T_high, largest(T_z) * scales.T_z)
    this.T_low = Math.min(this.T_low, least(T_z) * scales.T_z)
    this.T_out = Math.max(this.T_out, -least(T_x) * scales.T_x)
    this.T_back = Math.min(this.T_back, -largest(T_x) * scales.T_x)
    if (left < 0) return
    const ends = [left, T_z.findLastIndex(tells)].map((i) => Math.abs((first + i) * spacing - middle))
    this.reach = Math.max(this.reach, ...ends)
  }

  weigh(k) { this.strongest = Math.max(this.strongest, Math.abs(this.curves.F[k]), Math.abs(this.curves.L[k])) }

  values(k) { return Object.fromEntries(Object.entries(this.curves).map(([name, curve]) => [name, curve[k]])) }

  // Whether the drive has a stiffness; that of a rigid one is the word inf
  get driven() { return ["drive_t", "drive_n"].some((name) => Number(this.head.scene[name])) }

  // U_x of the top of the layer at frame k, or another coordinate of it, nm: that of the stage less the stretch of the
  // drive
  top(k, along = "U_x") {
    const { scene, middle } = this.head, [force, drive] = DRIVES[along]
    const stretch = (1e3 * this.curves[force][k]) / (2 * middle * Number(scene[drive])) // NaN where it is rigid
    return this.curves[along][k] - (stretch || 0)
  }

  // Whether the run ends with the approach
  get pressed() { return this.head.span[0] === this.head.span[1] }

  // Whether frame k is shown among the approach, along delta, rather than what follows; all of a run that ends there
  approaching(k) { return !this.normal && (this.sheared < 0 || k < this.sheared || this.pressed) }

  // The frames [from, to) that are drawn together, and along what: the approach or what follows; both if delta changes
  part(approach) {
    const { length } = this, divided = !this.normal && !this.pressed && this.sheared >= 0
    const turn = divided ? this.sheared : length // where the approach ends
    if (approach) return { from: 0, to: turn, abscissa: "delta" }
    return { from: divided ? turn : 0, to: length, abscissa: this.head.abscissa }
  }

  // {along, value} of a curve over a part
  drawn(name, approach) {
    const { from, to, abscissa } = this.part(approach), cut = (of) => Float32Array.from(this.curves[of].slice(from, to))
    return { along: cut(abscissa), value: cut(name) }
  }

  // Nothing acts anywhere after the approach
  get apart() { return this.whole && this.sheared >= 0 && this.reach === 0 }

  // A curve of the frames after the approach
  shear(name) { return this.sheared < 0 ? [] : Float32Array.from(this.curves[name].slice(this.sheared)) }

  // What curves are drawn over after the approach: U_x, or delta where that is what changes; nm
  get along() { return this.curves[this.head.abscissa] }

  // The frame at which a run is played from
  get beginning() { return this.normal ? 0 : Math.max(0, this.sheared) }

  get normal() { return this.head.abscissa === "delta" }

  // Where frame k lies on its path, whatever the size of the increments
  place(k) {
    const stage = this.leg(k)
    return { stage, at: this.curves[this.head.along[this.curves.stage[k]]][k] }
  }

  // The frame closest to a place; null while it may still come
  atPlace({ stage, at }) {
    const far = (k) => Math.abs(this.place(k).at - at), frames = this.frames((k) => this.leg(k) === stage)
    const best = frames.reduce((a, b) => (a === null || far(b) < far(a) ? b : a), null)
    if (this.whole) return best ?? this.length - 1
    return best < this.length - 1 ? best : null // a closer one may come after the last
  }

  // The stage of frame k, without the number that it has among points
  stage(k) { return this.leg(k).split(" ").at(-1) }

  leg(k) { return this.head.stages[this.curves.stage[k]] }

  // Work of the stage over the closed cycle of a loop, nJ/m, once it is closed
  get dissipated() {
    const { stage, work } = this.curves
    const end = (name) => stage.lastIndexOf(this.head.stages.indexOf(name))
    return this.whole && end("forth") > 0 ? work[end("forth")] - work[end("shear")] : null
  }

  // The frame of the last slip up to frame k, within so many nm of the path; null where there is none
  slipBefore(k, within = Infinity) {
    const at = this.curves.slip.findLastIndex((slipped, i) => slipped && i <= k)
    return at > 0 && k - at < Math.max(1, Math.round(within / this.head.step)) ? at : null
  }

  // The frame of the next slip of the shear that way, or k itself
  nextSlip(k, way) {
    const { slip } = this.curves
    for (let at = k + way; at >= 0 && at < slip.length; at += way) if (slip[at] && at >= this.sheared) return at
    return k
  }

  // [place along the path, value] at every slip (of one stage) of a part
  slips(name, stage = null, approach = false) {
    const { slip, slip_at, stage: stages } = this.curves, { from, to } = this.part(approach)
    const frames = this.frames((k) => slip[k] && k >= from && k < to && (stage === null || stages[k] === stage))
    return [frames.map((k) => slip_at[k]), frames.map((k) => this.curves[name][Math.max(k - 1, from)])]
  }

  // The frame nearest to a place along the path, nm, in the part of frame `now`; of several the one closest to it
  nearest(place, now) {
    const { from, to, abscissa } = this.part(this.approaching(now))
    const along = this.curves[abscissa], close = this.head.step / 2
    let best = from
    for (let k = from; k < to; k++) {
      const nearer = Math.abs(along[k] - place) - Math.abs(along[best] - place)
      if (nearer < -close || (nearer < close && Math.abs(k - now) < Math.abs(best - now))) best = k
    }
    return best
  }

  // What the curves extend over: what was planned, and farther where a punch that still adheres is retracted on
  extent(approach) {
    const { span, step } = this.head
    if (approach) return this.head.approach.slice(0, 2)
    if (this.head.abscissa === "path") return span
    const low = this.along.reduce((a, b) => Math.min(a, b), span[0])
    return [this.sheared >= 0 && low < span[0] - 0.5 * step ? low : span[0], span[1]]
  }
}
