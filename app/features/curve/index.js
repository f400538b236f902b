// Your data: a measured curve over the run. Loaded with the first file.

import { fetched, on, root } from "../../static/js/dom.js"
import { CARRIED, declare, me } from "../../static/js/store.js"

const overlay = () => fetched(() => import("./overlay.js"))

export function connect() {
  declare({ laid: null }) // see overlay.js
  // the server forgets it
  CARRIED.curve = { give: () => me.laid?.name, take: async (name) => { if (name) (await overlay())?.askAgain(name) } }
  on("data", "click", async () => (await overlay())?.choose())
  connectDrop()
}

// A file dropped on the page is a measured curve
function connectDrop() {
  root.addEventListener("dragover", (event) => event.preventDefault())
  root.addEventListener("drop", async (event) => {
    const [file] = event.dataTransfer.files
    event.preventDefault()
    if (file) (await overlay())?.read(file)
  })
}
