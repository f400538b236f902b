// The dialog of numbers: the run on screen and each pinned one, every number a way to its increment.

import { by, make, makeButton } from "../dom.js"
import { MEASURES, measured } from "./measures.js"
import { load, onPins, pins, swatch, titleOf } from "./pins.js"
import { goto } from "../player.js"
import { me } from "../state.js"

function row(name, mark, run, leadTo) {
  const heading = make("th", { scope: "row" }, ...(mark ? [mark, " "] : []), name)
  const found = run ? measured(run) : {}
  const cells = Object.keys(MEASURES).map((measure) => {
    const { text = "…", why = "", k } = found[measure] ?? {}
    const said = `${name}, ${MEASURES[measure][0]}: ${text} ${MEASURES[measure][1]}${why && `; ${why}`}`
    const onclick = () => { by("numbers").close(); leadTo(k) }
    return make("td", {}, makeButton({ title: why, disabled: k === undefined, "aria-label": said, data: { measure }, onclick }, text))
  })
  return make("tr", {}, heading, ...cells)
}

function fill() {
  const head = make("tr", {}, make("th", { scope: "col" }, "run"),
    ...Object.values(MEASURES).map(([text, unit, title]) => make("th", { scope: "col", title }, text, make("small", {}, unit))))
  const rows = pins.map((pin) => row(titleOf(pin), swatch(pin.slot), pin.run, (k) => load(pin, k)))
  const own = row("on screen", null, me.run, goto)
  by("numbers-table").replaceChildren(make("thead", {}, head), make("tbody", {}, own, ...rows))
}

onPins(() => { if (by("numbers").open) fill() })

export function open() {
  fill()
  by("numbers").showModal()
}
