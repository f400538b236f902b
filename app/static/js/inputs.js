// What is entered and pressed: sliders, entries, buttons, keys, and the mouse on the curves.

import { moved, redo, undo, writeAddress } from "./address.js"
import { onEvent } from "./bokeh.js"
import { onHeard, order, waiting } from "./channel.js"
import { theme } from "./colours.js"
import { by, offerTable, on, readdress, say } from "./dom.js"
import { figures, paint, shadeMap } from "./figures.js"
import { openPage, paintPage } from "./pages.js"
import { goto, move, play, redraw, reset, show, toSlip } from "./player.js"
import { exact, leaveBehind, me, now, QUIET } from "./state.js"
import { place as stand, tellDepth } from "./status.js"
import { checkTruth } from "./truth.js"
import { chooseNext, connectViews, fillScreen, look } from "./view.js"

const PACE = 30 // ms: at most one message in this time, always the latest
const BURST = 900 // ms between two moves of one slider that are one drag, with what was on screen before it behind both
const LARGEST_FILE = 2e6 // bytes, as the server

let drag = { name: "", ended: 0 } // the slider moved last, and when it was let go, ms
let last = 0 // when something was sent
let chosen = "" // the menu in which something was just chosen: there Space plays, while before it opens the menu

// Changes parameters {name: text}, one or those of a place of a map
function enter(values) {
  const name = Object.keys(values).toSorted().join()
  if (name !== drag.name || (drag.ended && performance.now() - drag.ended > BURST)) {
    leaveBehind()
    goOnFrom()
  }
  drag = { name, ended: me.dragging ? 0 : -BURST }
  moved(name)
  me.entered = { ...me.entered, ...values }
  me.quiet = performance.now() + QUIET
  checkTruth()
  const rest = PACE - (performance.now() - last)
  if (rest > 0) setTimeout(sendNext, rest)
  else sendNext()
}

// While a slider moves, where it is by the time that the last position has been answered: nothing queues
function sendNext() {
  if (!me.dragging || !waiting().length) send(me.dragging)
}

function send(held) {
  if (!me.entered) return
  last = performance.now()
  const at = sheared() ? me.run.curves.U_x[now()] : 0
  order("scene", me.entered, { ...(me.from && { from: me.from }), ...(held && { held, at }) })
  me.entered = null
}

// Whether the top has been pulled at the increment on screen
const sheared = () => me.run?.sheared >= 0 && now() >= me.run.sheared

// The hand has come to rest, or has let go: now the exact run, and the views settle
let resting = 0
function rests() {
  clearTimeout(resting)
  if (!me.dragging) return
  me.dragging = false
  send(true)
  order("rest")
  redraw()
  writeAddress()
}

// With "carry on" a change takes effect at the increment shown, and the run goes on from there
function goOnFrom() {
  me.from = null
  if (!by("carry").checked || !exact(me.run) || !sheared()) return
  me.origin = me.run
  me.from = [me.run.number, now()]
}

// A hand moves parameters {name: text}, and will let go
function steer(values) {
  me.dragging = true
  clearTimeout(resting)
  resting = setTimeout(rests, me.rests)
  enter(values)
}

function letGo() {
  if (!drag.ended) drag.ended = performance.now()
  rests()
}

function connectSlider(name, values) {
  const slider = by(name), entry = by(`${name}-entry`)
  slider.addEventListener("input", () => {
    entry.value = values[slider.value]
    if (name === "delta_bar") tellDepth(entry.value)
    slider.setAttribute("aria-valuetext", entry.value)
    steer({ [name]: entry.value })
  })
  for (const end of ["pointerup", "pointercancel", "keyup", "blur"]) slider.addEventListener(end, letGo)
  slider.addEventListener("wheel", (event) => { // of the slider that has the focus: elsewhere the page scrolls
    if (document.activeElement !== slider) return
    event.preventDefault()
    slider.value = Number(slider.value) - Math.sign(event.deltaY)
    slider.dispatchEvent(new Event("input"))
    drag.ended = performance.now()
  })
  slider.closest("form").addEventListener("keydown", (event) => { if (event.key === "Escape") document.activeElement.blur() })
}

async function readProfile(event) {
  const file = event.target.files[0]
  if (!file) return
  if (file.size > LARGEST_FILE) {
    const size = (file.size / 1e6).toFixed(1)
    say("profile-error", `profile: ${file.name} has ${size} MB, allowed: 2 MB; thin it out. The run on screen stays.`)
  } else order("profile", { text: await file.text() })
}

function switchTheme() {
  document.documentElement.dataset.theme = theme() === "dark" ? "light" : "dark"
  readdress((asked) => asked.set("theme", theme()))
  paint()
  paintPage()
  shadeMap(me.run)
}

const KEYS = {
  " ": () => play(!me.playing), ArrowRight: move, ArrowLeft: (jump) => move(-jump),
  Home: () => goto(0), End: () => goto(Infinity), r: reset, "[": () => toSlip(-1), "]": () => toSlip(1), "?": () => by("keys").showModal(), p: () => look("projector"),
  l: () => look("lab"), c: chooseNext, m: slowMotion, f: fillScreen,
}
const PLAIN = " rpfmlc" // which a slider or a box leaves to the page

function onKey(event) {
  const open = document.querySelector("dialog[open]:not(#drawer)"), at = (what) => event.target.matches?.(what)
  if (event.key === "Escape" && !open) {
    if (by("drawer").open) by("drawer").close()
    if (event.target.closest?.("#panel")) by("menu").focus()
    unfold(false)
  }
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, held = event.ctrlKey || event.metaKey
  if (held && "zy".includes(key) && !event.altKey && !at("input[type=text]")) { // an entry has its own
    event.preventDefault()
    return key === "y" || event.shiftKey ? redo() : undo()
  }
  const taken = at("input[type=text], input[type=search]") || (at("button, [type=checkbox]") && key === " ")
    || (at("select") && !(key === " " && event.target.id === chosen)) || (at("input") && !PLAIN.includes(key))
  if (held || event.altKey || taken || open || !KEYS[key]) return
  event.preventDefault()
  KEYS[key](event.shiftKey ? 10 : 1)
}

async function slowMotion() {
  if (!me.run?.followed) (await import("./later/film.js")).slowMotion()
}

// Hovering a curve shows that increment in every view while playback rests; a click goes there
const there = (event) => (me.run?.sheared >= 0 ? me.run.nearest(event.x, me.at) : null)
function connectCurve(figure) {
  onEvent(figure, "mousemove", (event) => { if (!me.playing) { me.preview = there(event); show() } })
  onEvent(figure, "mouseleave", () => { if (me.preview !== null) { me.preview = null; show() } })
  onEvent(figure, "tap", (event) => { const k = there(event); if (k !== null) goto(k) })
}

const unfold = (open) => by("menu").setAttribute("aria-expanded", open)

function choosePreset(preset) {
  leaveBehind(false)
  order("preset", { preset })
  checkTruth()
}

export function connect(positions, usual) {
  onHeard(sendNext)
  for (const name in positions) connectSlider(name, positions[name])
  for (const entry of document.querySelectorAll("[id$=-entry]")) {
    entry.addEventListener("change", () => {
      entry.dataset.given = entry.value
      enter({ [entry.id.replace("-entry", "")]: entry.value })
    })
  }
  for (const menu of ["preset", "row"]) on(menu, "change", (event) => choosePreset(event.target.value))
  document.addEventListener("steer", ({ detail }) => { // by a page: the controls follow
    for (const name in detail) {
      by(`${name}-entry`).value = detail[name]
      if (positions[name]) stand(name, detail[name])
    }
    steer(detail)
  })
  document.addEventListener("let-go", letGo)
  on("profile", "change", readProfile)
  on("profile", "click", () => { by("profile").value = "" }) // so that the same file can be chosen again
  on("more", "click", async () => (await import("./drawer.js")).openDrawer(usual))
  on("menu", "click", () => unfold(by("menu").getAttribute("aria-expanded") !== "true"))
  // before what the button does: a dialog gives the focus back to what had it, which must not be hidden by then
  document.querySelector("header").addEventListener("click", (event) => {
    if (event.target.id === "menu" || !event.target.closest("button") || !by("menu").checkVisibility()) return
    unfold(false)
    by("menu").focus()
  }, true)
  document.addEventListener("pointerdown", (event) => { if (!event.target.closest("header, dialog")) unfold(false) })
  for (const button of document.querySelectorAll("nav button")) button.addEventListener("click", () => openPage(button.dataset.page))
  // a button pressed with the mouse gives the keyboard back, so that Space plays whatever was clicked last
  document.addEventListener("click", (event) => { if (event.detail > 0) event.target.closest?.("button:not(.hint, .term)")?.blur() })
  on("play", "click", KEYS[" "])
  on("step", "click", () => { play(false); move(1) })
  on("back", "click", () => move(-1))
  on("reset", "click", reset)
  on("pin", "click", async () => (await import("./later/pins.js")).pinRun())
  on("open-gallery", "click", async () => (await import("./later/gallery.js")).openGallery())
  on("take", "click", async () => (await import("./later/share.js")).open())
  on("slow", "click", slowMotion)
  on("compare", "click", async () => (await import("./later/compare.js")).open())
  on("help", "click", KEYS["?"])
  on("tour", "click", async () => (await import("./tour.js")).openTour())
  on("open-theory", "click", async () => (await import("./later/theory.js")).openTheory())
  for (const dialog of document.querySelectorAll("dialog:not(#drawer)")) dialog.addEventListener("click", (event) => { if (event.target === dialog) dialog.close() }) // beside it
  on("scrub", "input", (event) => goto(Number(event.target.value)))
  on("speed", "change", (event) => { me.speed = Number(event.target.value) })
  for (const menu of ["preset", "speed"]) {
    on(menu, "change", () => { chosen = menu })
    on(menu, "blur", () => { chosen = "" })
  }
  document.querySelectorAll("main figure:not(#twin)").forEach((figure, i) => {
    const view = Object.keys(figures)[i]
    offerTable(figure, view, figure.getAttribute("aria-label"), (tables) => tables.openTable(view))
  })
  on("theme", "click", switchTheme)
  connectViews()
  document.addEventListener("keydown", onKey)
  for (const name of ["forces", "area", "map"]) connectCurve(figures[name])
}
