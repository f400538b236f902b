// The page "Map of regimes": its axes and its quantity; a click goes to that scene, and a drag through all between.

import { valueAt } from "../../static/js/chart.js"
import { addChart, charts, line, none } from "../../static/js/charts.js"
import { levels, pictureOf } from "../../static/js/colours.js"
import { by, on, onDrag } from "../../static/js/dom.js"
import { inks, write } from "../../static/js/pen.js"
import { digits, minus } from "../../static/js/quantities.js"
import { letGo, steer } from "../../static/js/steer.js"
import { ask } from "../pages/index.js"

const DIGITS = 4 // of a value
const NAMED = 420 // px, from which on the names of regimes stand beside each other

let map = null // of the server, see page.py; a place is in columns and rows

const sides = () => [by("regimes-x"), by("regimes-y")]
let shown = [] // parameters of the axes

export function connect() {
  on("regimes-of", "change", () => ask({ what: "of", of: by("regimes-of").value }))
  sides().forEach((side, i, both) => side.addEventListener("change", () => {
    if (side.value === both[1 - i].value) both[1 - i].value = shown[i] // the axes change places
    shown = both.map(({ value }) => value)
    ask({ what: "axes", x: shown[0], y: shown[1] })
  }))
  addChart("regimes_map", { x: { start: 0, end: 1 }, y: { start: 0, end: 1 }, across: "", up: "", parts: {
    map: { kind: "image", picture: null }, outline: line("--cut", { width: 3 }),
    names: { kind: "drawing", draw: drawNames },
    own: { kind: "marks", marker: "diamond", size: 14, ink: "--cut", ...none },
  } })
  charts.regimes_map.says = says
  connectMouse(charts.regimes_map.view)
}

// A mouse drags; a finger that moves scrolls the page, and taps
function connectMouse(view) {
  const chart = charts.regimes_map
  const placeOf = ({ offsetX: x, offsetY: y }) => chart.placeOf({ x, y })
  const within = ({ x, y }) => x >= chart.x.start && x <= chart.x.end && y >= chart.y.start && y <= chart.y.end
  let dragged = false
  onDrag(view, (event) => {
    dragged = event.pointerType !== "touch" && event.button === 0 && map !== null && within(placeOf(event))
    if (!dragged) return false
    view.setPointerCapture(event.pointerId)
    steer(valuesAt(placeOf(event)))
    return true
  }, (event) => steer(valuesAt(placeOf(event))), letGo)
  view.addEventListener("click", (event) => {
    if (dragged || map === null || !within(placeOf(event))) return
    steer(valuesAt(placeOf(event)))
    letGo()
  })
}

export function receive(news) {
  if (!map && news.map) choose(news.map)
  map = news.map ? unpacked(news.map) : null
  if (map) draw()
  else for (const part of ["map", "outline"]) charts.regimes_map.fill(part, { ...none, picture: null })
  const [i, j] = news.own ?? []
  charts.regimes_map.fill("own", map && news.own ? { x: [i], y: [j] } : none)
}

// See `_map` of page.py
const unpacked = ({ values, codes, outline, ...others }) => ({
  ...others, values: new Float32Array(values), codes: new Int8Array(codes),
  outline: Array.from(new Int16Array(outline), (half) => half / 2),
})

// The choices are those of a page that has just been opened
function choose({ axes, of: [of] }) {
  shown = axes.map(({ name }) => name)
  sides().forEach((side, i) => { side.value = shown[i] })
  by("regimes-of").value = of
}

function draw() {
  const chart = charts.regimes_map, [x, y] = map.axes, columns = x.values.length, rows = y.values.length
  const { values, outline } = map
  chart.range("x", { start: -0.5, end: columns - 0.5, ticks: x.ticks })
  chart.range("y", { start: -0.5, end: rows - 0.5, ticks: y.ticks })
  chart.across = x.label
  chart.up = y.label
  const picture = pictureOf(values, [rows, columns], levels(...map.limits))
  chart.fill("map", { picture, values, rows, columns, x: -0.5, y: -0.5, wide: columns, high: rows })
  const starts = [...outline.keys()].filter((k) => k % 4 === 0)
  const ends = (side) => starts.flatMap((k) => [outline[k + side], outline[k + side + 2], NaN])
  chart.fill("outline", { x: ends(0), y: ends(1) })
}

function drawNames(pen, box) {
  if (box.width < NAMED) return
  for (const [i, j, name] of map?.names ?? []) write({ pen, box, ink: inks() }, name, box.X(i), box.Y(j))
}

// What the map shows at a place
function says(place) {
  const x = Math.round(place.x), y = Math.round(place.y)
  if (map === null || !(x in map.axes[0].values && y in map.axes[1].values)) return null
  const at = valuesAt({ x, y }), value = valueAt(charts.regimes_map.parts.map, { x, y }), [, what, unit] = map.of
  const regime = map.kinds[map.codes[y * map.axes[0].values.length + x]]
  return [...map.axes.map(({ name, label }) => `${label}: ${minus(at[name])}`),
    ...(regime ? [regime] : []), ...(Number.isFinite(value) ? [`${what}: ${digits(value)} ${unit}`] : [])]
}

// {parameter: text} at a place of the map
function valuesAt(place) {
  const at = [place.x, place.y]
  return Object.fromEntries(map.axes.map(({ name, values }, side) => {
    const to = Math.min(Math.max(at[side], 0), values.length - 1), k = Math.min(Math.floor(to), values.length - 2)
    const value = values[k] + (to - k) * (values[k + 1] - values[k])
    return [name, `${Number(value.toPrecision(DIGITS))}`]
  }))
}
