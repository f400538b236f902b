// Terms of the field in the texts of the page: underlined, and explained on hover, focus or touch by later/glossary.js.

import { makeButton } from "./dom.js"

let forms = {}, found = null // {form of a word: term} (app/glossary.py), and what finds them in a text

// The text of an element again, the first occurrence of each term in it as a button
export function explain(element, text = element.textContent) {
  const seen = new Set()
  const parts = found ? text.split(found) : [text]
  element.replaceChildren(...parts.map((part, i) => {
    const term = i % 2 ? forms[part.toLowerCase()] : undefined
    if (!term || seen.has(term)) return part
    seen.add(term)
    return makeButton({ className: "term", data: { term } }, part)
  }))
}

const termAt = (event) => event.target.closest?.(".term")
const glossary = () => import("./later/glossary.js")

export function connect(given) {
  forms = JSON.parse(given)
  found = new RegExp(`(?<![\\p{L}-])(${Object.keys(forms).join("|")})(?![\\p{L}-])`, "iu")
  for (const element of document.querySelectorAll("[data-terms]")) explain(element)
  for (const event of ["mouseover", "focusin"]) {
    document.addEventListener(event, async (of) => { const at = termAt(of); if (at) (await glossary()).show(at) })
  }
  document.addEventListener("click", async (event) => { const at = termAt(event); if (at) (await glossary()).keep(at) })
}
