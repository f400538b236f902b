// The browser's half of the app. The page imports this file alone and calls `start`.

import * as channel from "./channel.js"
import { change, charts, makeCharts } from "./charts.js"
import { connectCurves } from "./curves.js"
import { by, root } from "./dom.js"
import * as draw from "./draw.js"
import { connectChart } from "./hover.js"
import * as inputs from "./inputs.js"
import { opened } from "./opening.js"
import { unpackLater } from "./packed.js"
import * as player from "./player.js"
import { skeletonLater } from "./skeleton.js"
import { place } from "./sliders.js"
import * as status from "./status.js"
import { declared, me, redraw, view } from "./store.js"

export const again = redraw // everything, in other colours

// What the server declares: looks {preset: text}, usual {preset: values}, nodes {state: how it is drawn}, positions
// {slider: values} and reach (of server_log.py)
export function start() {
  Object.assign(declared, JSON.parse(by("declarations").textContent))
  makeCharts(declared.nodes)
  connectCurves()
  for (const name in charts) connectChart(name)
  inputs.connect()
  view(["look"], change)
  view(["pointed"], () => {
    for (const name in charts) charts[name].point(me.pointed?.name === name ? me.pointed : null)
  })
  status.connect()
  player.connect()
  draw.connect()
  channel.take("run", player.receive, unpackLater)
  channel.take("skeleton", player.follow, skeletonLater)
  channel.take("status", (news) => {
    arrive()
    status.heard(news)
  })
  for (const name in declared.positions) place(name, Number(by(`${name}-entry`).value))
  me.speed = Number(by("speed").value)
  document.addEventListener("stage", ({ detail }) => connect(detail))
  plugIn(declared.features)
}

// Connect features in their order; the page goes on without one that fails
async function plugIn(names) {
  const importing = names.map((name) => import(name).catch(reportError))
  for (const feature of importing) {
    try {
      (await feature)?.connect()
    } catch (error) {
      reportError(error)
    }
  }
}

// The Stage (app/stage.py) is there: the websocket of a page is open; in a layout a status tells that somebody answers.
// Panel may render it again, which ends its watchers
export function connect(model) {
  channel.connect(model)
  if (!("placed" in root.dataset)) arrive()
}

let there = false
function arrive() {
  if (there) return
  there = true
  opened()
}
