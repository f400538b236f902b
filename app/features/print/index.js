// Before it is printed the page is drawn in light colours: in the dark theme numbers would be white on white.

import { root } from "../../static/js/dom.js"
import { drawNow, redraw } from "../../static/js/store.js"

export function connect() {
  let theme = ""
  addEventListener("beforeprint", () => {
    theme = root.dataset.theme
    root.dataset.theme = "light"
    redraw()
    drawNow()
  })
  addEventListener("afterprint", () => {
    root.dataset.theme = theme
    redraw()
  })
}
