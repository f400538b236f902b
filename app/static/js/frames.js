// What the fields of single frames say: how nodes are drawn, which have slipped, where they repel.

const ALL = 0.95 // of the nodes that feel anything have slipped: it all has
const COUNTS = ["no", "one", "two", "three", "four", "five", "six"]
const NONE = 1e-6 // of the peak attraction: a flat surface at zero gap feels no more than round-off

// Weak attraction counts as free beyond the peak of the law, not where it passes through zero
export const acts = ({ adhesion, free, delta_n }, T_n, gap) => gap <= delta_n || T_n <= -free * adhesion

function state(head, T_n, gap) {
  if (!acts(head, T_n, gap)) return "free"
  if (head.flat && Math.abs(T_n) < NONE * head.adhesion) return "contact"
  return T_n > 0 ? "repulsive" : "adhering"
}

// Numbers times a factor; a loop, as `from` with a function takes ten times as long
export function scaled(numbers, factor) {
  const made = new Float32Array(numbers)
  if (factor !== 1) for (let i = 0; i < made.length; i++) made[i] *= factor
  return made
}

export class Frames {
  places = [] // frame k -> [chunk, row]

  // What was sent of frame k: its head, and the Int16Array of a field over the patch
  sent(k) {
    const [{ head, fields, fieldsAt }, row] = this.places[k], here = fieldsAt?.(row)
    return { head, of: (name) => here?.[name] ?? fields[name].subarray(row * head.nodes, (row + 1) * head.nodes) }
  }

  // The header of the chunk with frame k: the nodes of its patch
  headOf(k) { return this.places[k][0].head }

  // The fields of frame k over the patch: x (deformed, nm), gap (nm), T_n and T_t (GPa); T_t > 0 points against +x; and
  // state(i), how node i is drawn.
  // All nodes of a flat surface are alike: they are drawn less than a spacing from where they were, to fill the view
  frame(k) {
    if (this.#last.k !== k) this.#last = { k, frame: this.#frame(k) }
    return this.#last.frame
  }

  #last = {} // {k, frame}: a picture of the screen asks for one frame many times, and frames of a run never change
  #frame(k) {
    const { head, of } = this.sent(k), { first, spacing, middle, scales, flat } = head
    const real = (name, factor) => scaled(of(name), factor * scales[name])
    const shift = (u) => (flat ? u - spacing * Math.round(u / spacing) : u)
    const x = real("u_x", 1).map((u, i) => (first + i) * spacing - middle + shift(u))
    const gap = real("gap", 1), T_n = real("T_z", 1)
    return { x, gap, T_n, T_t: real("T_x", -1), state: (i) => state(head, T_n[i], gap[i]) }
  }

  // Least displacement u_x of all nodes of frame k, nm; of a flat surface that of any
  least(k) {
    const { head, of } = this.sent(k)
    return Math.min(...of("u_x")) * head.scales.u_x
  }

  // By how many lattice sites every node of frame k has moved since the frame before; the same node in either
  moved(k) {
    const [now, before] = [k, k - 1].map((at) => this.frame(at).x), { spacing, flat } = this.headOf(k)
    if (flat) return Float32Array.from(now, () => Math.round((this.least(k) - this.least(k - 1)) / spacing))
    const shift = this.headOf(k).first - this.headOf(k - 1).first
    return now.map((x, i) => (i + shift in before ? Math.round((x - before[i + shift]) / spacing) : 0))
  }

  // The slip before frame k: how many nodes feel anything and moved, whether all did, by how many sites
  slipTo(k) { return (this.#slips[k] ??= this.#slipTo(k)) }

  #slips = {} // {frame: its slip}, as frames of a run never change
  #slipTo(k) {
    const moved = this.moved(k), { state: stateOf } = this.frame(k)
    const acting = [...moved.keys()].filter((i) => stateOf(i) !== "free"), gone = acting.filter((i) => moved[i])
    const sites = gone.length ? Math.abs(moved[gone[gone.length >> 1]]) : 0
    const shiftText = `${COUNTS[sites] ?? sites} site${sites === 1 ? "" : "s"}`
    return { acting: acting.length, gone: gone.length, all: gone.length >= ALL * acting.length, sites, shiftText }
  }

  // Stretches of repulsion in frame k, [from, to] as numbers of nodes with fractions
  patches(k) {
    const { head: { first }, of } = this.sent(k), T = of("T_z"), patches = []
    const beyond = (i, j) => (j in T ? T[i] / (T[i] - T[j]) : 0)
    T.forEach((value, i) => {
      if (value <= 0) return
      if (!(T[i - 1] > 0)) patches.push([first + i - beyond(i, i - 1), 0])
      if (!(T[i + 1] > 0)) patches.at(-1)[1] = first + i + beyond(i, i + 1)
    })
    return patches
  }

  // Outermost places of repulsion in frame k; null where nothing is repelled
  edges(k) {
    const patches = this.patches(k)
    return patches.length ? [patches[0][0], patches.at(-1)[1]] : null
  }

  // Where both of them are in some frames, nm from the middle; NaN where there are none
  edgesOver(frames) {
    const { spacing, middle } = this.head, edges = frames.map((k) => this.edges(k))
    return [0, 1].map((side) => edges.map((ends) => (ends?.[side] ?? NaN) * spacing - middle))
  }
}
