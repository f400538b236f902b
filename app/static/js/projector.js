// Projector mode: text and lines that the back row can read, three views, and the values of the moment in large.

import { by, readdress } from "./dom.js"
import { paint } from "./figures.js"
import { projected } from "./large.js"
import { openPage } from "./pages.js"
import { show } from "./player.js"

// On or off; without a word, the other of both
export function project(asked) {
  const on = typeof asked === "boolean" ? asked : !projected()
  if (on) document.documentElement.dataset.view = "projector"
  else delete document.documentElement.dataset.view
  by("projector").setAttribute("aria-pressed", on)
  readdress((address) => (on ? address.set("view", "projector") : address.delete("view")))
  if (on && document.querySelector(".page").dataset.page) openPage("")
  paint()
  setTimeout(show, 100) // once the figures have their new size
}

export function fillScreen() {
  if (document.fullscreenElement) document.exitFullscreen()
  else document.documentElement.requestFullscreen?.().catch(() => {}) // a browser may refuse: nothing is lost
}
