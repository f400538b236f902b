// The ways to look at the experiment: the hero, the same in large for a lecture hall, and the laboratory with all tools.

import { by, on, readdress } from "./dom.js"
import { CURVES, paint } from "./figures.js"
import { openPage } from "./pages.js"
import { show } from "./player.js"
import { embedded } from "./state.js"
import { keep } from "./storage.js"

let before = "hero" // how one looked before

export const view = () => document.documentElement.dataset.view
export const isLab = () => view() === "lab"

// Look that way; where one looks so already, at the hero, or from the lecture hall the way one did before
export function look(wanted) {
  const next = wanted !== view() ? wanted : wanted === "projector" ? before : "hero"
  before = isLab() ? "lab" : "hero"
  document.documentElement.dataset.view = next
  if (next !== "projector" && !embedded) keep("view", next)
  readdress((address) => (next === "hero" ? address.delete("view") : address.set("view", next)))
  if (next === "projector" && document.querySelector(".page").dataset.page) openPage("")
  arrange()
  paint()
  setTimeout(show, 100) // once the figures have their new size
}

function arrange() {
  for (const name of ["lab", "projector"]) by(name).setAttribute("aria-pressed", view() === name)
}

export function connectViews() {
  arrange()
  for (const name of ["lab", "projector"]) on(name, "click", () => look(name))
  on("chosen", "change", (event) => choose(event.target.value))
  for (const curve of CURVES) document.querySelector(`main .${curve} figcaption`).addEventListener("click", ({ target }) => { if (!isLab() && !target.closest("button")) choose(curve) })
  choose(CURVES[0])
  // in the hand, one slider at a time
  on("one", "change", ({ target }) => {
    for (const one of document.querySelectorAll(".control")) one.toggleAttribute("data-shown", one.dataset.name === target.value)
  })
}

// One of the curves is large
export function choose(curve) {
  document.querySelector("main").dataset.chosen = curve
  document.querySelector(`#chosen [value="${curve}"]`).checked = true
  paint()
}

export function chooseNext() {
  const { chosen } = document.querySelector("main").dataset
  choose(CURVES[(CURVES.indexOf(chosen) + 1) % CURVES.length])
}

export function fillScreen() {
  if (document.fullscreenElement) document.exitFullscreen()
  else document.documentElement.requestFullscreen?.().catch(() => {}) // a browser may refuse: nothing is lost
}

