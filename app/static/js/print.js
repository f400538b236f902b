// On paper: every view as a picture, with the parameters; and the line below the views of an embedded page.

import { holderOf, pictureOf } from "./bokeh.js"
import { by } from "./dom.js"
import { figures } from "./figures.js"
import { embedded, me } from "./state.js"
import { described } from "./words.js"

// What is drawn in a view now: its figure and the canvases over it
export function canvasOf(name) {
  const canvas = pictureOf(figures[name]), pen = canvas.getContext("2d")
  pen.setTransform(1, 0, 0, 1, 0, 0)
  for (const over of holderOf(figures[name])?.querySelectorAll(":scope > canvas:not(.printed)") ?? []) {
    if (over.width) pen.drawImage(over, 0, 0, canvas.width, canvas.height)
  }
  return canvas
}

function before() {
  if (document.querySelector(".printed")) return // on paper already
  by("caption").textContent = described(me.run, me.drawn)
  for (const name in figures) {
    const holder = holderOf(figures[name])
    if (!holder?.clientWidth || !holder.clientHeight) continue
    const canvas = canvasOf(name)
    canvas.className = "printed"
    canvas.removeAttribute("style")
    holder.append(canvas)
  }
}

function after() {
  for (const canvas of document.querySelectorAll(".printed")) canvas.remove()
}

function tellEmbedded() {
  by("caption").textContent = described(me.run, me.drawn)
  const url = new URL(location.href)
  url.searchParams.delete("embed")
  if (by("whole-app").href !== url.href) by("whole-app").href = url.href
}

export function connect() {
  addEventListener("beforeprint", before)
  addEventListener("afterprint", after)
  if (embedded) me.also.push(tellEmbedded)
}
