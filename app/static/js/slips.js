// Friction over load: the first slip of every computed run that this visitor has seen.

import { firstSlip } from "./sentence.js"
import { exact, me, view } from "./store.js"

export const points = [] // {key, U (nm), F, L (N/m), scene, changed: the one parameter that differs, or null}
let last = null // the point of the run seen last
let read = null // the run read last

export const connectSlips = () => view(["run", "status"], () => { if (me.run) collect(me.run) })

// Take in the first slip of a run, unless its scene has a point
export function collect(run) {
  if (run === read || !run.whole || !exact(run) || run.carried) return
  read = run
  const slip = firstSlip(run), { scene } = run.head
  if (!slip) return
  const key = JSON.stringify(scene), names = last ? Object.keys(scene).filter((name) => differ(name, scene)) : []
  const known = points.find((point) => point.key === key)
  if (!known) points.push({ key, ...slip, scene, changed: names.length === 1 ? names[0] : null })
  last = known ?? points.at(-1)
}

const differ = (name, scene) => `${scene[name]}` !== `${last.scene[name]}`

// Runs to come are compared with the run seen last, as before
export const clear = () => { points.length = 0 }
