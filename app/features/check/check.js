// ?check: whether this device and the way to the server do what the page needs, in words that can be photographed. That
// its scripts run is the first line: page and server write that they do not.

import { charts } from "../../static/js/charts.js"
import { by, make, tell } from "../../static/js/dom.js"
import { opensElsewhere, originForOthers } from "../../static/js/reach.js"
import { enter } from "../../static/js/steer.js"
import { declared, me } from "../../static/js/store.js"

const PATIENCE = 30_000 // ms until what has not come is missing: a cold server compiles its kernels first
const LOOK = 500 // ms between two looks
const SMALLEST = [320, 360] // px of a window in which all parts have room
const SIZE = 100 // px of the copy of the picture that is read

// Whether anything is painted
function painted() {
  const copy = make("canvas", { width: SIZE, height: SIZE }), pen = copy.getContext("2d", { willReadFrequently: true })
  if (!charts.punch.canvas.width || me.drawn < 0) return false
  pen.drawImage(charts.punch.canvas, 0, 0, SIZE, SIZE)
  return pen.getImageData(0, 0, SIZE, SIZE).data.some((value, i, data) => value !== data[i % 4])
}

// Of a scene that no visitor has asked for, so that a worker computes it
const computed = () => me.status.state === "finished" && me.run?.whole && !me.run.stored && me.status.known === false
const size = () => `${innerWidth} × ${innerHeight} px`
const command = () => declared.reach.commands[0]?.[1] ?? "the command in docs/serve.md"

// {what: [whether it is right, what is seen, what is wrong and what to do]}
const TESTS = {
  Script: [() => true, () => "the scripts of the page run.", () => ""],
  Socket: [() => Boolean(me.status.state), () => "the server sends messages.",
    () => "no message after 30 s. Proxies and filters between here and the server must pass WebSockets."],
  Worker: [computed, () => `${me.status.evaluations} force evaluations in ${me.status.seconds} s.`,
    () => `no result after 30 s; state: ${me.status.state ?? "none"}. See the server's log, and its page /liveness.`],
  Picture: [painted, () => "the picture is drawn.",
    () => "the picture is empty. Update the browser, or allow the page to read canvases."],
  Screen: [() => innerWidth >= SMALLEST[0] && innerHeight >= SMALLEST[1],
    () => `${size()}, pixel ratio ${devicePixelRatio}.`,
    () => `${size()}; needed: ${SMALLEST.join(" × ")}. Enlarge the window, or zoom out.`],
  Address: [opensElsewhere, () => `other devices open ${originForOthers()}.`,
    () => `only this computer opens ${location.origin}. For a class: ${command()}`],
}
const AT_ONCE = ["Screen", "Address"] // no time changes them

const rows = {}
let begun = 0 // ms
function look() {
  const late = performance.now() - begun > PATIENCE
  for (const [what, [right, seen, wrong]] of Object.entries(TESTS)) {
    const sign = right() ? "✓" : late || AT_ONCE.includes(what) ? "✗" : "…"
    rows[what].dataset.sign = sign
    tell(rows[what], `${sign} ${what}: ${{ "✓": seen, "✗": wrong, "…": () => "waiting" }[sign]()}`)
  }
  if (!late && Object.values(rows).some(({ dataset }) => dataset.sign === "…")) setTimeout(look, LOOK)
}

export function check() {
  begun = performance.now()
  for (const what in TESTS) rows[what] = make("li")
  by("check").querySelector("ul").replaceChildren(...Object.values(rows))
  enter({ E: (70 + Math.random()).toFixed(6) })
  look()
}
