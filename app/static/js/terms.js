// Terms of the field in the texts of the page: underlined; a click shows the explanation in a popover of the browser.
// And the theory page. Both are fetched when somebody asks for them.

import { by, make, makeButton } from "./dom.js"
import { declared, sees } from "./store.js"

let forms = null // what finds forms of terms in a text

// The text of a file beside the scripts, asked for once, unless it does not come
function file(name) {
  let asked = null
  return () => (asked ??= fetch(new URL(`../${name}`, import.meta.url))
    .then((answer) => (answer.ok ? answer.text() : Promise.reject(answer.status)))
    .catch((error) => { asked = null; throw error }))
}
const glossary = file("glossary.html"), theory = file("theory.html")

// The text of an element again, the first occurrence of each term in it as a button, in one line with the stop behind
// it
export function explain(element, text = element.textContent) {
  const [first, ...found] = forms && sees("terms") ? text.split(forms) : [text]
  const parts = [first], seen = new Set()
  for (let i = 0; i < found.length; i += 3) {
    const [form, stop, between] = found.slice(i, i + 3), term = declared.terms[form.toLowerCase()]
    parts.push(seen.has(term) ? form + stop : buttonOf(term, form, stop), between)
    seen.add(term)
  }
  element.replaceChildren(...parts)
}

function buttonOf(term, form, stop) {
  const button = makeButton({ className: "term", data: { term }, "aria-haspopup": "dialog" }, form)
  return stop ? make("span", { style: "white-space: nowrap" }, button, stop) : button
}

// The texts on the page, where terms are shown now or no longer
export function explainAgain() {
  for (const element of document.querySelectorAll("[data-terms]")) explain(element)
}

async function show(source) {
  const box = by("term"), { term } = source.dataset
  box.textContent = "…"
  box.hidePopover()
  box.showPopover({ source })
  try {
    const entry = new DOMParser().parseFromString(await glossary(), "text/html").getElementById(`term-${term}`)
    box.replaceChildren(make("b", {}, entry.querySelector("dt").textContent),
      ` ${entry.querySelector("dd").textContent}`)
  } catch {
    box.textContent = "The explanation could not be loaded. Click the word again."
  }
  by("announcement").textContent = box.textContent
}

export function connect() {
  forms = new RegExp(`(?<![\\p{L}-])(${Object.keys(declared.terms).join("|")})(?![\\p{L}-])([,.:;?)]*)`, "iu")
  explainAgain()
  document.addEventListener("click", ({ target }) => {
    const term = target.closest?.(".term")
    if (term) show(term)
  })
}

export async function openTheory() {
  by("theory").showModal()
  try {
    by("theory-text").innerHTML = (await theory()) + (await glossary())
  } catch {
    by("theory-text").replaceChildren("The page could not be loaded; close it and try again.")
  }
}
