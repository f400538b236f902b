// Messages of bytes: a JSON header and numbers behind it (format: app/service/packing.py).

// uint32 length of the header, the header, the rest from `start` on
export function opened(buffer, at = 0) {
  const length = new DataView(buffer).getUint32(at, true), start = at + 4 + length
  return { head: JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, at + 4, length))), start }
}

// One chunk (ArrayBuffer) that is not compressed, as {run, head, columns: {name: Float32Array}, fields: {name: Int16Array
// (frames, nodes)}}; nothing is copied
export function unpack(buffer) {
  const { head, start } = opened(buffer, 4)
  return chunkOf(buffer, head, buffer, start)
}

// The same of a chunk that may be compressed, in a while
export async function unpackLater(buffer) {
  const { head, start } = opened(buffer, 4)
  if (!head.compressed) return unpack(buffer)
  const stream = new Blob([new Uint8Array(buffer, start)]).stream().pipeThrough(new DecompressionStream("deflate"))
  return chunkOf(buffer, head, restored(head, new Uint8Array(await new Response(stream).arrayBuffer())), 0)
}

function chunkOf(buffer, head, body, start) {
  const take = (kind, count) => {
    start += kind.BYTES_PER_ELEMENT * count
    return new kind(body, start - kind.BYTES_PER_ELEMENT * count, count)
  }
  const named = (names, kind, count) => Object.fromEntries(names.map((name) => [name, take(kind, count)]))
  const columns = named(head.columns, Float32Array, head.frames)
  const fields = named(Object.keys(head.scales), Int16Array, head.frames * head.nodes)
  return { run: new DataView(buffer).getUint32(0, true), head, columns, fields }
}

// Columns and fields (ArrayBuffer) from their changes, whose first bytes come first (packing._compressed)
function restored({ frames, nodes, columns }, planes) {
  const start = 4 * columns.length * frames, body = new ArrayBuffer(planes.length)
  const curves = new Int32Array(body, 0, start / 4), fields = new Int16Array(body, start)
  for (let i = 0; i < curves.length; i++) {
    let change = 0
    for (let byte = 0; byte < 4; byte++) change |= planes[byte * curves.length + i] << (8 * byte)
    curves[i] = change + (i % frames ? curves[i - 1] : 0)
  }
  const low = planes.subarray(start), high = low.subarray(fields.length)
  for (let i = 0, field = 0; field < fields.length; field += frames * nodes) {
    for (let node = 0; node < nodes; node++) { // node by node; the fields are frame by frame
      for (let frame = 0, step = 0, at = field + node; frame < frames; frame++, i++, at += nodes) {
        step += low[i] | (high[i] << 8) // to the node from the one before
        fields[at] = step + (node ? fields[at - 1] : 0)
      }
    }
  }
  return body
}
