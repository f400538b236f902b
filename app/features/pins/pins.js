// Pinned runs: their chips and lines. Loaded with the first pin.

import { addPart, charts } from "../../static/js/charts.js"
import { drawnAlong } from "../../static/js/curves.js"
import { by, focused, make, makeButton, makeShape, one } from "../../static/js/dom.js"
import { drawnFrame, sideways } from "../../static/js/punch.js"
import { named } from "../../static/js/quantities.js"
import { frame, me, view } from "../../static/js/store.js"
import { changedIn, titleOf } from "../../static/js/words.js"

const DASHES = [[6, 4], [2, 4], [2, 4, 6, 4], [6, 4, 2, 4]] // px, of the pins in turn
const MOST = DASHES.length

// A pin: {run, name, slot, shown, ink, dash}; slot 1 .. MOST

export function pinRun() {
  if (!connected) connect()
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
  const { pins } = me, held = focused()?.closest(".chip")?.dataset.slot
  by("pins").hidden = !pins.length
  by("pins-status").textContent = ""
  by("chips").replaceChildren(...pins.map(chip))
  if (held) one(`.chip[data-slot="${held}"] button`)?.focus()
}

const WIDE = 2.5, THIN = 1.2 // px: friction and area, load

// Pins whose runs are drawn along the same path as a run
const beside = (run) => me.pins.filter(({ shown, run: pinned }) => (
  shown && drawnAlong(pinned, run)))

// Lines of pinned runs, each in the colour and dashes of its pin
const lines = (list) => (
  { list: list.map(({ pin: { ink, dash }, width = WIDE, x, y }) => ({ x, y, width, ink, dash })) })

// Pinned runs behind the run on screen: their curves, and outlines in the map, which is not painted without need
let pinned = 0 // how many are drawn
function drawPins() {
  const { charted: run, approach } = me, pins = run ? beside(run) : []
  if (!pins.length && !pinned) return
  pinned = pins.length
  const line = (pin, name, width) => {
    const { along: x, value: y } = pin.run.drawn(name, approach)
    return { pin, width, x, y }
  }
  charts.forces.fill("pins", lines(pins.flatMap((pin) => [line(pin, "F"), line(pin, "L", THIN)])))
  charts.area.fill("pins", lines(pins.map((pin) => line(pin, "A"))))
  charts.map?.fill("pins", lines(approach ? [] : pins.flatMap(outline)))
}

// Both edges of contact over the path, until a leg turns; gaps where nothing is repelled
function outline(pin) {
  const { run } = pin, { stage } = run.curves
  const frames = run.frames((k) => k >= run.sheared && stage[k] === stage[run.sheared])
  const x = frames.map((k) => run.along[k])
  return run.head.flat ? [] : run.edgesOver(frames).map((y) => ({ pin, x, y, width: 2 }))
}

// The frame of a pinned run whose top has been pulled, or pressed, as far as that of the run on screen
const matched = ({ run: of }, run, k) =>
  (k < run.sheared ? Math.min(k, of.sheared) : of.nearest(run.along[k], Math.max(k, of.sheared)))

function drawPinnedSurfaces() {
  const { run, k } = me.picture ?? {}
  if (!run || (!me.pins.length && !charts.punch.parts.pins.list.length)) return
  charts.punch.fill("pins", lines(beside(run).filter((pin) => !pin.run.head.flat).map((pin) => {
    const { drawn: x, gap: y } = drawnFrame(pin.run, matched(pin, run, k), sideways(run))
    return { pin, x, y, width: 2 }
  })))
}

// The first pin makes what shows pins
let connected = false
function connect() {
  connected = true
  addPart("punch", "pins", { kind: "lines", list: [] }, "story")
  addPart("forces", "pins", { kind: "lines", list: [] }, "ghost_F")
  addPart("area", "pins", { kind: "lines", list: [] }, "ghost_A")
  if (charts.map) addPart("map", "pins", { kind: "lines", list: [] }, "slips")
  view(["pins", "look"], tell)
  view(["pins"], () => { me.beside = me.pins.filter(({ shown }) => shown).map(({ run }) => run) })
  frame(["pins", "charted", "approach", "look"], drawPins)
  frame(["pins", "picture"], drawPinnedSurfaces)
}
