// Slow motion: its button and key. The rest is loaded when it is asked for.

import { by, fetched, on } from "../../static/js/dom.js"
import { KEYS } from "../../static/js/inputs.js"
import { exact, frame, me } from "../../static/js/store.js"

export function connect() {
  on("slow", "click", slowMotion)
  KEYS.m = slowMotion
  frame(["picture"], offer)
}

async function slowMotion() {
  if (!me.run?.stored) (await fetched(() => import("./film.js")))?.slowMotion()
}

// Where the increment on screen has had a slip
function offer() {
  const { run, k } = me.picture ?? {}
  if (run && !run.transient) by("slow").hidden = !exact(run) || run.slipBefore(k) === null
}
