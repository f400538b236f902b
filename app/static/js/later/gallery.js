// The gallery: every preset by its phenomenon, with a small picture from the solver: the force over the path, and under it
// the width in contact. Pictures are drawn as they come.

import { listen, order } from "../channel.js"
import { by, make, makeButton, makeShape } from "../dom.js"
import { me } from "../state.js"

const WIDE = 120, HIGH = 64, EDGE = 3 // of a picture, in units of its own
const BAND = 0.4 // of the height, for the width in contact

const path = (points) => `M${points.map((point) => point.map((v) => v.toFixed(1)).join(" ")).join("L")}`

// along, force, area: lists of numbers; the area of a path that goes one way only
function picture({ along, force, area }) {
  const svg = makeShape("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, "aria-hidden": "true" })
  const [from, to] = [Math.min(...along), Math.max(...along)], [low, high] = [Math.min(0, ...force), Math.max(0, ...force)]
  const x = (v) => EDGE + ((v - from) / (to - from || 1)) * (WIDE - 2 * EDGE)
  const y = (v) => HIGH - EDGE - ((v - low) / (high - low || 1)) * (HIGH - 2 * EDGE)
  const largest = Math.max(...area) || 1, top = area.map((A, i) => [x(along[i]), HIGH - (A / largest) * BAND * HIGH])
  const oneWay = along.every((v, i) => i === 0 || v >= along[i - 1])
  if (oneWay) svg.append(makeShape("path", { class: "area", d: `${path([[top[0][0], HIGH], ...top, [top.at(-1)[0], HIGH]])}Z` }))
  svg.append(
    makeShape("path", { class: "zero", d: path([[0, y(0)], [WIDE, y(0)]]) }),
    makeShape("path", { class: "force", d: path(force.map((F, i) => [x(along[i]), y(F)])) }),
  )
  return svg
}

function card(option) {
  const onclick = () => {
    by("gallery").close()
    by("preset").value = option.value
    by("preset").dispatchEvent(new Event("change"))
  }
  return makeButton({ className: "card", data: { preset: option.value }, onclick },
    make("span", { className: "picture" }, "…"), make("span", {}, option.textContent), " ", make("small", {}, option.dataset.figure))
}

function drawn(text) {
  const { preset, drawn: found } = JSON.parse(text)
  for (const place of document.querySelectorAll(`[data-preset="${preset}"] .picture`)) place.replaceChildren(found ? picture(found) : "no picture")
}

function fill() {
  by("gallery-groups").replaceChildren(...[...by("preset").querySelectorAll("optgroup")].map((group) => (
    make("section", {}, make("h3", { textContent: group.label }), make("div", { className: "cards" }, ...[...group.children].map(card))))))
}

// Ask for the pictures that are missing, also what a busy server had no time for
export function wantPictures() {
  if (!by("gallery-groups").children.length) {
    fill()
    listen("thumbnail", drawn)
  }
  if (by("gallery").querySelector(".picture:not(:has(svg))")) order("gallery")
}

export function openGallery() {
  wantPictures()
  const cards = [...by("gallery").querySelectorAll(".card")], now = cards.find(({ dataset }) => dataset.preset === me.status.preset)
  for (const one of cards) one.ariaCurrent = one === now ? "true" : null
  by("gallery").showModal()
  now?.focus()
}
