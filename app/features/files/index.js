// Measured files: chosen or dropped, then read in a dialog that is loaded with the first file.

import { by, fetched, make, on, root } from "../../static/js/dom.js"
import { CARRIED, declare, me } from "../../static/js/store.js"

const dialog = () => fetched(() => import("./dialog.js"))

export function connect() {
  declare({ laid: null }) // the curve over the run: see laid.js
  // the server forgets it
  CARRIED.laid = { give: () => me.laid?.name, take: async (name) => {
    if (name) (await fetched(() => import("./laid.js")))?.askAgain(name)
  } }
  on("data", "click", () => {
    const input = make("input", { type: "file", onchange: () => read(input.files) })
    input.click()
  })
  by("profile")?.addEventListener("click", ({ target }) => { target.value = "" }) // to choose the same file again
  by("profile")?.addEventListener("change", ({ target }) => read(target.files, "surface"))
  root.addEventListener("dragover", (event) => event.preventDefault())
  root.addEventListener("drop", (event) => {
    event.preventDefault()
    read(event.dataTransfer.files)
  })
}

async function read([file, ...others], kind = "") {
  if (file) (await dialog())?.open(file, { kind: kind, left: others.length })
}
