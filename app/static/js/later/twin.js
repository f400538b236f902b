// Side by side: the punch of a pinned run beside that of the run on screen, at the same place of the path and to the same
// scale. Loaded when it is asked for.

import { onChange } from "../bokeh.js"
import { order } from "../channel.js"
import { by, say } from "../dom.js"
import { adopt, drawn, figures, fitFrames, overlays, paint } from "../figures.js"
import { slot } from "../pages.js"
import { show } from "../player.js"
import { me, onFrame } from "../state.js"
import { drawStory } from "../story.js"
import { matched, named, onPins, pins, swatch, titleOf, walksAlong } from "./pins.js"

const chosen = () => pins.find((one) => one.twin)
const drawable = (run) => (figures.twin && chosen() && walksAlong(chosen(), run) ? chosen() : null)

// Show a pinned run there, or take it away
export function toggle(pin) {
  const one = chosen()
  if (one) one.twin = false
  pin.twin = pin !== one
  ask()
}

let asked = false
function ask() {
  if (asked) return
  asked = true
  onChange(slot("twin"), "children", () => {
    adopt("twin", slot("twin").children[0])
    paint()
    again()
  })
  order("twin")
}

function tell() {
  const pin = chosen()
  document.querySelector(".page").toggleAttribute("data-twin", Boolean(pin))
  by("twin").hidden = by("punch-of").hidden = !pin
  if (pin) by("twin-of").replaceChildren(swatch(pin.slot), ` pinned: ${titleOf(pin)}`)
  again()
}

// Once the figure has its place on the screen
function again() {
  if (!me.run?.length) return
  fitFrames(me.run)
  show()
  if (chosen() && !(figures.twin && drawn(["twin"]))) requestAnimationFrame(again)
}

function draw(run, k) {
  const pin = chosen(), fits = drawable(run)
  if (!pin) return
  const name = `on screen: ${named(me.status.address, me.status.preset)}`
  if (by("punch-of").textContent !== name) by("punch-of").textContent = name
  by("twin-view").style.visibility = fits ? "" : "hidden"
  say("twin-said", fits || !figures.twin ? "" : pin.run ? "It goes along another path: no increment of it is that on screen." : "It is being computed.")
  if (fits) drawStory(fits.run, matched(fits, run, k), by("twin-view").querySelector("canvas"), figures.twin)
}

overlays.punches = (run, k) => (drawable(run) ? [["twin", chosen().run, matched(chosen(), run, k)]] : [])
onFrame(draw)
onPins(tell)
