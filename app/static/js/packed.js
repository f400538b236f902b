// Packed frames (format: app/service/packing.py).

// The chunk in the body of a message, in a while, with the rest of the message: {..., head, columns: {name:
// Float32Array}, fields: {name: Int16Array (frames, nodes)}}
export async function unpackLater({ body, ...message }) {
  const length = new DataView(body).getUint32(0, true), rest = new Uint8Array(body, 4 + length)
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(body, 4, length)))
  const planes = new Uint8Array(await inflated(rest)), { kept } = head
  const curves = curvesOf(planes, head.columns.length, head.frames), behind = planes.subarray(curves.byteLength)
  const [frames, nodes] = kept ? [kept.frames.length, kept.nodes.length] : [head.frames, head.nodes]
  const fields = fieldsOf(behind, frames, nodes)
  return { ...message, ...chunkOf(head, curves, kept ? filledIn(fields, kept, head) : fields) }
}

// What was deflated, an ArrayBuffer, in a while
export const inflated = (bytes) =>
  new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer()

const named = (names, numbers, size) =>
  Object.fromEntries(names.map((name, k) => [name, numbers.subarray(k * size, (k + 1) * size)]))

function chunkOf(head, curves, fields) {
  return {
    head,
    columns: named(head.columns, curves, head.frames),
    fields: named(Object.keys(head.scales), fields, head.frames * head.nodes),
  }
}

// Columns from their changes over frames, whose first bytes come first (packing.compressed)
function curvesOf(planes, columns, frames) {
  const curves = new Int32Array(columns * frames), { length } = curves
  for (let i = 0; i < length; i++) {
    const [second, third, fourth] = [1, 2, 3].map((byte) => planes[byte * length + i])
    const change = planes[i] | (second << 8) | (third << 16) | (fourth << 24)
    curves[i] = change + (i % frames ? curves[i - 1] : 0)
  }
  return new Float32Array(curves.buffer)
}

// Fields, frame by frame, from their changes over frames and nodes, which come node by node
function fieldsOf(planes, frames, nodes) {
  const fields = new Int16Array(planes.length / 2), high = planes.subarray(fields.length)
  for (let i = 0, field = 0; field < fields.length; field += frames * nodes) {
    for (let node = 0; node < nodes; node++) {
      for (let frame = 0, step = 0, at = field + node; frame < frames; frame++, i++, at += nodes) {
        step += planes[i] | (high[i] << 8) // to this node from the one before
        fields[at] = step + (node ? fields[at - 1] : 0)
      }
    }
  }
  return fields
}

// All frames and nodes of the fields of a stored run, which has few of them (app/service/stored.py) only
function filledIn(few, kept, { frames, nodes }) {
  const over = between(kept.frames, frames), along = between(kept.nodes, nodes)
  const wide = kept.nodes.length, size = wide * kept.frames.length, count = few.length / size
  const fields = new Int16Array(count * frames * nodes)
  for (let field = 0, at = 0; field < count; field++) {
    for (const [k, row] of over) {
      const start = field * size + k * wide
      for (const [j, part] of along) {
        const i = start + j, now = few[i] + part * (few[i + 1] - few[i])
        const next = few[i + wide] + part * (few[i + wide + 1] - few[i + wide])
        fields[at++] = Math.round(kept.step * (now + row * (next - now)))
      }
    }
  }
  return fields
}

// Of each place of so many: [number of the kept one before it, how far it is to the next, 0 .. 1]
function between(kept, count) {
  let k = 0
  return Array.from({ length: count }, (_, i) => {
    if (k < kept.length - 2 && kept[k + 1] <= i) k++
    return [k, (i - kept[k]) / (kept[k + 1] - kept[k])]
  })
}
