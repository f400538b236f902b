// What argues the reason at a stop of the tour, drawn from the numbers of the run on screen.

import { drawAtoms } from "../lens.js"
import { cleared, inks, size, write } from "../pen.js"
import { fixed } from "../quantities.js"
import { firstSlip } from "../sentence.js"

const ACROSS = 9 // nodes that are seen with their springs
const DEFAULT = { F: 195, U: 10.8 } // N/m, nm

export const PICTURES = {
  // nodes, sites and the springs between them at the trailing edge, to scale
  springs(canvas, run, k) {
    const pen = cleared(canvas), { clientWidth: width, clientHeight: height } = canvas
    if (!pen || run.head.flat) return
    const frame = run.frame(k), edges = run.edges(k), { first, spacing } = run.headOf(k)
    const i = edges ? Math.floor(edges[0] - first) : frame.gap.findIndex((gap) => gap === Math.min(...frame.gap))
    const at = frame.x[Math.max(0, i)] + 2 * spacing, scale = width / (ACROSS * spacing), low = 0.72 * height
    drawAtoms({ pen, frame, run, k, ink: inks() }, (x) => 0.5 * width + (x - at) * scale, (y) => low - y * scale * 0.8,
      scale, at - (ACROSS * spacing) / 2, at + (ACROSS * spacing) / 2)
  },
  edges: (canvas, run, k) => {
    const [a, b] = run.edges(run.sheared), [c, d] = run.edges(k) ?? [a, b]
    bars(canvas,
      [["behind", Math.max(0, c - a), "sites", "adhering"], ["in front", Math.max(0, b - d), "sites", "repulsive"]])
  },
  areas: (canvas, run) => {
    const { at, A } = firstSlip(run) ?? { at: run.sheared + 1, A: run.curves.A[run.sheared] }
    bars(canvas,
      [["at first", run.curves.A[run.sheared], "nm", "area"], ["before the slip", A, "nm", "area"],
        ["after it", run.curves.A[at], "nm", "area"]])
  },
  forces: (canvas, run, k, before) => {
    const now = firstSlip(run)
    if (now) bars(canvas, [["before", before?.F ?? DEFAULT.F, "N/m", "free"], ["now", now.F, "N/m", "shear"]])
  },
  pulls: (canvas, run, k, before) => {
    const now = firstSlip(run)
    bars(canvas, [["before", before?.U ?? DEFAULT.U, "nm", "free"], ...(now ? [["now", now.U, "nm", "shear"]] : [])])
  },
}

// [name, value, unit, ink] of each bar, from zero, to one scale
function bars(canvas, list) {
  const pen = cleared(canvas), ink = inks()
  if (!pen) return
  const { clientWidth: width, clientHeight: height } = canvas, high = height / list.length, from = 0.42 * width
  const most = Math.max(...list.map(([, value]) => value), 1e-9)
  const scale = Math.min(1, high / (1.5 * size()))
  list.forEach(([name, value, unit, colour], i) => {
    const y = (i + 0.5) * high, long = (value / most) * (0.34 * width)
    write({ pen, ink }, name, from - 8, y, { align: "right", scale })
    pen.fillStyle = ink[colour]
    pen.fillRect(from, y - 0.3 * high, Math.max(1, long), 0.6 * high)
    write({ pen, ink }, `${fixed(value, value < 99 ? 1 : 0)} ${unit}`, from + long + 8, y,
      { align: "left", scale })
  })
}
