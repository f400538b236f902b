// The picture that argues the reason at some stops of the tour: nodes, sites and the springs between them, to scale.

import { drawAtoms } from "../lens.js"
import { cleared, inks } from "../pen.js"

const ACROSS = 9 // nodes that are seen with their springs

// At the trailing edge of frame k of a run
export function drawSprings(canvas, run, k) {
  const pen = cleared(canvas), { clientWidth: width, clientHeight: height } = canvas
  if (!pen || run.head.flat) return
  const frame = run.frame(k), edges = run.edges(k), { first, spacing } = run.headOf(k)
  const i = edges ? Math.floor(edges[0] - first) : frame.gap.findIndex((gap) => gap === Math.min(...frame.gap))
  const at = frame.x[Math.max(0, i)] + 2 * spacing, scale = width / (ACROSS * spacing), low = 0.72 * height
  drawAtoms({ pen, frame, run, k, ink: inks() }, (x) => 0.5 * width + (x - at) * scale, (y) => low - y * scale * 0.8,
    scale, at - (ACROSS * spacing) / 2, at + (ACROSS * spacing) / 2)
}
