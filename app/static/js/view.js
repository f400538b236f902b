// The ways to look at the experiment: as it opens, with more in sight, and in large for a lecture hall.

import { CURVES } from "./charts.js"
import { all, by, keep, kept, on, one, readdress, root } from "./dom.js"
import { redraw, sees, view } from "./store.js"

const { dataset } = root

// For a lecture hall, or back
export function project() {
  if (projected()) delete dataset.view
  else dataset.view = "projector"
  settle()
}

// More in sight than punch, sentence, forces, sliders and Play, or these alone; kept for the next visit
export function seeMore() {
  by("more").ariaPressed = !sees("more")
  keep("more", sees("more") ? "1" : "0")
  settle()
}

// Whether single letters and signs do something. Those who dictate may switch them off, for good
export const lettersAreKeys = () => by("letters").checked

const projected = () => dataset.view === "projector"

function settle() {
  readdress((address) => {
    for (const [name, value, chosen] of [["view", "projector", projected()], ["more", "1", sees("more")]]) {
      if (chosen) address.set(name, value)
      else address.delete(name)
    }
  })
  tellButtons()
  redraw()
}

function tellButtons() {
  by("projector").setAttribute("aria-pressed", projected())
  by("bands").hidden = !sees("bands")
}

export function connectViews() {
  by("letters").checked = kept("letters") !== "off"
  on("letters", "change", ({ target }) => keep("letters", target.checked ? "on" : "off"))
  view(["shows"], tellButtons)
  on("projector", "click", project)
  on("more", "click", seeMore)
  on("chosen", "change", (event) => choose(event.target.value))
  one(".views").addEventListener("click", ({ target }) => {
    const curve = CURVES.find((name) => target.closest(`.${name} > figcaption`))
    if (curve && !target.closest("button, label")) choose(curve)
  })
  choose(CURVES[0])
  // in the hand, one slider at a time
  on("one", "change", ({ target }) => {
    for (const control of all(".control"))
      control.toggleAttribute("data-shown", control.dataset.name === target.value)
  })
}

// One of the curves is large
export function choose(curve) {
  for (const name of CURVES) one(`.curves > .${name}`).toggleAttribute("data-large", name === curve)
  one(`#chosen [value="${curve}"]`).checked = true
  redraw()
}

export function chooseNext() {
  if (!sees("more")) return
  const chosen = one("#chosen :checked").value
  choose(CURVES[(CURVES.indexOf(chosen) + 1) % CURVES.length])
}
