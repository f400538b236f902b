// The model and the glossary, in a dialog. Their texts are fetched when it opens.

import { by, on } from "../../static/js/dom.js"

let texts = null // a promise of them, once the dialog was opened

export const connect = () => on("open-theory", "click", open)

async function open() {
  by("theory").showModal()
  try {
    texts ??= Promise.all(["model.html", "glossary.html"].map(fileBeside))
    by("theory-text").innerHTML = (await texts).join("")
  } catch {
    texts = null
    by("theory-text").replaceChildren("The page could not be loaded; close it and try again.")
  }
}

// The text of a file beside this script
async function fileBeside(name) {
  const answer = await fetch(new URL(name, import.meta.url))
  if (!answer.ok) throw new Error(`${name}: ${answer.status}`)
  return answer.text()
}
