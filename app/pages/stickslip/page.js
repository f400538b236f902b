// The page "Stick-slip": a click on the map of regimes loads that scene.

import { onEvent } from "../../static/js/bokeh.js"
import { ask } from "../../static/js/channel.js"
import { figures } from "../../static/js/figures.js"
import { beginChange } from "../../static/js/store.js"

export function opened() {
  onEvent(figures.stickslip_map, "tap", ({ x, y }) => {
    beginChange(false)
    ask({ E: 10 ** x, phi_t: 10 ** y })
  })
}
