// Orders to the server, and messages from it: the parameters of the Stage (app/stage.py).

import { warn } from "./opening.js"
import { alone, me } from "./store.js"

const ANSWERED = ["scene", "restore"] // orders that change the scene
const LATE = 20_000 // ms
let stage = null // the Stage, once it is there
const early = [] // orders given before
export const isThere = () => Boolean(stage)
let orders = 0
let asked = [] // {n, at} of orders without an answer, the oldest first

// The Stage is there, or rendered again. The first order starts the run: what was given before is about one
export function connect(model) {
  const first = !stage
  stage = model
  for (const kind in takers) listen(kind)
  if (!first) return
  for (const kind in takers) if (stage[kind]?.sent) pass(kind) // of a Result, set before it is shown
  order("hello")
  for (const given of early.splice(0)) send(...given)
}

function send(what, fields) {
  asked.push({ n: fields.n, at: performance.now() })
  stage[what] = fields
}

// Messages go to what takes their kind, in the order in which they came
function listen(kind) {
  stage.on(kind, () => pass(kind))
}

function pass(kind) {
  const message = stage[kind], [call, unpack] = takers[kind], of = message.run ?? message.frame
  const next = ([{ value, reason }]) => {
    if (reason) return incomplete(kind, of, reason)
    return of !== undefined && broken[kind] === of ? null : call(value)
  }
  const unpacked = unpack ? Promise.race([unpack(message), late(kind)]) : message
  before = Promise.allSettled([unpacked, before]).then(next).catch(reportError)
}

const broken = {} // {kind: its run, or frame of a film, that lost a part: later parts are dropped}
function incomplete(kind, of, reason) {
  if (of !== undefined) {
    broken[kind] = of
    warn("Incomplete:", "a part of this run did not arrive. Load the page again: ", () => location.reload())
  }
  throw reason
}

// Fails after a time: what is not unpacked by then holds back all later messages
const late = (kind) => new Promise((_, fail) => setTimeout(() => fail(new Error(`${kind}: not unpacked`)), LATE))

const takers = {} // {kind: [call, unpack]}
let before = Promise.resolve() // done once all messages until now are passed on, also where these take long or fail
// Call `call` with every message of a kind; unpack: makes a promise of what is in it, where that takes time
export function take(kind, call, unpack) {
  takers[kind] = [call, unpack]
  if (stage) listen(kind)
}
export const silence = () => (asked.length ? performance.now() - asked[0].at : 0) // ms

// Give an order with its fields; without a server there is nobody to obey
export function order(what, fields = {}) {
  if (alone) return
  const n = what === "hello" ? 0 : ++orders
  if (ANSWERED.includes(what)) me.waiting = [...me.waiting, { n, what, values: fields.values }]
  if (me.lost) return
  if (stage) send(what, { n, ...fields })
  else early.push([what, { n, ...fields }])
}

let answered = -1 // number of the newest order that the server has answered
// Whether a status was sent before the server heard of what it has answered since, by a picture
export const outdated = ({ acknowledged }) => acknowledged < answered

// The server has heard the orders up to a number
export function heard(n) {
  answered = Math.max(answered, n ?? -1)
  asked = asked.filter((sent) => sent.n > answered)
  if (me.waiting.some((sent) => sent.n <= n)) me.waiting = me.waiting.filter((sent) => !(sent.n <= n))
}
