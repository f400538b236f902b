// Pinned runs: kept in this browser, drawn behind the run on screen, shown as chips. Loaded with the first pin.

import { goBackTo, sceneOf } from "../address.js"
import { style } from "../beside.js"
import { order, take } from "../channel.js"
import { by, make, makeButton, makeShape, readdress } from "../dom.js"
import { unpackLater } from "../packed.js"
import { named } from "../quantities.js"
import { Run } from "../run.js"
import { me, view } from "../store.js"

const MOST = 4
const DASHES = { dashed: "9 5", dotted: "2 4", dotdash: "2 4 8 4", dashdot: "9 4 2 4" } // of the chips, px

// A pin: {run, scene, name, slot, shown, failure}; scene {name: text} as in an address, slot 1 .. MOST

export function pinRun() {
  const { run, status, pins } = me
  if (pins.length >= MOST) return say(`${MOST} runs are pinned: remove one first`)
  if (!run?.whole || status.run !== run.number) return say("this run is not complete yet: pin it when it is")
  if (pins.some((pin) => pin.run === run)) return say("this run is pinned already")
  const made = add(run, { ...status.address }, titled(status.address, status.preset))
  by("announcement").textContent = `pinned: ${made.name}`
}

function add(run, scene, name) {
  const slot = [1, 2, 3, 4].find((free) => me.pins.every((pin) => pin.slot !== free))
  const made = { run, scene, name, slot, shown: true }
  me.pins = [...me.pins, made]
  return made
}

// What differs from the preset, or the title of that
function titled(scene, preset) {
  const values =
    Object.keys(scene).filter((name) => !["preset", "profile"].includes(name)).map((name) => named(name, scene[name]))
  return values.join(", ") || document.querySelector(`#preset option[value="${preset}"]`).textContent
}

const change = (slot, news) => { me.pins = me.pins.map((pin) => (pin.slot === slot ? { ...pin, ...news } : pin)) }

function remove(slot) {
  me.pins = me.pins.filter((pin) => pin.slot !== slot)
  by(by("pin").checkVisibility() ? "pin" : "menu").focus()
}

// Back on the screen, at an increment of it
export const load = ({ scene }, k = null) => goBackTo(scene, k)

const button = (text, label, onclick, more) => makeButton({ title: label, "aria-label": label, onclick, ...more }, text)

export function swatch(slot) {
  const { ink, dash } = style(slot), stroke = { stroke: `var(${ink})`, "stroke-width": 3, "stroke-dasharray": DASHES[dash] ?? "" }
  return makeShape("svg", { class: "swatch", "aria-hidden": true }, makeShape("path", { d: "M1 5 H33", ...stroke }))
}

function chip(pin) {
  const { slot, shown } = pin
  const show = button("", `Show ${pin.name}`, () => change(slot, { shown: !shown }), { "aria-pressed": shown })
  show.append(swatch(slot), ` ${pin.name}${pin.failure ? ": failed" : pin.run ? "" : " …"}`)
  return make("span", { className: "chip", data: { slot } }, show,
    button("×", `Remove ${pin.name}`, () => remove(slot)))
}

function say(text) {
  by("pins").hidden = false
  by("pins-status").textContent = text
}

function tell() {
  const { pins } = me, focused = document.activeElement.closest(".chip")?.dataset.slot
  by("pins").hidden = !pins.length
  const failures = pins.filter(({ failure }) => failure).map(({ name, failure }) => `${name} failed: ${failure}.`)
  by("pins-status").textContent = failures.join(" ")
  by("chips").replaceChildren(...pins.map(chip))
  if (focused) document.querySelector(`.chip[data-slot="${focused}"] button`)?.focus()
  readdress((now) => {
    now.delete("pin")
    for (const pin of pins) now.append("pin", inLink(pin))
  })
}

// In a link: the name, then names and values of the scene, with stars in between
const escaped = (text) => `${text}`.replaceAll("%", "%25").replaceAll("*", "%2A")
const inLink = ({ name, scene }) => [name, ...Object.entries(scene).flat()].map(escaped).join("*")

// The pins of an address: the server computes them, beside the run on screen
export function fromLink(texts) {
  for (const text of texts.slice(0, MOST - me.pins.length)) {
    const [name, ...pairs] = text.split("*").map((part) => part.replaceAll("%2A", "*").replaceAll("%25", "%"))
    const asked = new URLSearchParams()
    for (let i = 0; i + 1 < pairs.length; i += 2) asked.set(pairs[i], pairs[i + 1])
    const scene = sceneOf(asked), { slot } = add(null, scene, name.slice(0, 40) || "pinned run")
    order("pin", { values: scene, pin: slot })
  }
}

const coming = {} // {slot: Run that is not whole yet}
function receive(chunk) {
  const run = (coming[chunk.pin] ??= new Run(`pin ${chunk.pin}`, chunk.head))
  run.add(chunk)
  if (!run.whole) return
  delete coming[chunk.pin]
  answered(chunk.pin, { run })
}

// Only a pin that waits: it may have been removed, and another have its place
function answered(slot, values) {
  if (me.pins.some((pin) => pin.slot === slot && !pin.run)) change(slot, values)
}

take("pinned", receive, unpackLater)
// The chip of a run that failed stays, with the reason, until the user removes it
take("pinned failed", ({ pin, why }) => answered(pin, { failure: why }))
view(["pins", "look"], () => { if (me.pins.length || by("chips")?.children.length) tell() })
