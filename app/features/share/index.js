// Share: its button. The sheet is loaded once the first run is there, as it opens without the server, too.

import { by, fetched, on } from "../../static/js/dom.js"
import { me, view } from "../../static/js/store.js"

const sheet = () => fetched(() => import("./share.js"))

export function connect() {
  on("take", "click", async () => (await sheet())?.open())
  let kept = false
  view(["status"], () => {
    by("take").disabled = !me.status.state // it needs the scene
    if (kept || me.status.state !== "finished") return
    kept = true
    sheet()
  })
}
