// Pinned runs: kept in this browser, drawn behind the run on screen, shown as chips.

import { by, fetched, on } from "../../static/js/dom.js"
import { declare, me, view } from "../../static/js/store.js"

export function connect() {
  declare({ pins: [] }) // see pins.js
  on("pin", "click", async () => (await fetched(() => import("./pins.js")))?.pinRun())
  view(["status"], () => { by("pin").disabled = !me.status.state }) // it needs the scene
}
