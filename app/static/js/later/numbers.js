// Runs in numbers, from their frames: a dialog with the run on screen and each pinned one, every number a way to its
// increment.

import { by, fixed, make, makeButton } from "../dom.js"
import { load, swatch, titleOf } from "./pins.js"
import { goto } from "../player.js"
import { firstSlip } from "../sentence.js"
import { me, view } from "../store.js"

const NONE = "–"
const MEASURES = { // measure: [heading, unit, what it is]
  slips: ["slips", "", "ends of branches after the approach"],
  U_s: ["Uₛ", "nm", "displacement at the first slip"],
  F_s: ["Fₛ", "N/m", "friction where the first slip begins"],
  A_s: ["Aₛ", "nm", "repulsive width where the first slip begins"],
  tau_c: ["Fₛ/Aₛ", "GPa",
    "mean shear stress where the first slip begins; the slope of Fₛ over Aₛ takes several loads: page Area laws"],
  dissipated: ["dissipated", "nJ/m", "work over a closed cycle"],
}
const number = (value, digits = 4) =>
  fixed(value, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.max(Math.abs(value), 1e-9)))))
const cell = (text, k, why = "") => ({ text, why, k })
const none = (why, k) => cell(NONE, k, why)

// {measure: {text, why, k}} with the increment k that it belongs to; events are where the solver located them
function measured(run) {
  if (run.sheared < 0)
    return Object.fromEntries(Object.keys(MEASURES).map((name) => [name, none("not yet sheared", 0)]))
  const slips = run.curves.slip.slice(run.sheared), any = slips.findIndex(Boolean), end = run.length - 1
  const count = cell(`${slips.reduce((sum, more) => sum + more, 0)}`, any < 0 ? end : run.sheared + any)
  const cycle = run.dissipated === null ? none("no closed cycle: use path=loop", end)
    : cell(number(run.dissipated), end)
  return { slips: count, ...atFirstSlip(run, end), dissipated: cycle }
}

function atFirstSlip(run, end) {
  const slip = firstSlip(run)
  if (!slip)
    return Object.fromEntries(["U_s", "F_s", "A_s", "tau_c"].map((name) => [name, none("no slip in shear", end)]))
  const { U, F, A } = slip, k = Math.max(slip.at - 1, run.sheared)
  const stress = A > 0 ? cell(number(F / A, 3), k) : none("no repulsive contact at the slip", k)
  return { U_s: cell(number(U), k), F_s: cell(number(F), k), A_s: cell(number(A), k), tau_c: stress }
}

function row(name, mark, run, leadTo) {
  const heading = make("th", { scope: "row" }, ...(mark ? [mark, " "] : []), name)
  const measures = run ? measured(run) : {}
  const cells = Object.keys(MEASURES).map((measure) => {
    const { text = "…", why = "", k } = measures[measure] ?? {}
    const label = `${name}, ${MEASURES[measure][0]}: ${text} ${MEASURES[measure][1]}${why && `; ${why}`}`
    const onclick = () => { by("numbers").close(); leadTo(k) }
    return make("td", {},
      makeButton({ title: why, disabled: k === undefined, "aria-label": label, data: { measure }, onclick }, text))
  })
  return make("tr", {}, heading, ...cells)
}

function fill() {
  const head = make("tr", {}, make("th", { scope: "col" }, "run"),
    ...Object.values(MEASURES).map(([text, unit, title]) =>
      make("th", { scope: "col", title }, text, make("small", {}, unit))))
  const rows = me.pins.map((pin) => row(titleOf(pin), swatch(pin.slot), pin.run, (k) => load(pin, k)))
  const own = row("on screen", null, me.run, goto)
  by("numbers-table").replaceChildren(make("thead", {}, head), make("tbody", {}, own, ...rows))
}

view(["pins", "run"], () => { if (by("numbers")?.open) fill() })

export function open() {
  fill()
  by("numbers").showModal()
}
