// The page "Map of regimes": its axes and its quantity; a click goes to that scene, and a drag through all between.

import { drawnBy, onEvent, set } from "../../static/js/bokeh.js"
import { ask } from "../../static/js/channel.js"
import { by, on } from "../../static/js/dom.js"
import { figures, parts } from "../../static/js/figures.js"
import { digits, minus } from "../../static/js/quantities.js"
import { letGo, steer } from "../../static/js/steer.js"

const DIGITS = 4 // of a value
const NAMED = 420 // px, from which on the names of regimes stand beside each other
const HINT = "Point at the map to read it; click or drag to go there."

let axes = [], regimes = [] // {name, values} across and upwards; of each place, row by row, what it is called
let unit = "", pointed = null // of the quantity; {x, y} under the pointer

export function connect() {
  on("regimes-of", "change", () => ask({ what: "of", of: by("regimes-of").value }))
  const sides = [by("regimes-x"), by("regimes-y")], now = sides.map((side) => side.value)
  sides.forEach((side, i) => side.addEventListener("change", () => {
    if (side.value === sides[1 - i].value) sides[1 - i].value = now[i] // the axes change places
    sides.forEach((each, k) => { now[k] = each.value })
    ask({ what: "axes", x: now[0], y: now[1] })
  }))
}

export function receive(news) {
  axes = news.axes ?? []
  regimes = news.codes?.map((code) => news.names.at(code)) ?? []
  unit = news.unit ?? ""
  set(parts.regimes_map.names, { visible: figures.regimes_map.inner_width > NAMED })
  readOut()
}

export function opened() {
  pointed = null
  const drags = matchMedia("(pointer: coarse)").matches ? [] : ["pan"] // a finger that moves scrolls the page
  for (const name of ["tap", ...drags]) onEvent(figures.regimes_map, name, ({ x, y }) => steer(valuesAt([x, y])))
  for (const name of ["tap", "panend"]) onEvent(figures.regimes_map, name, letGo)
  onEvent(figures.regimes_map, "mousemove", ({ x, y }) => { pointed = { x, y }; readOut() })
  onEvent(figures.regimes_map, "mouseleave", () => { pointed = null; readOut() })
}

const readOut = () => { by("regimes-at").textContent = (pointed && read(pointed)) || HINT }

const labelOf = (name) => by("regimes-x").querySelector(`[value="${name}"]`).textContent

// What the map shows at a place
function read({ x, y }) {
  const { image, rows, columns } = drawnBy(parts.regimes_map.map), i = Math.round(x), j = Math.round(y)
  const regime = regimes[j * columns + i]
  if (regime === undefined || i < 0 || i >= columns || j < 0 || j >= rows) return ""
  const named = Object.entries(valuesAt([i, j])).map(([name, value]) => `${labelOf(name)} ${minus(value)}`)
  const value = image[j * columns + i], what = by("regimes-of").selectedOptions[0].textContent
  const texts = [regime, Number.isFinite(value) && `${what} ${digits(value)} ${unit}`]
  return `${named.join(", ")}: ${texts.filter(Boolean).join(", ")}`
}

// {parameter: text} at a place of the map, in columns and rows
function valuesAt(place) {
  return Object.fromEntries(axes.map(({ name, values }, side) => {
    const at = Math.min(Math.max(place[side], 0), values.length - 1), k = Math.min(Math.floor(at), values.length - 2)
    const value = values[k] + (at - k) * (values[k + 1] - values[k])
    return [name, `${Number(value.toPrecision(DIGITS))}`]
  }))
}
