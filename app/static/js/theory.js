// The theory page: fetched and shown when it is asked for.

import { by } from "./dom.js"
import { drawIdeas } from "./later/ideas.js"
import * as glossary from "./later/glossary.js"

let asked = null

export async function openTheory() {
  by("theory").showModal()
  asked ??= fetch(new URL("../theory.html", import.meta.url)).then((answer) => (answer.ok ? answer.text() : Promise.reject(answer.status)))
  try {
    by("theory-text").innerHTML = (await asked) + (await glossary.text())
    drawIdeas(by("theory-text"))
  } catch {
    asked = null
    by("theory-text").textContent = "The page could not be loaded; close it and try again."
  }
}
