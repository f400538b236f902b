// The Bokeh figures of a page that is open. Nothing here reaches the server.

import {
  fill as fillRenderer, isDrawn, namedParts, set, thicken, tint, viewOf,
} from "./bokeh.js"
import { colour, shades, textSize, theme } from "./colours.js"
import { by, tell } from "./dom.js"
import { digits } from "./quantities.js"

export const figures = {} // name: Bokeh figure
export const parts = {} // figure: {label: what is drawn in it}
const THICK = 2.5 // times, for a projector
export function adopt(name, figure) {
  figures[name] = figure
  parts[name] = namedParts(figure)
}

export function forget(name) {
  delete figures[name]
  delete parts[name]
}

export const fill = (view, label, columns) => fillRenderer(parts[view][label], columns)

export const drawn = (names) => names.every((name) => isDrawn(figures[name]))

// The limits of the colours of a view, in its key
export function tellLimits(view, low, high) {
  tell(by(`${view}-low`), digits(low, 2))
  tell(by(`${view}-high`), `+${digits(high, 2)} GPa`)
}

// Colours of an image for its limits, unless it has them
const shaded = {} // "view.label": for which limits, theme and mapper it has its shades
export function shade(view, label, low, high) {
  const mapper = parts[view]?.[label]?.glyph.color_mapper
  const key = [low, high, theme(), mapper?.id].join()
  if (!mapper || shaded[`${view}.${label}`] === key) return
  shaded[`${view}.${label}`] = key
  set(mapper, shades(low, high))
  tellLimits(view, low, high)
}

// Figures are drawn on a canvas and need the colours: of what is drawn, the one its tag names
export function paint() {
  const text = colour("--text"), soft = colour("--soft"), grid = colour("--grid")
  const size = textSize(), large = size > 15 // for a projector
  for (const name in figures) {
    const figure = figures[name]
    viewOf(figure) // the Tab key passes it
    set(figure, { outline_line_color: grid, min_border_right: large ? 34 : 14 })
    for (const axis of [...figure.below, ...figure.left]) {
      set(axis, {
        axis_label_text_color: text, major_label_text_color: soft, axis_line_color: soft, major_tick_line_color: soft,
        axis_label_text_font_size: `${large ? size : size + 1}px`, major_label_text_font_size: `${size}px`,
      })
    }
    for (const line of figure.center) if ("grid_line_color" in line)
      set(line, { grid_line_color: grid, grid_line_alpha: 0.5 })
    for (const part of Object.values(parts[name])) {
      if (part.tags[0]) tint(part, colour(part.tags[0]))
      thicken(part, large ? THICK : 1)
    }
  }
}
