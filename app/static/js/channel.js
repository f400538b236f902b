// Messages between this page and the server: `order` to it, everything else from it (app/session/wire.py).

import { onChange } from "./bokeh.js"
import { by, on } from "./dom.js"
import { opened } from "./packed.js"
import { me } from "./store.js"

const ANSWERED = ["scene", "restore"] // orders that change the scene
const LARGEST = 2e6 // bytes of a file, as the server
let wire = null
let orders = 0, asks = 0

// Messages of bytes go to what takes their kind
export function connect(given) {
  wire = given
  onChange(wire, "message", () => {
    if (!wire.message) return // the server lets go of it
    const message = opened(wire.message), [call, unpack] = takers[message.head.kind] ?? []
    if (call) arrived(message, call, unpack)
  })
}

const takers = {} // {kind: [call, unpack]}
// Call `call` with every message of a kind; unpack: makes a promise of what is in it, where that takes time
export const take = (kind, call, unpack) => { takers[kind] = [call, unpack] }
export const listen = (what, call, unpack) => onChange(wire, what, () => arrived(wire[what], call, unpack))
export const silence = () => (me.waiting.length ? performance.now() - me.waiting[0].at : 0) // ms

let before = Promise.resolve() // done once all messages until now are passed on
// Pass a message on after those before it, also where these take longer to unpack or fail
function arrived(message, call, unpack) {
  const pass = ([{ value, reason }]) => (reason ? Promise.reject(reason) : call(value))
  before = Promise.allSettled([unpack ? unpack(message) : message, before]).then(pass).catch(reportError)
}

export function order(what, values, more) {
  const n = orders++
  if (ANSWERED.includes(what)) me.waiting = [...me.waiting, { n, what, values, at: performance.now() }]
  if (!me.lost) wire.order = JSON.stringify({ do: what, values, n, ...more })
}

// An order with a file: bytes, as app/session/orders.py reads them
async function orderFile(entry, file) {
  const body = new Uint8Array(await file.arrayBuffer())
  const head = new TextEncoder().encode(JSON.stringify({ do: "file", values: { entry }, n: orders++ }))
  const message = new Uint8Array(4 + head.length + body.length)
  new DataView(message.buffer).setUint32(0, head.length, true)
  message.set(head, 4)
  message.set(body, 4 + head.length)
  if (!me.lost) wire.order = message.buffer
}

// The server has heard the orders up to a number
export function heard(n) {
  if (me.waiting.some((sent) => sent.n <= n)) me.waiting = me.waiting.filter((sent) => !(sent.n <= n))
}

// Ask the page that is open for something
export function ask(values) {
  if (!me.lost) wire.order = JSON.stringify({ do: "ask", values, ask: asks++ })
}

// What is chosen as a file goes to the server; refuse(why) where it is too large
export function sendFile(id, refuse) {
  on(id, "click", () => { by(id).value = "" }) // so that the same file can be chosen again
  on(id, "change", async ({ target: { files: [file] } }) => {
    if (!file) return
    const size = (file.size / 1e6).toFixed(1)
    if (file.size > LARGEST) refuse(`${id}: ${file.name} has ${size} MB, allowed: 2 MB; thin it out.`)
    else await orderFile(id, file)
  })
}
