// The ways to look at the experiment: as it opens, in large for a lecture hall, and with all tools in sight.

import { by, keep, kept, on, readdress, tell } from "./dom.js"
import { CURVES } from "./figures.js"
import { openPage } from "./pages.js"
import { embedded, me, redraw, view } from "./store.js"
import { described } from "./words.js"

const { dataset } = document.documentElement

// For a lecture hall, or back
export function project() {
  dataset.view = dataset.view === "projector" ? "hero" : "projector"
  if (dataset.view === "projector" && document.querySelector(".page").dataset.page) openPage("")
  settle()
}

// All tools in sight, or only what a visitor needs; kept for the next visit
export function useTools() {
  document.documentElement.toggleAttribute("data-tools")
  if (!embedded) keep("view", "tools" in dataset ? "lab" : "hero")
  settle()
}

// Whether single letters, digits and signs do something. Those who dictate may switch them off, for good
export const lettersAreKeys = () => by("letters").checked

function settle() {
  const asked = dataset.view === "projector" ? "projector" : "tools" in dataset ? "lab" : null
  readdress((address) => (asked ? address.set("view", asked) : address.delete("view")))
  tellButtons()
  redraw()
}

function tellButtons() {
  by("projector").setAttribute("aria-pressed", dataset.view === "projector")
  by("tools").setAttribute("aria-pressed", "tools" in dataset)
}

export function connectViews() {
  by("letters").checked = kept("letters") !== "off"
  on("letters", "change", ({ target }) => keep("letters", target.checked ? "on" : "off"))
  tellButtons()
  on("projector", "click", project)
  on("tools", "click", useTools)
  on("chosen", "change", (event) => choose(event.target.value))
  for (const curve of CURVES) {
    document.querySelector(`main .${curve} figcaption`).addEventListener("click", ({ target }) => {
      if (!target.closest("button, label")) choose(curve)
    })
  }
  choose(CURVES[0])
  // in the hand, one slider at a time
  on("one", "change", ({ target }) => {
    for (const control of document.querySelectorAll(".control"))
      control.toggleAttribute("data-shown", control.dataset.name === target.value)
  })
}

// One of the curves is large
export function choose(curve) {
  document.querySelector("main").dataset.chosen = curve
  document.querySelector(`#chosen [value="${curve}"]`).checked = true
  redraw()
}

export function chooseNext() {
  const { chosen } = document.querySelector("main").dataset
  choose(CURVES[(CURVES.indexOf(chosen) + 1) % CURVES.length])
}

export function fillScreen() {
  if (document.fullscreenElement) document.exitFullscreen()
  else document.documentElement.requestFullscreen?.().catch(() => {}) // a browser may refuse: nothing is lost
}

// The line below the views of an embedded page: the parameters, and a link to the whole app
export const connectCaption = () => view(["picture", "status"], () => {
  if (!me.picture) return
  tell(by("caption"), described(me.picture.run, me.picture.k))
  const url = new URL(location.href)
  url.searchParams.delete("embed")
  if (by("whole-app").href !== url.href) by("whole-app").href = url.href
})
