// What a chart says beside the mouse, and where a click leads.

import { charts, CURVES } from "./charts.js"
import { goto } from "./player.js"
import { me, redraw } from "./store.js"

const resized = new ResizeObserver(redraw) // what rests is drawn anew, in the size of the text there

// Beside the mouse a chart says what is there. On a curve of the run, that increment is shown in every view while
// playback rests, and a click goes there
export function connectChart(name) {
  const chart = charts[name], { view: surface } = chart, curve = CURVES.includes(name)
  resized.observe(surface)
  const px = (event) => {
    const { left, top } = surface.getBoundingClientRect()
    return { x: event.clientX - left, y: event.clientY - top }
  }
  const there = (at) => (me.run?.sheared >= 0 && chart.box ? me.run.nearest(chart.placeOf(at).x, me.at) : null)
  const point = (at) => {
    me.pointed = at && { name, ...at }
    if (curve && (at === null || !me.playing)) me.preview = at && there(at)
  }
  surface.addEventListener("pointermove", (event) => { if (event.pointerType !== "touch") point(px(event)) })
  surface.addEventListener("pointerleave", () => point(null))
  if (!curve) return
  surface.addEventListener("click", (event) => {
    const k = there(px(event))
    if (k !== null) goto(k)
  })
}
