// What is entered and pressed: sliders, entries, buttons, keys, and the mouse on the punch and on the curves.

import { theme } from "./colours.js"
import { by, closest, focused, on, onDrag, one, readdress, root } from "./dom.js"
import { goto, move, play, reset, toggle, toSlip } from "./player.js"
import { enter, letGo, steer } from "./steer.js"
import { alone, declared, me, redraw } from "./store.js"
import { chooseNext, connectViews, lettersAreKeys, project, seeMore } from "./view.js"

const DECIDED = 6 // px after which it is clear which way is meant
const PART = 0.5 // of the path for the width of the view
const DEEP = 1 / 150 // of delta_bar per px: a third of the slider in 100 px

let chosen = null // the menu in which something was just chosen: there Space plays, while before it opens the menu

function connectSlider(name, values) {
  const slider = by(name)
  slider.addEventListener("input", () => steer({ [name]: `${values[slider.value]}` }))
  for (const end of ["pointerup", "pointercancel", "keyup", "blur"]) slider.addEventListener(end, letGo)
}

// Dragging the punch itself: sideways to where the top has been pulled, up and down to another indentation. A finger
// pushes it at the grip only, as elsewhere it scrolls the page
function connectHand() {
  const view = by("punch-view"), slider = by("delta_bar"), values = declared.positions.delta_bar
  onDrag(view, (event) => { // where the drag begins, and what it changes, once that is clear
    if (event.button || event.target.closest("[data-own]") || !(me.run?.sheared >= 0)) return null
    const along = me.run.along[Math.max(0, me.drawn)]
    const pushes = !alone && (event.pointerType !== "touch" || event.target.id === "grab")
    return { x: event.clientX, y: event.clientY, way: null, along, delta: values[slider.value], pushes }
  }, (event, from) => {
    const dx = event.clientX - from.x, dy = event.clientY - from.y
    if (!from.way && Math.max(Math.abs(dx), Math.abs(dy)) > DECIDED) {
      const upright = from.pushes ? "down" : "scrolls"
      from.way = Math.abs(dx) > Math.abs(dy) ? "along" : upright
      if (from.way === "scrolls") return
      view.setPointerCapture(event.pointerId)
      view.dataset.dragged = from.way
    }
    if (from.way === "along") pull(from.along, dx)
    else if (from.way === "down") push(from.delta + DEEP * dy)
  }, ({ way }) => {
    if (way === "down") letGo()
    if (way && way !== "scrolls") hideHint()
    delete view.dataset.dragged
  })

  // the top follows the hand, at a pace that shows every slip
  function pull(along, dx) {
    const { along: path, sheared } = me.run, long = Math.abs(path.at(-1) - path[sheared]) || 1
    goto(me.run.nearest(along + (dx * PART * long) / view.clientWidth, Math.max(me.at, sheared)))
  }

  function push(delta) {
    const at = closest(values, delta)
    if (!slider.disabled && Number(slider.value) !== at) steer({ delta_bar: `${values[at]}` })
  }
}

function switchTheme() {
  root.dataset.theme = theme() === "dark" ? "light" : "dark"
  readdress((asked) => asked.set("theme", theme()))
  redraw()
}

// {key: what it does}; features add theirs
export const KEYS = {
  " ": toggle, ArrowRight: move, ArrowLeft: (jump) => move(-jump),
  Home: () => goto(0), End: () => goto(Infinity), r: reset, "[": () => toSlip(-1), "]": () => toSlip(1),
  "?": () => by("keys").showModal(), p: project, l: seeMore, c: chooseNext,
}

function onKey(event) {
  const open = one("dialog:modal"), at = (what) => event.target.matches?.(what)
  if (event.key === "Escape" && !open && event.target.closest?.("#panel")) by("menu").focus()
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key, held = event.ctrlKey || event.metaKey
  if (key.length === 1 && key !== " " && !lettersAreKeys()) return
  const taken = at("input[type=text], input[type=search]") || (at("button, [type=checkbox]") && key === " ")
    || (at("select") && !(key === " " && event.target === chosen)) || (at("input") && !/^[ a-z]$/.test(key))
  if (held || event.altKey || taken || open || !KEYS[key]) return
  event.preventDefault()
  hideHint()
  KEYS[key](event.shiftKey ? 10 : 1)
}

// The hint over the contact goes once anything was moved
const hideHint = () => { by("grab").hidden = true }

export function connect() {
  root.addEventListener("input", hideHint, { once: true })
  for (const name in declared.positions) connectSlider(name, declared.positions[name])
  one(".controls").addEventListener("keydown", ({ key }) => {
    if (key === "Escape" || (key === "Enter" && focused().matches("input[type=text]")))
      focused().blur()
  })
  root.addEventListener("change", ({ target: entry }) => {
    if (!entry.id.endsWith("-entry")) return
    entry.dataset.given = entry.value
    enter({ [entry.id.replace("-entry", "")]: entry.value })
  })
  // before what the button does: a dialog gives the focus back to what had it, which must not be hidden by then
  one("header").addEventListener("click", (event) => {
    if (event.target.id === "menu" || !event.target.closest("button") || !by("menu").checkVisibility()) return
    by("panel").hidePopover()
    by("menu").focus()
  }, true)
  // a button pressed with the mouse gives the keyboard back, so that Space plays whatever was clicked last
  root.addEventListener("click", ({ detail, target }) => {
    if (detail > 0) target.closest?.("button:not([popovertarget=solver])")?.blur()
  })
  on("play", "click", toggle)
  on("step", "click", () => { play(false); move(1) })
  on("back", "click", () => move(-1))
  on("reset", "click", reset)
  on("help", "click", KEYS["?"])
  on("scrub", "input", (event) => goto(Number(event.target.value)))
  on("speed", "change", (event) => { me.speed = Number(event.target.value) })
  root.addEventListener("change", ({ target }) => { if (target.matches("[data-plays]")) chosen = target })
  root.addEventListener("focusout", () => { chosen = null })
  on("theme", "click", switchTheme)
  connectViews()
  root.addEventListener("keydown", onKey)
  connectHand()
}
