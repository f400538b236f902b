// Terms of the field in the texts of the page: underlined, and explained on hover, focus or touch by later/glossary.js.

import { makeButton } from "./dom.js"
import { declared } from "./state.js"

let found = null // what finds forms of terms in a text

// The text of an element again, the first occurrence of each term in it as a button
export function explain(element, text = element.textContent) {
  const seen = new Set()
  const parts = found ? text.split(found) : [text]
  element.replaceChildren(...parts.map((part, i) => {
    const term = i % 2 ? declared.terms[part.toLowerCase()] : undefined
    if (!term || seen.has(term)) return part
    seen.add(term)
    return makeButton({ className: "term", data: { term } }, part)
  }))
}

const ANSWERS = { mouseover: "show", focusin: "show", click: "keep" } // what later/glossary.js does at a term

export function connect() {
  found = new RegExp(`(?<![\\p{L}-])(${Object.keys(declared.terms).join("|")})(?![\\p{L}-])`, "iu")
  for (const element of document.querySelectorAll("[data-terms]")) explain(element)
  for (const event in ANSWERS) {
    document.addEventListener(event, async ({ target }) => {
      const at = target.closest?.(".term")
      if (at) (await import("./later/glossary.js"))[ANSWERS[event]](at)
    })
  }
}
