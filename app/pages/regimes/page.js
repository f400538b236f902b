// The page "Map": what it is over and of; a click goes to that scene, and a drag through all between.

import { drawnBy, onEvent } from "../../static/js/bokeh.js"
import { ask } from "../../static/js/channel.js"
import { by, digits, minus, on } from "../../static/js/dom.js"
import { figures, parts } from "../../static/js/figures.js"
import { letGo, steer } from "../../static/js/steer.js"

const DIGITS = 4 // of a value

let axes = [], regimes = [] // {name, values} across and upwards; of each place, row by row, what it is called

export function connect() {
  on("regimes-of", "change", () => ask({ what: "of", of: by("regimes-of").value }))
  for (const side of ["x", "y"]) on(`regimes-${side}`, "change", () => ask({ what: "axes", x: by("regimes-x").value, y: by("regimes-y").value }))
}

export function told(news) {
  axes = news.axes ?? []
  regimes = news.codes?.map((code) => news.names.at(code)) ?? []
}

export function opened() {
  for (const name of ["tap", "pan"]) onEvent(figures.regimes_map, name, ({ x, y }) => steer(valuesAt([x, y])))
  for (const name of ["tap", "panend"]) onEvent(figures.regimes_map, name, letGo)
  onEvent(figures.regimes_map, "mousemove", ({ x, y }) => { by("regimes-at").textContent = read(x, y) })
  onEvent(figures.regimes_map, "mouseleave", () => { by("regimes-at").textContent = "" })
}

// What the map says at a place
function read(x, y) {
  const { image, rows, columns } = drawnBy(parts.regimes_map.map), i = Math.round(x), j = Math.round(y)
  const regime = regimes[j * columns + i]
  if (regime === undefined || i < 0 || i >= columns || j < 0 || j >= rows) return ""
  const named = Object.entries(valuesAt([i, j])).map(([name, value]) => `${by("regimes-x").querySelector(`[value="${name}"]`).textContent} ${minus(value)}`)
  const value = image[j * columns + i], [, unit] = by("regimes-high").textContent.split(" ")
  const what = by("regimes-of").selectedOptions[0].textContent
  const said = [regime, Number.isFinite(value) && `${what} ${digits(value)} ${unit ?? ""}`]
  return `${named.join(", ")}: ${said.filter(Boolean).join(", ")}`
}

// {parameter: text} at a place of the map, in columns and rows
function valuesAt(place) {
  return Object.fromEntries(axes.map(({ name, values }, side) => {
    const at = Math.min(Math.max(place[side], 0), values.length - 1), k = Math.min(Math.floor(at), values.length - 2)
    const value = values[k] + (at - k) * (values[k + 1] - values[k])
    return [name, `${Number(value.toPrecision(DIGITS))}`]
  }))
}
