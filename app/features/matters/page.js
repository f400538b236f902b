// The page "What matters": a bar for each parameter, and below the punch how much each node holds until the first slip.

import { by, make, makeButton, on, one } from "../../static/js/dom.js"
import { inks } from "../../static/js/pen.js"
import { drawnFrame } from "../../static/js/punch.js"
import { minus } from "../../static/js/quantities.js"
import { enter } from "../../static/js/steer.js"
import { me, redrawPunch } from "../../static/js/store.js"
import { inWords } from "../../static/js/words.js"

const MORE = 1.05 // times the value, after a click
const HIGH = 26 // px, the mark of the node that holds most
const COLUMNS = { U_s: 0, F_s: 1, A_s: 2 }

let result = null // {values: {parameter: now}, bars: {parameter: [U_s, F_s, A_s]}, first, nodes: shares of F_s}

export const connect = () => on("matters-of", "input", drawBars)

export function receive({ matters }) {
  if (matters === result) return
  result = matters ?? null
  drawBars()
  redrawPunch()
}

const signed = (value) => `${value < 0 ? "−" : "+"}${Math.abs(value) < 0.005 ? "0" : Math.abs(value).toFixed(2)} %`

function drawBars() {
  const column = COLUMNS[one("#matters-of :checked").value]
  const known = Object.entries(result?.bars ?? {})
    .map(([name, all]) => [name, all[column]]).filter(([, value]) => value !== null)
  const [rows, zero] = [true, false].map((some) => known.filter(([name]) => (result.values[name] !== 0) === some))
  by("matters-zero").textContent = zero.map(([name, value]) =>
    `${inWords(name)} is 0, so that it has no per cent: 0.01 more change the first slip by ${signed(value)}.`).join(" ")
  rows.sort(([, a], [, b]) => Math.abs(b) - Math.abs(a))
  const most = Math.max(...rows.map(([, value]) => Math.abs(value)), 1e-9)
  by("matters-bars").replaceChildren(...rows.map(([name, value]) => {
    const bar = make("i", { className: value < 0 ? "less" : "more" })
    bar.style.setProperty("--part", Math.abs(value) / most)
    const title = `now ${minus(result.values[name])}; click for five per cent more`
    const parts = [make("span", {}, inWords(name)), bar, make("b", {}, signed(value))]
    return makeButton({ title, onclick: () => raise(name) }, ...parts)
  }))
}

function raise(name) {
  const now = Number(me.status.values[name]), wanted = now + Math.abs(now) * (MORE - 1)
  enter({ [name]: `${Number(wanted.toPrecision(5))}` })
}

// Below the punch, with every frame: how much each node holds
export function over(pen, box, run, k) {
  if (!result || run.head.flat) return
  const { drawn: x } = drawnFrame(run, k), { first } = run.headOf(k), { nodes } = result, ink = inks()
  const most = Math.max(...nodes.map(Math.abs), 1e-12), wide = Math.max(2, 0.7 * box.across * run.head.spacing)
  x.forEach((at, i) => {
    const share = nodes[first + i - result.first] ?? 0, high = (Math.abs(share) / most) * HIGH
    if (high < 0.5) return
    pen.fillStyle = share > 0 ? ink.shear : ink.slip
    pen.fillRect(box.X(at) - wide / 2, box.Y(0) + 3, wide, high)
  })
}
