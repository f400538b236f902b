// On paper: every view as a picture, with the parameters; and the line below the views of an embedded page.

import { holderOf, pictureOf } from "./bokeh.js"
import { by } from "./dom.js"
import { figures } from "./figures.js"
import { embedded, me, onFrame } from "./state.js"
import { described } from "./words.js"

// The canvases over a view
export const canvasesOver = (holder) => (
  [...holder.querySelectorAll(":scope > canvas:not(.printed)")].filter((over) => over.width))

export function drawOver(pen, holder, width, height) {
  for (const over of canvasesOver(holder)) {
    pen.globalAlpha = Number(getComputedStyle(over).opacity)
    pen.drawImage(over, 0, 0, width, height)
  }
}

function before() {
  if (document.querySelector(".printed")) return // on paper already
  by("caption").textContent = described(me.run, me.drawn)
  for (const name in figures) {
    const holder = holderOf(figures[name])
    if (!holder?.clientWidth || !holder.clientHeight) continue
    const canvas = pictureOf(figures[name]), pen = canvas.getContext("2d")
    pen.setTransform(1, 0, 0, 1, 0, 0)
    drawOver(pen, holder, canvas.width, canvas.height)
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
  if (embedded) onFrame(tellEmbedded)
}
