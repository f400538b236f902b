// The frames of a run, as they arrive from the server (format: worker.pack) and as they are asked for by the views.

const by = (id) => document.getElementById(id)
const COLUMNS = ["stage", "index", "U_x", "delta", "F", "L", "A", "residual", "evaluations", "slip", "slip_at", "work"]
const WEAK = 0.1 // of the peak attraction: the views reach as far as anything stronger acts
const NONE = 1e-6 // of the peak attraction: a flat surface at zero gap feels no more than round-off
const plain = (value) => (value instanceof Map ? Object.fromEntries(value) : value)

class Run {
  constructor(number, head) {
    this.number = number
    this.head = head
    this.places = [] // frame k -> [block, row]
    this.curves = Object.fromEntries(COLUMNS.map((name) => [name, []]))
    this.whole = false
    this.sheared = -1 // the frame at which shear begins, once it is there
    this.T_high = 0 // GPa, strongest repulsion of the shear frames
    this.T_low = 0
    this.T_most = 0 // GPa, strongest traction of either kind, and the most negative
    this.T_least = 0
    this.lowest = 0 // nm, the smallest gap
    this.reach = 0 // nm from the middle within which anything acts while sheared
  }

  get length() {
    return this.places.length
  }

  // Append one chunk: {head, columns: Float32Array (columns, n), fields: 4 x Int16Array (n, m)}
  add(chunk) {
    const { frames } = chunk.head
    this.whole = chunk.head.last
    const start = this.length
    COLUMNS.forEach((name, c) => {
      for (let k = 0; k < frames; k++) this.curves[name].push(chunk.columns[c * frames + k])
    })
    for (let k = 0; k < frames; k++) {
      this.places.push([chunk, k])
      this.dip(chunk, k)
      if (this.sheared < 0 && this.curves.stage[start + k] > 0) this.sheared = start + k
      if (this.sheared >= 0) this.measure(chunk, k)
    }
  }

  dip({ head, fields: [gap] }, row) {
    let lowest = 0
    for (let i = row * head.nodes; i < (row + 1) * head.nodes; i++) if (gap[i] < lowest) lowest = gap[i]
    this.lowest = Math.min(this.lowest, lowest * head.scales[0])
  }

  measure({ head, fields: [, , normal, tangential] }, row) {
    const { nodes, first, spacing, middle, scales } = head
    const weak = (WEAK * head.adhesion) / scales[2]
    let high = 0, low = 0, left = nodes, right = -1, held = 0, pulled = 0
    for (let i = 0; i < nodes; i++) {
      const value = normal[row * nodes + i]
      held = Math.min(held, tangential[row * nodes + i])
      pulled = Math.max(pulled, tangential[row * nodes + i])
      if (value > high) high = value
      if (value < low) low = value
      if (value > 0 || value < -weak) {
        if (left > i) left = i
        right = i
      }
    }
    this.T_high = Math.max(this.T_high, high * scales[2])
    this.T_low = Math.min(this.T_low, low * scales[2])
    this.T_most = Math.max(this.T_most, this.T_high, -held * scales[3])
    this.T_least = Math.min(this.T_least, this.T_low, -pulled * scales[3])
    if (right >= 0) {
      const from = (first + left) * spacing - middle, to = (first + right) * spacing - middle
      this.reach = Math.max(this.reach, -from, to)
    }
  }

  // Weak attraction counts as free beyond the peak of the law, not where it passes through zero
  acts(T_n, gap) {
    const { adhesion, free, delta_n } = this.head
    return gap <= delta_n || T_n <= -free * adhesion
  }

  // How a node is drawn
  state(T_n, gap) {
    const { adhesion, flat } = this.head
    if (!this.acts(T_n, gap)) return "free"
    if (flat && Math.abs(T_n) < NONE * adhesion) return "contact"
    return T_n > 0 ? "repulsive" : "adhering"
  }

  // The fields of frame k over the patch: x (deformed, nm), gap (nm), T_n and T_t (GPa); T_t > 0 points against +x.
  // All nodes of a flat surface are alike: they are drawn less than a spacing from where they were, to fill the view
  frame(k) {
    const [{ head, fields }, row] = this.places[k]
    const { nodes, first, spacing, middle, scales, flat } = head
    const out = { x: new Float32Array(nodes), gap: new Float32Array(nodes), T_n: new Float32Array(nodes), T_t: new Float32Array(nodes) }
    for (let i = 0, j = row * nodes; i < nodes; i++, j++) {
      out.gap[i] = fields[0][j] * scales[0]
      const u = fields[1][j] * scales[1]
      out.x[i] = (first + i) * spacing - middle + (flat ? u - spacing * Math.round(u / spacing) : u)
      out.T_n[i] = fields[2][j] * scales[2]
      out.T_t[i] = -fields[3][j] * scales[3]
    }
    return out
  }

  values(k) {
    return Object.fromEntries(COLUMNS.map((name) => [name, this.curves[name][k]]))
  }

  // A curve of the frames after the approach, times `factor`
  shear(name, factor = 1) {
    return this.sheared < 0 ? [] : Float32Array.from(this.curves[name].slice(this.sheared), (value) => value * factor)
  }

  // What curves are drawn along: U_x, or delta where that is what changes; nm
  get along() {
    return this.curves[this.head.abscissa]
  }

  stage(k) {
    return this.head.stages[this.curves.stage[k]]
  }

  // The frames of another run up to k, as the beginning of this one that goes on from there
  takeOver(other, k) {
    this.places = other.places.slice(0, k + 1)
    for (const name of COLUMNS) this.curves[name] = other.curves[name].slice(0, k + 1)
    for (const name of ["sheared", "T_high", "T_low", "T_most", "T_least", "lowest", "reach"]) this[name] = other[name]
  }

  // Work of the top over the closed cycle of a loop, nJ/m, once it is closed
  get dissipated() {
    const { stage, work } = this.curves
    const end = (name) => stage.lastIndexOf(this.head.stages.indexOf(name))
    return this.whole && end("forth") > 0 ? work[end("forth")] - work[end("shear")] : null
  }

  // [place along the path, value] at every slip (of one stage), times `factor`
  slips(name, factor = 1, stage = null) {
    const at = [[], []]
    this.curves.slip.forEach((slipped, k) => {
      if (!slipped || k < this.sheared || (stage !== null && this.curves.stage[k] !== stage)) return
      at[0].push(this.stage(k) === "press" ? this.curves.U_x[k] : this.curves.slip_at[k])
      at[1].push(this.curves[name][Math.max(k - 1, this.sheared)] * factor)
    })
    return at
  }

  // The frame nearest to a place along the path, nm; of several the one closest to frame `now`
  nearest(place, now) {
    const { along } = this, close = this.head.step / 2
    let best = this.sheared
    for (let k = this.sheared; k < this.length; k++) {
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
    const blocks = new Set(frames.map((k) => this.places[k][0].head))
    const from = Math.min(...[...blocks].map((head) => head.first))
    const to = Math.max(...[...blocks].map((head) => head.first + head.nodes))
    const [start, end] = this.extent, { step } = this.head
    const columns = Math.round((end - start) / step) + 1
    const rows = to - from
    const image = new Float32Array(rows * columns).fill(NaN)
    for (const k of frames) {
      const [{ head, fields }, row] = this.places[k]
      const c = Math.round((this.along[k] - start) / step)
      for (let i = 0; i < head.nodes; i++) {
        const j = row * head.nodes + i, value = fields[2][j] * head.scales[2]
        if (this.acts(value, fields[0][j] * head.scales[0])) image[(head.first - from + i) * columns + c] = value
      }
    }
    return { image, rows, columns, start, low: (from - 0.5) * this.head.spacing - this.head.middle }
  }

  stageOfMap(shown) {
    const now = this.curves.stage[Math.max(shown, this.sheared)]
    return this.head.stages[now] === "press" ? this.head.stages.indexOf("shear") : now
  }

  // What the curves extend over: what was planned, and farther where a punch that still adheres is retracted on
  get extent() {
    const { span, step } = this.head
    const low = this.along.reduce((a, b) => Math.min(a, b), span[0])
    return [this.sheared >= 0 && low < span[0] - 0.5 * step ? low : span[0], span[1]]
  }
}

// One packed chunk (ArrayBuffer) as {run, head, columns, fields}; nothing is copied
function unpack(buffer) {
  const view = new DataView(buffer)
  const run = view.getUint32(0, true), length = view.getUint32(4, true)
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)))
  const columns = new Float32Array(buffer, 8 + length, COLUMNS.length * head.frames)
  const size = head.frames * head.nodes
  const start = 8 + length + columns.byteLength
  const fields = [0, 1, 2, 3].map((f) => new Int16Array(buffer, start + 2 * f * size, size))
  return { run, head, columns, fields }
}
