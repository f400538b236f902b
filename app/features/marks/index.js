// Marks beside the sliders, where the behaviour changes (solver/analysis/marks.py); a click goes there.

import { by, closest, make, makeButton } from "../../static/js/dom.js"
import { digits } from "../../static/js/quantities.js"
import { declared, me, memory, view } from "../../static/js/store.js"

export function connect() {
  for (const name in declared.mark_meanings) {
    const slider = by(name), { title, dataset } = slider, meaning = `${dataset.meaning} ${declared.mark_meanings[name]}`
    if (title === dataset.meaning) slider.title = meaning
    dataset.meaning = meaning
    by(`${name}-meaning`).append(` ${declared.mark_meanings[name]} `, make("b", { id: `${name}-marked` }))
  }
  view(["status"], drawMarks)
}

const APART = [0.2, 64] // of a slider, and px, between two labels, at least
const ENDS = [0.12, 0.82] // of it, beyond which a label stands beside its mark, so that it stays on the slider

const drawn = memory()

function drawMarks() {
  const { marks } = me.status
  if (!marks || !drawn(JSON.stringify(marks))) return
  for (const name in declared.positions) draw(name, marks[name] ?? [], declared.positions[name])
}

function draw(name, marks, values) {
  const scale = by(name).parentElement.querySelector(".ends"), labels = []
  const apart = Math.max(APART[0], APART[1] / (by(name).clientWidth || Infinity))
  for (const old of scale.querySelectorAll(".mark")) old.remove()
  const titles = marks.map(([value, label]) => `${label} at ${digits(value, 2)}`)
  marks.forEach(([value, label], i) => {
    const at = partAt(value, values), onclick = () => goThere(by(name), closest(values, value))
    // those who cannot see it hear of it at the slider, which has the keyboard
    const mark = makeButton({ className: "mark", title: `${titles[i]}: click to go there`, tabIndex: -1, onclick })
    mark.style.left = `calc(8px + ${at} * (100% - 16px))`
    if (labels.every((other) => Math.abs(other - at) > apart)) {
      mark.append(make("span", {}, label))
      const left = at > ENDS[1] ? "left" : ""
      mark.dataset.side = at < ENDS[0] ? "right" : left
      labels.push(at)
    }
    scale.append(mark)
  })
  by(`${name}-marked`).textContent = marks.length ? `Here: ${titles.join(", ")}.` : ""
}

// Move a slider as a hand does, and let it go
function goThere(slider, position) {
  slider.value = position
  for (const type of ["input", "pointerup"]) slider.dispatchEvent(new Event(type))
}

// Part of the slider at which a value lies
function partAt(value, values) {
  const above = Math.max(1, values.findIndex((v) => v >= value)), below = above - 1
  return (below + (value - values[below]) / (values[above] - values[below])) / (values.length - 1)
}
