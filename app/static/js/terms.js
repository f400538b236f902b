// Terms of the field in the texts of the page: underlined, and explained on hover, focus or touch by later/glossary.js.

import { make, makeButton } from "./dom.js"
import { declared } from "./state.js"

let found = null // what finds forms of terms in a text

// The text of an element again, the first occurrence of each term in it as a button, in one line with the stop behind it
export function explain(element, text = element.textContent) {
  const seen = new Set(), parts = found ? text.split(found) : [text] // between, term, stop, between, ...
  element.replaceChildren(...parts.map((part, i) => {
    const term = i % 3 === 1 ? declared.terms[part.toLowerCase()] : undefined
    if (!term || seen.has(term)) return i % 3 === 2 && seen.has(i) ? "" : part
    seen.add(term).add(i + 1)
    const button = makeButton({ className: "term", data: { term } }, part)
    return parts[i + 1] ? make("span", { style: "white-space: nowrap" }, button, parts[i + 1]) : button
  }))
}

const ANSWERS = { mouseover: "show", focusin: "show", click: "keep" } // what later/glossary.js does at a term

export function connect() {
  found = new RegExp(`(?<![\\p{L}-])(${Object.keys(declared.terms).join("|")})(?![\\p{L}-])([,.:;?)]*)`, "iu")
  for (const element of document.querySelectorAll("[data-terms]")) explain(element)
  for (const event in ANSWERS) {
    document.addEventListener(event, async ({ target }) => {
      const at = target.closest?.(".term")
      if (at) (await import("./later/glossary.js"))[ANSWERS[event]](at)
    })
  }
}
