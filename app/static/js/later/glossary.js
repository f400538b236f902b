// The explanation beside a term: there while the pointer is on it or on the term, or the keyboard on the term; a click
// or a touch keeps it and has it read out; Escape or a press elsewhere takes it away.

import { by, make } from "../dom.js"

const AWAY = 250 // ms for the pointer to reach the explanation
let at = null, kept = false, leaving = 0, box = null

// The text of a file beside the scripts, asked for once, unless it does not come
export function file(name) {
  let asked = null
  return () => (asked ??= fetch(new URL(`../../${name}`, import.meta.url))
    .then((answer) => (answer.ok ? answer.text() : Promise.reject(answer.status)))
    .catch((error) => { asked = null; throw error }))
}
export const text = file("glossary.html")

async function said(term) {
  const read = new DOMParser().parseFromString(await text(), "text/html").getElementById(`term-${term}`)
  return [read.querySelector("dt").textContent, read.querySelector("dd").textContent]
}

export async function show(button) {
  clearTimeout(leaving)
  if (button === at) return
  kept = false
  at = button
  const [name, meaning] = await said(button.dataset.term).catch(() => ["", "The explanation could not be loaded."])
  if (at !== button) return
  if (!button.matches(":hover, :focus")) return hide() // by now pointer and keyboard are elsewhere
  box ??= makeBox()
  box.replaceChildren(make("b", {}, name), ` ${meaning}`)
  button.setAttribute("aria-describedby", "term")
  box.showPopover()
  place()
}

function place() {
  if (!at) return
  const { left, top, bottom } = at.getBoundingClientRect(), { offsetWidth: width, offsetHeight: height } = box
  const below = bottom + 6 + height < innerHeight && !at.closest("#tour-card") // there the way on lies below
  box.style.left = `${Math.max(8, Math.min(left, innerWidth - width - 8))}px`
  box.style.top = `${below ? bottom + 6 : Math.max(8, top - 6 - height)}px`
}

export async function keep(button) {
  await show(button)
  kept = true
  by("told").textContent = box?.textContent ?? ""
}

function hide() {
  at?.removeAttribute("aria-describedby")
  at = null
  kept = false
  box?.hidePopover()
}

function makeBox() {
  const made = make("div", { id: "term", popover: "manual", role: "tooltip" })
  document.querySelector("main").append(made)
  const on = (event) => [at, made].some((element) => element?.contains(event.target))
  document.addEventListener("mouseover", (event) => {
    clearTimeout(leaving)
    if (at && !kept && !on(event) && document.activeElement !== at) leaving = setTimeout(hide, AWAY)
  })
  document.addEventListener("focusin", (event) => { if (at && !kept && !on(event) && !at.matches(":hover")) hide() })
  document.addEventListener("focusout", (event) => { if (event.target === at && !kept) hide() })
  document.addEventListener("pointerdown", (event) => { if (at && !on(event)) hide() })
  document.addEventListener("keydown", (event) => { if (event.key === "Escape" && at) { hide(); event.stopPropagation() } }, true)
  for (const event of ["scroll", "resize"]) addEventListener(event, place, { passive: true })
  return made
}
