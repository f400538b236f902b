// The page "Stick-slip": a click on the map of regimes loads that scene.

import { onEvent } from "../bokeh.js"
import { ask } from "../channel.js"
import { figures } from "../figures.js"
import { leaveBehind } from "../state.js"

export function opened() {
  onEvent(figures.stickslip_map, "tap", ({ x, y }) => {
    leaveBehind(false)
    ask({ E: 10 ** x, phi_t: 10 ** y })
  })
}
