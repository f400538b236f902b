// A picture that follows the hand on a slider (format: app/service/following.py): the curves and the map of a whole
// run, and two of its frames, that where sliding begins and the one on screen. It is read as a Run is.

import { chunkOf } from "./packed.js"
import { REAL, Run, SPANS } from "./run.js"

const NOTHING = -128, SHADES = 127 // of a cell: where nothing acts, and the last of either sign
// times what a band has room for, from which on it gets more; so many times what it needs
const BEYOND = 1.1, ROOM = 1.3

let count = 0

export class Picture extends Run {
  // before: the run on screen
  constructor({ frames, columns, shown, map, block, body }, before) {
    super(--count, block)
    let at = 0 // how much of the body is read
    const read = (kind, size) => {
      const part = new kind(body, at, size)
      at += part.byteLength
      return part
    }
    const curves = columns.map(() => read(Float32Array, frames)), { nodes, scales } = block
    const ofFrames = read(Float32Array, block.columns.length * block.frames)
    const chunk = chunkOf(block, ofFrames, read(Int16Array, Object.keys(scales).length * block.frames * nodes))
    this.followed = this.whole = true
    this.sheared = 0
    this.shown = shown
    this.cells = { ...map, values: read(Int8Array, map.rows * map.columns) }
    // of the fields only those of the first frame and of the one shown were sent; see `has`
    this.places = Array.from({ length: frames }, (_, k) => [chunk, k === 0 ? 0 : 1])
    const still = (value) => Array.from({ length: frames }, () => value)
    const none = still(0)
    for (const name in this.curves) this.curves[name] = none
    columns.forEach((name, i) => { this.curves[name] = [...curves[i]] })
    this.curves.index = this.curves.U_x.map((U_x) => Math.round(U_x / block.step))
    for (const name of ["stage", "delta"]) this.curves[name] = still(chunk.columns[name][1])
    for (const name in REAL) {
      const [bar, unit] = REAL[name], by = unit(block)
      this.curves[name] = this.curves[bar].map((value) => value * by)
    }
    for (const name of SPANS) this[name] = before[name] // what the views extend over stays while a hand moves
    for (const k of this.curves.F.keys()) this.weigh(k) // but for arrows and bands, which would leave the view
    for (const { T_n, T_t } of [this.frame(0), this.frame(this.shown)]) {
      for (const [name, value] of [["T_high", Math.max(...T_n)], ["T_low", Math.min(...T_n)],
        ["T_out", Math.max(...T_t)], ["T_back", Math.min(...T_t)]]) {
        if (value * this[name] > BEYOND * this[name] ** 2) this[name] = ROOM * value
      }
    }
  }

  map() {
    const { rows, columns, step, first, high, low, values } = this.cells, { spacing, middle } = this.head
    const image = new Float32Array(Math.max(1, rows * columns)).fill(NaN)
    values.forEach((value, i) => { if (value !== NOTHING) image[i] = (value * (value > 0 ? high : low)) / SHADES })
    return { image, rows: rows || 1, columns: columns || 1, start: 0, step: step ?? 1, unrested: [],
      low: ((first ?? 0) - 0.5) * spacing - middle }
  }

  has(k) {
    return k === 0 || k === this.shown
  }

  approaching() {
    return false
  }
}
