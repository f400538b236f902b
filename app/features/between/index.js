// Between slips: the unstable branch that a slip jumps over, dashed behind the curves (solver/analysis/unstable.py).

import { order, take } from "../../static/js/channel.js"
import { addPart, charts } from "../../static/js/charts.js"
import { by, on, tell } from "../../static/js/dom.js"
import { declare, me, view } from "../../static/js/store.js"

const CURVES = [["forces", "F", "--shear"], ["forces", "L", "--normal"], ["area", "A", "--area"]]
const DASH = [3, 4]

export function connect() {
  declare({ unstable: [], follows: false })
  for (const [chart, name] of CURVES) addPart(chart, `between_${name}`, { kind: "lines", list: [] }, name)
  on("unstable", "change", () => {
    order("unstable", { shown: by("unstable").checked })
    if (!by("unstable").checked) show({ list: [], why: "", exact: true })
  })
  take("branches", show)
  view(["unstable", "follows", "run", "drawn"], draw)
}

// follows: they are of a prediction while a slider is held, and come a moment after it
function show({ list, why, exact }) {
  Object.assign(me, { unstable: by("unstable").checked ? list : [], follows: !exact })
  tell(by("unstable-why"), by("unstable").checked ? why : "")
}

// That of the slip to come, or of the last one: all of them would hide each other. Only over the displacement, as along
// other paths slips are those of other branches
function draw() {
  const { run, unstable } = me, here = run?.curves.U_x[Math.max(0, me.drawn)] ?? 0
  const next = unstable.find(({ U_x }) => U_x[0] >= here) ?? unstable.at(-1)
  const along = next && run?.head.abscissa === "U_x" && (run.followed || !me.follows) ? [next] : []
  for (const [chart, name, own] of CURVES) {
    const ink = me.follows ? "--ghost" : own
    const list = along.map((branch) => ({ x: branch.U_x, y: branch[name], ink, width: 1, dash: DASH }))
    charts[chart].fill(`between_${name}`, { list })
  }
}
