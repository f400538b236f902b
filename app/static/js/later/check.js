// ?check: whether this device and the way to the server do what the page needs, in words that can be photographed.

import { opensElsewhere } from "../address.js"
import { charts } from "../charts.js"
import { by, make } from "../dom.js"
import { declared, me } from "../store.js"

const PATIENCE = 30_000 // ms until what has not come is missing: a cold server compiles its kernels first
const LOOK = 500 // ms between two looks
const SMALLEST = [320, 360] // px of a window in which all parts have room

// Whether anything is painted
function painted() {
  const { canvas } = charts.punch
  if (!canvas.width || me.drawn < 0) return false
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height)
  return data.some((value, i) => value !== data[i % 4])
}
function forClass() {
  const [[, command] = []] = declared.reach.commands
  return command ? `For a class: ${command}` : ""
}
const computed = () => me.status.state === "finished" && me.run?.whole && !me.run.stored

// {what: [whether it is right, what is seen, what is wrong and what to do]}
const TESTS = {
  Script: [() => true, () => "the scripts of the page run.", () => ""],
  Socket: [() => Boolean(me.status.state), () => "the server sends messages.",
    () => "no message has come. Proxies and filters between here and the server must pass WebSockets."],
  Worker: [computed, () => `${me.status.evaluations} force evaluations in ${me.status.seconds} s.`,
    () => `no run has come, but “${me.status.state ?? "nothing"}”. See the server's log, and its page /liveness.`],
  Picture: [painted, () => `${charts.punch.canvas.width} × ${charts.punch.canvas.height} points are painted.`,
    () => "the picture is empty. Update the browser; switch off what forbids it to read canvases."],
  Screen: [() => innerWidth >= SMALLEST[0] && innerHeight >= SMALLEST[1],
    () => `${innerWidth} × ${innerHeight} px, ${devicePixelRatio} points each.`,
    () => `${innerWidth} × ${innerHeight} px; needed: ${SMALLEST.join(" × ")}. Enlarge the window, or zoom out.`],
  Address: [opensElsewhere, () => `${location.origin} opens on other devices, too.`,
    () => `only this computer opens ${location.origin}. ${forClass()}`],
}

const begun = performance.now()
function look() {
  const late = performance.now() - begun > PATIENCE
  const rows = Object.entries(TESTS).map(([what, [right, seen, wrong]]) => {
    const ok = right(), sign = ok ? "✓" : late || what === "Screen" || what === "Address" ? "✗" : "…"
    return make("li", { data: { sign } }, make("b", {}, `${sign} ${what}: `), ok ? seen() : sign === "✗" ? wrong() : "")
  })
  by("check").querySelector("ul").replaceChildren(...rows)
  if (!late && rows.some(({ dataset }) => dataset.sign === "…")) setTimeout(look, LOOK)
}
look()
