// Packed frames (format: app/service/packing.py).

// The chunk in the body of a message, in a while, with the rest of the message: {..., head, columns: {name:
// Float32Array}, fields: {name: Int16Array (frames, nodes)}}
export async function unpackLater({ body, ...message }) {
  const length = new DataView(body).getUint32(0, true), rest = new Uint8Array(body, 4 + length)
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(body, 4, length)))
  const changes = await inflated(rest), { kept } = head, count = head.columns.length * head.frames
  const curves = curvesOf(new Int32Array(changes, 0, count), head.frames)
  const few = fieldsOf(new Int16Array(changes, curves.byteLength), kept.frames.length, kept.nodes.length)
  const fields = filledIn(few, kept, head)
  return { ...message, head, columns: named(head.columns, curves, head.frames),
    fields: named(Object.keys(head.scales), fields, head.frames * head.nodes) }
}

// What was deflated, an ArrayBuffer, in a while
export const inflated = (bytes) =>
  new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer()

const named = (names, numbers, size) =>
  Object.fromEntries(names.map((name, k) => [name, numbers.subarray(k * size, (k + 1) * size)]))

// Columns from their changes over frames (packing.compressed)
function curvesOf(changes, frames) {
  const curves = Int32Array.from(changes)
  for (let i = 0; i < curves.length; i++) if (i % frames) curves[i] += curves[i - 1]
  return new Float32Array(curves.buffer)
}

// Fields, frame by frame, from their changes over frames and nodes
function fieldsOf(changes, frames, nodes) {
  const fields = new Int16Array(changes.length)
  for (let at = 0, row = 0; at < fields.length; row++) {
    const before = row % frames ? nodes : 0
    for (let node = 0, step = 0; node < nodes; node++, at++) {
      step += changes[at] // to this node from the one before
      fields[at] = step + (before ? fields[at - before] : 0)
    }
  }
  return fields
}

// All frames and nodes of fields of which few are kept
function filledIn(few, kept, { frames, nodes }) {
  const over = between(kept.frames, frames), along = between(kept.nodes, nodes)
  const wide = kept.nodes.length, size = wide * kept.frames.length, count = few.length / size
  const fields = new Int16Array(count * frames * nodes)
  for (let field = 0, at = 0; field < count; field++) {
    for (const [row, below, part] of over) {
      const first = field * size + row * wide, second = field * size + below * wide
      for (const [i, j, share] of along) {
        const now = few[first + i] + share * (few[first + j] - few[first + i])
        const then = few[second + i] + share * (few[second + j] - few[second + i])
        fields[at++] = Math.round(kept.steps[field] * (now + part * (then - now)))
      }
    }
  }
  return fields
}

// Of each place of so many: [number of the kept one before it, of the one after it, how far it is between them]
function between(kept, count) {
  let k = 0
  return Array.from({ length: count }, (_, i) => {
    while (kept[k + 1] <= i) k++
    return k + 1 < kept.length ? [k, k + 1, (i - kept[k]) / (kept[k + 1] - kept[k])] : [k, k, 0]
  })
}
