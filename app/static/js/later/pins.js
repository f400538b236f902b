// Pinned runs: kept in this browser, drawn behind the run on screen, shown as chips. Loaded with the first pin.

import { by, make, makeButton, makeShape } from "../dom.js"
import { named } from "../quantities.js"
import { me, view } from "../store.js"
import { changedIn, titleOf } from "../words.js"

const DASHES = [[6, 4], [2, 4], [2, 4, 6, 4], [6, 4, 2, 4]] // px, of the pins in turn
const MOST = DASHES.length

// A pin: {run, name, slot, shown, ink, dash}; slot 1 .. MOST

export function pinRun() {
  const { run, status, pins } = me
  if (pins.length >= MOST) return say(`${MOST} runs are pinned: remove one first`)
  if (!run?.whole || status.run !== run.number) return say("this run is not complete yet: pin it when it is")
  if (pins.some((pin) => pin.run === run)) return say("this run is pinned already")
  const { address, preset } = status, values = changedIn(address).map((name) => named(name, address[name]))
  const name = values.join(", ") || titleOf(preset)
  const slot = [1, 2, 3, 4].find((free) => pins.every((pin) => pin.slot !== free))
  me.pins = [...pins, { run, name, slot, shown: true, ink: `--pin-${slot}`, dash: DASHES[slot - 1] }]
  by("announcement").textContent = `pinned: ${name}`
}

const change = (slot, news) => { me.pins = me.pins.map((pin) => (pin.slot === slot ? { ...pin, ...news } : pin)) }

function remove(slot) {
  me.pins = me.pins.filter((pin) => pin.slot !== slot)
  by("menu").focus()
}

const button = (text, label, onclick, more) => makeButton({ title: label, "aria-label": label, onclick, ...more }, text)

function swatch({ ink, dash }) {
  const stroke = { stroke: `var(${ink})`, "stroke-width": 3 }
  return makeShape("svg", { class: "swatch", "aria-hidden": true },
    makeShape("path", { d: "M1 5 H33", ...stroke, "stroke-dasharray": dash.join(" ") }))
}

function chip(pin) {
  const { slot, shown } = pin
  const show = button("", `Show ${pin.name}`, () => change(slot, { shown: !shown }), { "aria-pressed": shown })
  show.append(swatch(pin), ` ${pin.name}`)
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
  by("pins-status").textContent = ""
  by("chips").replaceChildren(...pins.map(chip))
  if (focused) document.querySelector(`.chip[data-slot="${focused}"] button`)?.focus()
}

view(["pins", "look"], () => { if (me.pins.length || by("chips")?.children.length) tell() })
