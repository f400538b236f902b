// A class that answers: its button, and the class that an address names. Loaded when it is asked for.

import { fetched, on } from "../../static/js/dom.js"
import { declare } from "../../static/js/store.js"

const lesson = () => fetched(() => import("./lesson.js"))

export async function connect() {
  declare({ lesson: null }) // the state of the class, as the server sends it
  on("class", "click", async () => (await lesson())?.openClass())
  if (new URLSearchParams(location.search).get("class")) (await lesson())?.join()
}
