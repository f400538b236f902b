// Parameters changed by hand: with a slider, the punch, a map or an entry. While a hand moves them the server hears of
// the latest only; one drag has what was on screen before it behind all of its pictures.

import { order } from "./channel.js"
import { by } from "./dom.js"
import { place, tellDepth } from "./sliders.js"
import { declared, beginChange, me, redraw } from "./store.js"

const BURST = 900 // ms between two moves of one slider that are one drag

let ended = 0 // ms, when what was moved last was let go; 0: it is held
let resting = 0

// Changes parameters {name: text}, one or those of a place of a map
export function enter(values) {
  const name = Object.keys(values).toSorted().join()
  if (name !== me.move.name || (ended && performance.now() - ended > BURST)) {
    me.move = { name }
    beginChange()
  }
  ended = me.dragging ? 0 : -BURST
  me.entered = { ...me.entered, ...values }
  sendNext()
}

// Send what was entered. In a drag, the newest position goes as soon as the last one sent has been answered, so that
// nothing queues.
export function sendNext(held = me.dragging) {
  if (!me.entered || (me.dragging && me.waiting.length)) return
  // with what is not answered yet: of two values of a parameter that come together Panel passes on the last
  const since = me.waiting.slice(me.waiting.findLastIndex(({ what }) => what !== "scene") + 1)
  const values = Object.assign({}, ...since.map((sent) => sent.values), me.entered)
  order("scene", { values, ...(held && { held }) })
  me.entered = null
}

// Another scene, that of an address {name: text}: whatever a hand has moved before is no part of it
export function restore(values) {
  me.entered = null
  me.move = { name: "" }
  order("restore", { values })
}

// A hand moves parameters {name: text}, and will let go; their controls follow
export function steer(values) {
  for (const name in values) {
    by(`${name}-entry`).value = values[name]
    if (declared.positions[name]) place(name, values[name])
    if (name === "delta_bar") tellDepth(values[name])
  }
  me.dragging = true
  clearTimeout(resting)
  resting = setTimeout(rests, me.rests)
  enter(values)
}

export function letGo() {
  ended ||= performance.now()
  rests()
}

// The hand has come to rest, or has let go: now the exact run, and the views settle
function rests() {
  clearTimeout(resting)
  if (!me.dragging) return
  me.dragging = false
  sendNext(true)
  order("release")
  if (!me.run?.few) redraw() // else all of its increments come, and are drawn then (player.js)
}
