// Stored runs of the row's experiments (app/service/stored.py): on screen until the computed run has come.

import { by } from "./dom.js"
import { unpackLater } from "./packed.js"
import { Run } from "./run.js"
import { declared, me, view } from "./store.js"

let asked = "" // address of the last one

// show(run): puts a stored run on the screen. The page names that of its scene. While workers get ready, the one of the
// preset is shown where the page names none
export function connectStored(show) {
  const load = async (address) => {
    if (!address || address === asked || computed()) return
    asked = address
    const response = await fetch(address).catch(() => null)
    const chunk = response?.ok && (await unpackLater({ body: await response.arrayBuffer() }))
    if (!chunk || address !== asked || computed()) return
    const run = Object.assign(new Run(0, chunk.head), { stored: true })
    run.add(chunk)
    show(run)
  }
  load(by("stored")?.getAttribute("href"))
  view(["status"], () => {
    const { state, preset } = me.status
    if (state === "warming") load(declared.stored[preset] ?? Object.values(declared.stored)[0])
  })
}

const computed = () => Boolean(me.run) && !me.run.stored
