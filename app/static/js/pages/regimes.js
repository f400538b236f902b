// The page "Map": what it is over and of; a click loads that scene.

import { onEvent } from "../bokeh.js"
import { ask } from "../channel.js"
import { by, on } from "../dom.js"
import { figures } from "../figures.js"
import { leaveBehind } from "../state.js"

export function connect() {
  on("regimes-cancel", "click", () => ask({ what: "cancel" }))
  on("regimes-of", "change", () => ask({ what: "of", of: by("regimes-of").value }))
  for (const side of ["x", "y"]) on(`regimes-${side}`, "change", () => ask({ what: "axes", x: by("regimes-x").value, y: by("regimes-y").value }))
}

export const told = (news) => { by("regimes-cancel").hidden = (news.busy ?? null) === null }

export function opened() {
  onEvent(figures.regimes_map, "tap", ({ x, y }) => {
    leaveBehind(false)
    ask({ what: "go", i: x, j: y })
  })
}
