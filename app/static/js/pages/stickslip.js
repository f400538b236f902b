// The page "Stick-slip": a click on the map of regimes loads that scene.

import { onEvent } from "../bokeh.js"
import { ask } from "../channel.js"
import { by, on } from "../dom.js"
import { figures } from "../figures.js"
import { leaveBehind } from "../state.js"

export const connect = () => on("stickslip-cancel", "click", () => ask({ what: "cancel" }))

export const told = (news) => { by("stickslip-cancel").hidden = (news.busy ?? null) === null }

export function opened() {
  onEvent(figures.stickslip_map, "tap", ({ x, y }) => {
    leaveBehind(false)
    ask({ E: 10 ** x, phi_t: 10 ** y })
  })
}
