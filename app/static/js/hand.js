// Dragging the punch itself: sideways to where the top has been pulled, up and down to another indentation.

import { by, closest, onDrag } from "./dom.js"
import { goto } from "./player.js"
import { me } from "./state.js"

const DECIDED = 6 // px after which it is clear which way is meant
const PART = 0.5 // of the path for the width of the view
const DEEP = 1 / 150 // of delta_bar per px: a third of the slider in 100 px

export function connectHand(positions) {
  const view = by("punch-view"), slider = by("delta_bar"), values = positions.delta_bar
  onDrag(view, (event) => { // where the drag begins, and what it changes, once that is clear
    if (event.button || event.target.closest("#lens") || !(me.run?.sheared >= 0)) return null
    const along = me.run.along[Math.max(0, me.drawn)]
    return { x: event.clientX, y: event.clientY, way: null, along, delta: values[slider.value] }
  }, (event, from) => {
    const dx = event.clientX - from.x, dy = event.clientY - from.y
    if (!from.way && Math.max(Math.abs(dx), Math.abs(dy)) > DECIDED) {
      from.way = Math.abs(dx) > Math.abs(dy) || event.pointerType === "touch" ? "along" : "down"
      view.setPointerCapture(event.pointerId)
      view.dataset.dragged = from.way
      by("grab").hidden = true
    }
    if (from.way === "along") pull(from.along, dx)
    else if (from.way === "down") push(from.delta + DEEP * dy)
  }, ({ way }) => {
    if (way === "down") slider.dispatchEvent(new Event("pointerup"))
    delete view.dataset.dragged
  })

  // the top follows the hand, at a pace that shows every slip
  function pull(along, dx) {
    const { along: path, sheared } = me.run, long = Math.abs(path.at(-1) - path[sheared]) || 1
    goto(me.run.nearest(along + (dx * PART * long) / view.clientWidth, Math.max(me.at, sheared)))
  }

  // as if the slider were moved
  function push(delta) {
    const at = closest(values, delta)
    if (Number(slider.value) === at) return
    slider.value = at
    slider.dispatchEvent(new Event("input"))
  }
}
