// The tour: its button, and the stop that an address names. Loaded when it is asked for.

import { fetched, on } from "../../static/js/dom.js"
import { declare } from "../../static/js/store.js"

export function connect() {
  declare({ tour: "" }) // what its card does: "wait" until the scene is there, "turn", "show", "ask", "why"
  const stop = Number(new URLSearchParams(location.search).get("tour"))
  if (stop) open(stop)
  on("tour", "click", () => open())
}

const open = async (stop) => (await fetched(() => import("./tour.js")))?.openTour(stop)
