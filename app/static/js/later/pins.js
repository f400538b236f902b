// Pinned runs: kept in this browser, drawn behind the run on screen, shown as chips. Loaded with the first pin.

import { restore, sceneOf } from "../address.js"
import { order, take } from "../channel.js"
import { colour } from "../colours.js"
import { by, make, makeButton, makeShape, readdress } from "../dom.js"
import { drawCurves, fill, overlays, painted } from "../figures.js"
import { unpackLater } from "../packed.js"
import { drawnFrame, sideways } from "../punch.js"
import { Run } from "../run.js"
import { me, onFrame } from "../state.js"
import { value } from "../words.js"

const MOST = 4
const WIDE = 2.5, THIN = 1.2 // px: friction and area, load
const DASHES = { dashed: "9 5", dotted: "2 4", dotdash: "2 4 8 4", dashdot: "9 4 2 4" } // of the chips, px
// {run, scene, name, slot, shown, carried, failure}; scene {name: text} as in an address, slot 1 .. MOST
export const pins = []

// Only the run itself was carried on from another: loaded, or in a link, its scene begins anew
export const titleOf = ({ name, carried }) => `${name}${carried ? ", carried on" : ""}`
const style = (slot) => ({ ink: colour(`--pin-${slot}`), dash: colour(`--pin-${slot}-dash`) })
const walksAlong = ({ run: pinned }, run) => pinned?.sheared >= 0 && pinned.head.abscissa === run.head.abscissa
const drawable = (run) => pins.filter((pin) => pin.shown && walksAlong(pin, run))

// What the lines of some runs have in common: colours and dashes in columns
function columns(lines) {
  const looks = lines.map(({ pin }) => style(pin.slot))
  return {
    xs: lines.map(({ x }) => x), ys: lines.map(({ y }) => y), width: lines.map(({ width }) => width ?? WIDE),
    colour: looks.map(({ ink }) => ink), dash: looks.map(({ dash }) => dash),
  }
}

// part(run, name): what is drawn of a curve, in one unit for all runs
function drawBeside(run, part, { names }, approach) {
  const shown = drawable(run)
  const line = (pin, name, width) => {
    const { along, value: y } = part(pin.run, name)
    return { pin, width, x: along, y }
  }
  fill("forces", "pins", columns(shown.flatMap((pin) => [line(pin, names.F), line(pin, names.L, THIN)])))
  fill("area", "pins", columns(shown.map((pin) => line(pin, "A"))))
  fill("map", "pins", columns(approach ? [] : shown.flatMap((pin) => outline(pin))))
}

// Both edges of contact over the path, until a leg turns; gaps where nothing is repelled
function outline(pin) {
  const { run } = pin, { stage } = run.curves
  const frames = run.frames((k) => k >= run.sheared && stage[k] === stage[run.sheared])
  const x = frames.map((k) => run.along[k])
  return run.head.flat ? [] : run.edgesOver(frames).map((y) => ({ pin, x, y, width: 2 }))
}

// The frame of a pinned run whose top has been pulled, or pressed, as far as that of the run on screen
const matched = ({ run: pinned }, run, k) =>
  (k < run.sheared ? Math.min(k, pinned.sheared) : pinned.nearest(run.along[k], Math.max(k, pinned.sheared)))

function drawSurfaces(run, k) {
  const lines = drawable(run).filter(({ run: of }) => !of.head.flat).map((pin) => {
    const { drawn, gap } = drawnFrame(pin.run, matched(pin, run, k), sideways(run))
    return { pin, x: drawn, y: gap, width: 2 }
  })
  if (lines.length || drawnSurfaces) fill("punch", "pins", columns(lines))
  drawnSurfaces = lines.length
}
let drawnSurfaces = 0

function redraw() {
  const { run } = me
  tell()
  if (!(run?.sheared >= 0)) return
  painted(() => {
    drawCurves(run, me.ghost, me.approach)
    if (me.drawn >= 0) drawSurfaces(run, Math.min(me.drawn, run.length - 1))
  })
}

export function pinRun() {
  const { run, status } = me
  if (pins.length >= MOST) return say(`${MOST} runs are pinned: remove one first`)
  if (!run?.whole || status.run !== run.number) return say("this run is not complete yet: pin it when it is")
  if (pins.some((one) => one.run === run)) return say("this run is pinned already")
  add(run, { ...status.address }, named(status.address, status.preset), Boolean(status.after))
  redraw()
  by("told").textContent = `pinned: ${titleOf(pins.at(-1))}`
}

function add(run, scene, name, carried = false) {
  const slot = [1, 2, 3, 4].find((free) => pins.every((one) => one.slot !== free))
  pins.push({ run, scene, name, slot, shown: true, carried })
}

// What differs from the preset, or the title of that
export function named(scene, preset) {
  const said =
    Object.keys(scene).filter((name) => !["preset", "profile"].includes(name)).map((name) => value(name, scene[name]))
  return said.join(", ") || document.querySelector(`#preset option[value="${preset}"]`).textContent
}

function remove(one) {
  pins.splice(pins.indexOf(one), 1)
  redraw()
  by("pin").focus()
}

// Back on the screen, at an increment of it
export const load = ({ scene }, k = null) => restore(scene, k)

const button = (text, label, onclick, more) => makeButton({ title: label, "aria-label": label, onclick, ...more }, text)

export function swatch(slot) {
  const { ink, dash } = style(slot), stroke = { stroke: ink, "stroke-width": 3, "stroke-dasharray": DASHES[dash] ?? "" }
  return makeShape("svg", { class: "swatch", "aria-hidden": true }, makeShape("path", { d: "M1 5 H33", ...stroke }))
}

function chip(one) {
  const show = button("", `Show ${titleOf(one)}`, () => {
    one.shown = !one.shown
    redraw()
    chipOf(one)?.querySelector("button").focus()
  }, { "aria-pressed": one.shown })
  show.append(swatch(one.slot), ` ${titleOf(one)}${one.failure ? ": failed" : one.run ? "" : " …"}`)
  return make("span", { className: "chip", data: { slot: one.slot } }, show,
    button("×", `Remove ${one.name}`, () => remove(one)))
}

const chipOf = (one) => document.querySelector(`.chip[data-slot="${one.slot}"]`)

function say(text) {
  by("pins").hidden = false
  by("pins-said").textContent = text
}

const listeners = []
export const onPins = (call) => listeners.push(call)

function tell() {
  by("pins").hidden = !pins.length
  const failures = pins.filter(({ failure }) => failure).map(({ name, failure }) => `${name} failed: ${failure}.`)
  by("pins-said").textContent = failures.join(" ")
  by("chips").replaceChildren(...pins.map(chip))
  readdress((now) => {
    now.delete("pin")
    for (const [name, text] of inLink()) now.append(name, text)
  })
  for (const call of listeners) call()
}

// In a link: the name, then names and values of the scene, with stars in between
const escaped = (text) => `${text}`.replaceAll("%", "%25").replaceAll("*", "%2A")
const inLink = () =>
  pins.map(({ name, scene }) => ["pin", [name, ...Object.entries(scene).flat()].map(escaped).join("*")])

// The pins of an address: the server computes them, beside the run on screen
export function fromLink(texts) {
  for (const text of texts.slice(0, MOST - pins.length)) {
    const [name, ...pairs] = text.split("*").map((part) => part.replaceAll("%2A", "*").replaceAll("%25", "%"))
    const asked = new URLSearchParams()
    for (let i = 0; i + 1 < pairs.length; i += 2) asked.set(pairs[i], pairs[i + 1])
    const scene = sceneOf(asked)
    add(null, scene, name.slice(0, 40) || "pinned run")
    order("beside", scene, { beside: pins.at(-1).slot })
  }
  tell()
}

function receive(chunk) {
  const one = pins.find(({ slot }) => slot === chunk.pin)
  if (!one) return
  const run = one.coming ?? new Run(`pin ${chunk.pin}`, chunk.head)
  one.coming = run
  run.add(chunk)
  if (!run.whole) return
  one.run = run
  redraw()
}

// The chip of a run that failed stays, with the reason, until the user removes it
function fail({ head: { pin, why } }) {
  const one = pins.find(({ slot }) => slot === pin)
  if (!one) return
  one.failure = why
  redraw()
}

take("pinned", receive, unpackLater)
take("pinned failed", fail)
overlays.curves = (run, part, name) => drawable(run).map((one) => part(one.run, name).value)
overlays.drawn = drawBeside
overlays.has = (run) => pins.some((one) => one.shown && one.run === run)
onFrame(drawSurfaces)
new MutationObserver(redraw).observe(document.documentElement, { attributeFilter: ["data-theme"] })
