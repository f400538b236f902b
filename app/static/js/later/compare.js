// The dialog of numbers: the run on screen and each pinned one, every number a way to its increment.

import { by } from "../dom.js"
import { MEASURES, measured } from "./measures.js"
import { load, onPins, pins, swatch, titleOf } from "./pins.js"
import { goto } from "../player.js"
import { me } from "../state.js"

const element = (name, ...parts) => {
  const made = document.createElement(name)
  made.append(...parts)
  return made
}

function row(name, mark, run, surface, leadTo) {
  const heading = element("th", ...(mark ? [mark, " "] : []), name)
  heading.scope = "row"
  const found = run ? measured(run, surface) : {}
  const cells = Object.keys(MEASURES).map((measure) => {
    const { text = "…", why = "", k } = found[measure] ?? {}
    const button = Object.assign(element("button", text), { type: "button", title: why, disabled: k === undefined })
    button.setAttribute("aria-label", `${name}, ${MEASURES[measure][0]}: ${text} ${MEASURES[measure][1]}${why && `; ${why}`}`)
    button.dataset.measure = measure
    button.addEventListener("click", () => { by("numbers").close(); leadTo(k) })
    return element("td", button)
  })
  return element("tr", heading, ...cells)
}

function fill() {
  const head = element("tr", Object.assign(element("th", "run"), { scope: "col" }), ...Object.values(MEASURES).map(([text, unit, what]) => {
    const cell = element("th", text, element("small", unit))
    Object.assign(cell, { scope: "col", title: what })
    return cell
  }))
  const rows = pins.map((pin) => row(titleOf(pin), swatch(pin.slot), pin.run, pin.values?.surface ?? pin.scene.surface ?? "circular", (k) => load(pin, k)))
  const own = row("on screen", null, me.run, me.status.values.surface, (k) => goto(k))
  by("numbers-table").replaceChildren(element("thead", head), element("tbody", own, ...rows))
}

onPins(() => { if (by("numbers").open) fill() })

export function open() {
  fill()
  by("numbers").showModal()
}
