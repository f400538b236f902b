// The page "Map": what it is over and of; a click goes to that scene, and a drag through all between.

import { onEvent } from "../bokeh.js"
import { ask } from "../channel.js"
import { by, on } from "../dom.js"
import { figures } from "../figures.js"

const DIGITS = 4 // of a value

let axes = [] // {name, values} across and upwards

export function connect() {
  on("regimes-cancel", "click", () => ask({ what: "cancel" }))
  on("regimes-of", "change", () => ask({ what: "of", of: by("regimes-of").value }))
  for (const side of ["x", "y"]) on(`regimes-${side}`, "change", () => ask({ what: "axes", x: by("regimes-x").value, y: by("regimes-y").value }))
}

export function told(news) {
  by("regimes-cancel").hidden = (news.busy ?? null) === null
  axes = news.axes ?? []
}

export function opened() {
  const tell = (what, detail) => document.dispatchEvent(new CustomEvent(what, { detail }))
  for (const name of ["tap", "pan"]) onEvent(figures.regimes_map, name, ({ x, y }) => tell("steer", values([x, y])))
  for (const name of ["tap", "panend"]) onEvent(figures.regimes_map, name, () => tell("let-go"))
}

// {parameter: text} at a place of the map, in columns and rows
function values(place) {
  return Object.fromEntries(axes.map(({ name, values }, side) => {
    const at = Math.min(Math.max(place[side], 0), values.length - 1), k = Math.min(Math.floor(at), values.length - 2)
    const value = values[k] + (at - k) * (values[k + 1] - values[k])
    return [name, `${Number(value.toPrecision(DIGITS))}`]
  }))
}
