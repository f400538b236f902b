// The dialog *Theory*: the model and the glossary, fetched when it is first opened.

import { by } from "../dom.js"

let text = null // a promise of both files

// The text of a file beside the scripts
async function file(name) {
  const answer = await fetch(new URL(`../../${name}`, import.meta.url))
  if (!answer.ok) throw new Error(`${name}: ${answer.status}`)
  return answer.text()
}

export async function openTheory() {
  by("theory").showModal()
  try {
    text ??= Promise.all(["theory.html", "glossary.html"].map(file))
    by("theory-text").innerHTML = (await text).join("")
  } catch {
    text = null
    by("theory-text").replaceChildren("The page could not be loaded; close it and try again.")
  }
}
