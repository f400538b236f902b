// Friction over load: the first slip of every computed run that this visitor has seen.

import { differing } from "../../static/js/quantities.js"
import { firstOfPath } from "../../static/js/events.js"
import { exact, me, view } from "../../static/js/store.js"

// {key, U (nm), F, L (N/m), scene, changed: the one parameter that differs, or null; stage: of a slip on a path through
// points, whose U is that of the increment}
export const points = []
let last = null // the point of the run seen last
let read = null // the run read last

export const connectSlips = () => view(["run", "status"], () => { if (me.run) collect(me.run) })

// Take in the first slip of a run, unless its scene has a point
function collect(run) {
  if (run === read || !run.whole || !exact(run)) return
  read = run
  const slip = firstOfPath(run), { scene, abscissa } = run.head
  if (!slip) return
  if (abscissa === "path") Object.assign(slip, { stage: run.leg(slip.at), U: run.curves.U_x[slip.at] })
  const key = JSON.stringify(scene), names = last ? differing(scene, last.scene) : []
  const known = points.find((point) => point.key === key)
  // the first one belongs to the depths, along which friction changes with the load
  const changed = !last ? "delta_bar" : names.length === 1 ? names[0] : null
  if (!known) points.push({ key, ...slip, scene, changed })
  last = known ?? points.at(-1)
}

// Take in a slip of a sweep of the press depth {scene, U, F, L}, unless its scene has a point
export function addSwept(slip) {
  const key = JSON.stringify(slip.scene)
  if (!points.some((point) => point.key === key)) points.push({ key, ...slip, changed: "delta_bar" })
}

// Runs to come are compared with the run seen last, as before
export const clear = () => { points.length = 0 }
