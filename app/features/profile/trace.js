// The profile in a file as measured, and what the server asks about it: the unit where none is named, the part of a
// long trace, and a filter for steep places. Loaded with the first file.

import { order, take } from "../../static/js/channel.js"
import { by, make, makeShape, on, one, say } from "../../static/js/dom.js"
import { me } from "../../static/js/store.js"

const UNITS = { nm: 1, "µm": 1e3, mm: 1e6 } // {name: nm}
const LONG = 20e3, PART = 2e3 // nm: of a longer trace the middle part
const WIDE = 300, HIGH = 80 // of the drawing
let content = null, trace = null, fresh = true // fresh: nothing is chosen of this file yet

export function read(given) {
  if (!content) connect()
  content = given
  fresh = true
  send({})
}

const send = (chosen) => order("profile", { content, ...chosen })

const unit = () => (trace.named ? 1 : UNITS[one("#trace-units :checked").value])
const place = (id) => (by(id).value / 1000) * trace.length * unit() // nm
// From the shortest wavelength that points resolve to half of the trace, as a logarithm; 0 at the left end is none
const cutOff = () => {
  const at = by("trace-smooth").value / 100, least = (2 * trace.length * unit()) / (trace.points - 1)
  return at > 0 ? Number((least * ((place("trace-end") - place("trace-begin")) / (2 * least)) ** at).toPrecision(3)) : 0
}
const inLength = (nm) => {
  const [name, factor] = Object.entries(UNITS).findLast(([, size]) => nm >= size) ?? ["nm", 1]
  return `${Number((nm / factor).toPrecision(3))} ${name}`
}

function ask(given, why) {
  trace = given
  by("trace").hidden = !trace
  say("profile-error", why ? `${why} The run on screen stays.` : "")
  if (!trace) return
  by("trace-units").replaceChildren(...(trace.named ? [] : Object.keys(UNITS).map(choice)))
  const middle = unit() * trace.length > LONG ? (500 * PART) / (unit() * trace.length) : 500
  const start = { "trace-begin": 500 - middle, "trace-end": 500 + middle, "trace-smooth": 0 }
  if (fresh) for (const [id, value] of Object.entries(start)) by(id).value = value
  fresh = false
  if (trace.cut_off) smooth(trace.cut_off)
  tell()
  by("trace-use").focus()
}

// The two readings side by side: what each unit would mean
function choice(name, k) {
  const { length, height } = trace, nm = UNITS[name]
  const radio = make("input", { type: "radio", name: "trace-unit", value: name, checked: k === 0 })
  return make("label", {}, radio, ` ${name}: ${inLength(length * nm)} long, ${inLength(height * nm)} high`)
}

function smooth(nm) {
  const least = (2 * trace.length * unit()) / (trace.points - 1), most = (place("trace-end") - place("trace-begin")) / 2
  by("trace-smooth").value = Math.ceil((100 * Math.log(nm / least)) / Math.log(most / least))
}

function tell() {
  const begin = place("trace-begin"), end = place("trace-end"), size = end - begin
  const nodes = Number(me.status.values.nodes) // of the scene on screen, which takes the profile
  const filter = cutOff() ? `, waves shorter than ${inLength(cutOff())} removed` : ""
  const asks = trace.named ? "" : "The file names no unit. Choose the one that is right: "
  say("trace-says", `${asks}${inLength(size)} of ${inLength(trace.length * unit())}, `
    + `${inLength(trace.height * unit())} high${filter}. ${nodes.toLocaleString("en")} nodes lie `
    + `${inLength(size / nodes)} apart: the lattice period.`)
  by("trace-use").disabled = size <= 0
  const across = (x) => (WIDE * x) / trace.length, up = (z) => HIGH * (0.95 - (0.9 * z) / (trace.height || 1))
  const line = trace.x.map((x, k) => `${across(x).toFixed(1)},${up(trace.z[k]).toFixed(1)}`).join(" ")
  const width = Math.max(0, across(size / unit()))
  const part = { x: across(begin / unit()), width, y: 0, height: HIGH, class: "part" }
  by("trace").querySelector("svg").replaceChildren(
    makeShape("rect", part), makeShape("polyline", { points: line, "vector-effect": "non-scaling-stroke" }))
}

function connect() {
  on("trace", "input", tell)
  on("trace-use", "click", () => {
    const begin = place("trace-begin"), end = place("trace-end"), whole = begin <= 0 && end >= trace.length * unit()
    const named = trace.named ? {} : { unit: one("#trace-units :checked").value }
    send({ sure: true, ...named, ...(whole ? {} : { begin, end }), ...(cutOff() ? { cut_off: cutOff() } : {}) })
  })
  take("trace", ({ trace: given, why }) => ask(given, why))
}
