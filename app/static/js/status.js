// What the server says of the run and of what was entered, in words and in the address.

import { goToAsked, writeAddress } from "./address.js"
import { latest } from "./channel.js"
import { by, minus, say } from "./dom.js"
import { me } from "./state.js"

let looks = {}, positions = {} // preset: what to look for; slider: the values it stops at

export function connect(given) {
  ({ looks, positions } = given)
}

export function heard(text) {
  const old = me.status
  me.status = JSON.parse(text)
  const { state, values, errors, notes, frames } = me.status
  if (state === "finished" && me.run && frames === me.run.length) {
    by("scrub").max = me.run.length - 1
    if (me.following && me.playing) me.at = me.run.sheared
    me.following = false
  }
  if (me.status.heard === latest() && !me.entered) { // not the echo of a position the slider has left
    for (const name in values) describe(name, values[name], errors[name], old.values?.[name])
    if (frames > 0 && !me.dragging) writeAddress()
    say("profile-error", errors.profile)
    namePreset()
    by("look").textContent = presetSaid()
  }
  say("notes", notes.join(" "))
  tellState()
  goToAsked()
}

function describe(name, value, error, before) {
  const entry = by(`${name}-entry`)
  if (!error && document.activeElement !== entry || value !== before) entry.value = value
  entry.setAttribute("aria-invalid", Boolean(error))
  say(`${name}-error`, error)
  if (!me.dragging && positions[name]) place(name, value)
}

// A slider at the position nearest to a value
export function place(name, value) {
  const list = positions[name], slider = by(name)
  slider.value = list.reduce((best, v, i) => (Math.abs(v - value) < Math.abs(list[best] - value) ? i : best), 0)
  slider.setAttribute("aria-valuetext", `${value}`)
}

const changes = () => Object.keys(me.status.address).filter((name) => !["preset", "profile"].includes(name))
const inWords = (name) => document.querySelector(`label[for="${name}-entry"]`)?.firstChild.textContent.trim() || name

// The menu, which says so where the scene is no longer that of the preset; choosing the preset then brings it back
function namePreset() {
  const menu = by("preset"), { preset } = me.status
  const title = menu.querySelector(`[value="${preset}"]`).textContent
  menu.options[0].textContent = `${title.replace(/ \(.*/, "")} – changed`
  menu.value = changes().length ? "" : preset
}

// What to look for, where the scene is still that of the preset
function presetSaid() {
  const { preset, address, after } = me.status
  const changed = changes()
  const said = changed.map((name) => `${inWords(name)} = ${minus(address[name])}`).join(", ")
  if (after && me.origin?.number === after[0]) {
    const where = `increment ${after[1]} (Uₓ = ${me.origin.curves.U_x[after[1]].toFixed(1)} nm)`
    return `carried on from ${where} with ${said || "the preset's values"}; the address holds the parameters only`
  }
  return changed.length ? `changed: ${said}` : looks[preset]
}

export function tellState() {
  const { state, frames, total, evaluations, seconds, tolerance, why, known, residual } = me.status
  if (!state) return
  const shown = state === "finished" && !me.playing ? "paused" : state
  const text = {
    warming: () => "the solver gets ready; the first time takes up to a minute",
    running: () => `${frames} of ${total} increments`,
    paused: () => `after ${frames} of ${total} increments`,
    failed: () => why,
    finished: () => {
      const cycle = me.run?.dissipated ?? null
      return cycle === null ? "" : `dissipated in a cycle: ${cycle.toPrecision(4)} nJ/m`
    },
  }[state]()
  by("status").dataset.state = shown
  by("status").firstElementChild.textContent = { warming: "warming up", finished: "computed" }[shown] ?? shown
  by("status").querySelector("span").textContent = text
  by("solver").querySelector("p").textContent = `${frames} of ${total} increments, ${evaluations} force evaluations, `
    + `${known ? "computed before" : `${seconds} s`}; largest residual ${residual.toExponential(0)} nm`
    + (state === "finished" ? `: all increments converged to ${tolerance.toExponential(0)} nm.` : ".")
}
