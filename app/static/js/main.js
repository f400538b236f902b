// The browser's half of the app. The server's page imports this file alone and calls `start` with the models.

import * as address from "./address.js"
import { onChange, plain, useIndex } from "./bokeh.js"
import * as channel from "./channel.js"
import * as connection from "./connection.js"
import { by } from "./dom.js"
import * as draw from "./draw.js"
import { adopt, paint } from "./figures.js"
import { connectFringes } from "./fringes.js"
import * as inputs from "./inputs.js"
import { connectInside } from "./inside.js"
import { connectLens } from "./lens.js"
import { opened } from "./opening.js"
import { inflateLater, unpackLater } from "./packed.js"
import * as pages from "./pages.js"
import * as player from "./player.js"
import { place } from "./sliders.js"
import { connectSlips } from "./slips.js"
import * as status from "./status.js"
import { declared, embedded, me, redraw, redrawCanvases, view } from "./store.js"
import { connectTheory } from "./theory.js"

// wire: the Wire of this visitor; figures: {name: figure}; slots: {name: Column} for the figures of pages;
// declarations: JSON of looks {preset: text}, usual {preset: values}, nodes {state: how it is drawn}, positions
// {slider: values} and reach (of server_log.py); index: Bokeh's index of views
export function start({ wire, figures, slots, declarations, index }) {
  Object.assign(declared, JSON.parse(declarations))
  useIndex(index)
  figures = plain(figures)
  for (const name in figures) adopt(name, figures[name])
  channel.connect(wire)
  address.connect()
  inputs.connect()
  connectLens()
  connectFringes()
  connectInside()
  view(["look"], paint)
  status.connect()
  player.connect()
  draw.connect()
  pages.connect(plain(slots)) // their figures are painted with the same picture
  connectSlips()
  connectTheory()
  channel.take("run", player.receive, unpackLater)
  channel.take("picture", player.follow, inflateLater)
  channel.take("status", status.heard)
  channel.take("page", pages.receive, pages.read)
  player.connectStored()
  let resized = 0 // what rests is drawn anew, in the size of the text there, once a change of size has come to its end
  new ResizeObserver(() => {
    clearTimeout(resized)
    resized = setTimeout(redraw, 100)
  }).observe(document.querySelector("figure"))
  // and what lies over the punch, once Bokeh has its new size, which takes longer on a busy machine
  for (const size of ["inner_width", "inner_height"]) onChange(figures.punch, size, redrawCanvases)
  for (const name in declared.positions) place(name, Number(by(`${name}-entry`).value))
  connection.restore()
  me.speed = Number(by("speed").value)
  connection.connect()
  opened()
  channel.order("hello")
  if (!embedded) pages.openAsked()
  let kept = false // Share opens without the server, too, so that it comes while that is there
  view(["status"], () => {
    if (kept || me.status.state !== "finished") return
    kept = true
    import("./share.js")
  })
  const stop = Number(new URLSearchParams(location.search).get("tour"))
  if (stop) import("./tour.js").then(({ openTour }) => openTour(stop))
}
