// Stored runs stand in for the computed one.

import { by } from "../../static/js/dom.js"
import { unpackLater } from "../../static/js/packed.js"
import { standIn } from "../../static/js/player.js"
import { Run } from "../../static/js/run.js"
import { declared, me, view } from "../../static/js/store.js"

// A stored run of an experiment of the row (store.py) is on screen until the computed one has come. The
// page names that of its scene. While workers get ready, the one of the preset is shown where the page names none
export function connect() {
  showStored(by("stored")?.getAttribute("href"))
  view(["status"], () => {
    const { state, preset } = me.status
    if (state === "warming") showStored(declared.stored[preset] ?? Object.values(declared.stored)[0])
  })
}

let asked = "" // address of the last stored run
async function showStored(address) {
  const superfluous = () => address !== asked || (Boolean(me.run) && !me.run.stored)
  if (!address || address === asked) return
  asked = address
  const response = superfluous() ? null : await fetch(address).catch(() => null)
  const chunk = response?.ok && (await unpackLater({ body: await response.arrayBuffer() }))
  if (!chunk || superfluous()) return
  const run = Object.assign(new Run(0, chunk.head), { stored: true })
  run.add(chunk)
  standIn(run)
}
