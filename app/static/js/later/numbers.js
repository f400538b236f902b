// Runs in numbers, from their frames: a dialog with the run on screen and each pinned one, every number a way to its increment.

import { by, fixed, make, makeButton } from "../dom.js"
import { load, onPins, pins, swatch, titleOf } from "./pins.js"
import { goto } from "../player.js"
import { me } from "../state.js"
import { inWords } from "../words.js"

const NONE = "–"
const MEASURES = { // measure: [heading, unit, what it is]
  regime: ["regime", "", "what the contact does while sheared"],
  slips: ["slips", "", "ends of branches after the approach"],
  U_s: ["Uₛ", "nm", "displacement of the top at the first slip"],
  F_s: ["Fₛ", "N/m", "friction just before the first slip"],
  A_s: ["Aₛ", "nm", "repulsive width just before the first slip"],
  tau_c: ["Fₛ/Aₛ", "GPa", "mean shear stress just before the first slip; the slope of Fₛ over Aₛ takes several loads: page Area laws"],
  mean: ["mean F", "N/m", "mean of largest and least friction while sliding, Eq. 7"],
  peeling: ["peeling", "sites", "inward, of the trailing | leading edge, and how one-sided"],
  dissipated: ["dissipated", "nJ/m", "work of the top over a closed cycle"],
}
const number = (value, digits = 4) => fixed(value, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.max(Math.abs(value), 1e-9)))))
const bar = (name, value) => `${name} = ${(value * 1000).toPrecision(5)}·10⁻³`
const some = (text, k, why = "") => ({ text, why, k })
const none = (why, k) => some(NONE, k, why)

// {measure: {text, why, k}} with the increment k that it is taken from
function measured(run) {
  const { curves, head, sheared } = run
  if (sheared < 0) return Object.fromEntries(Object.keys(MEASURES).map((name) => [name, none("not yet sheared", 0)]))
  const found = {}, shear = head.stages.indexOf("shear"), width = 2 * head.middle
  const inShear = curves.stage.flatMap((stage, k) => (stage === shear ? [k] : [])), end = inShear.at(-1) ?? run.length - 1
  const first = inShear.find((k) => k > sheared && curves.slip[k] > 0) // not the jump where a held load takes over
  const before = first === undefined ? end : Math.max(first - 1, sheared)
  const slid = inShear.find((k) => run.least(k) >= head.spacing)
  const slips = curves.slip.slice(sheared), at = slips.findIndex(Boolean)
  found.slips = some(`${slips.reduce((sum, count) => sum + count, 0)}`, at < 0 ? end : sheared + at)
  if (first === undefined) for (const name of ["U_s", "F_s", "A_s", "tau_c"]) found[name] = none("no slip in shear", end)
  else {
    const F = curves.F_slip[first], A = curves.slip_A[first] * width
    found.U_s = some(number(curves.slip_at[first]), before)
    found.F_s = some(number(F), before, bar("F̄", curves.slip_F[first]))
    found.A_s = some(number(A), before, bar("Ā", curves.slip_A[first]))
    found.tau_c = A > 0 ? some(number(F / A, 3), before) : none("no repulsive contact at the slip", before)
  }
  const { changing } = run
  found.mean = !changing.length ? friction(run, inShear, first ?? slid)
    : none(`carried on with another ${changing.map(inWords).join(", ")}`, end)
  found.peeling = peeled(run, before)
  found.dissipated = run.dissipated === null ? none("no closed cycle: path loop has one", end) : some(number(run.dissipated), run.length - 1)
  found.regime = some(regime(run, inShear, first, slid), first ?? slid ?? sheared)
  return found
}

// Largest and least friction from the first slip on, or from where every node has moved by a period, over a period at least
function friction({ curves, head }, inShear, start) {
  const end = inShear.at(-1)
  if (start === undefined) return none("it has not slid", end ?? 0)
  const begun = curves.slip[start] ? curves.slip_at[start] : curves.U_x[start]
  if (curves.U_x[end] - begun < head.spacing * (1 - 1e-6)) return none("it slid by less than a lattice period: enlarge u_x_max", end)
  const forces = inShear.filter((k) => k >= start).flatMap((k) => (curves.slip[k] ? [[curves.F_slip[k], k - 1], [curves.F[k], k]] : [[curves.F[k], k]]))
  const most = forces.reduce((a, b) => (b[0] > a[0] ? b : a)), least = forces.reduce((a, b) => (b[0] < a[0] ? b : a))
  return { text: number(0.5 * (most[0] + least[0])), why: `largest ${number(most[0])}, least ${number(least[0])} N/m`, k: most[1] }
}

function peeled(run, before) {
  if (run.head.scene.surface !== "circular") return none("for a single patch of contact: surface circular", before)
  const then = run.edges(run.sheared)
  let k = before
  while (k > run.sheared && !run.edges(k)) k-- // the last increment in contact
  const now = run.edges(k)
  if (!then || !now || k === run.sheared) return none("no repulsive contact", run.sheared)
  const trailing = now[0] - then[0], leading = then[1] - now[1], all = Math.abs(trailing) + Math.abs(leading)
  const one = all < 0.05 ? NONE : fixed((trailing - leading) / all, 2)
  return { text: `${fixed(trailing, 1)} | ${fixed(leading, 1)}, ${one}`, why: "1: the trailing edge alone; 0: both alike", k }
}

function regime(run, inShear, first, slid) {
  if (!inShear.length) return "pressed and retracted"
  if (inShear.every((k) => Math.abs(run.curves.F_bar[k]) + Math.abs(run.curves.L_bar[k]) < 1e-12)) return "no contact"
  return first !== undefined ? "stick-slip" : slid !== undefined ? "continuous sliding" : "sticks"
}

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
