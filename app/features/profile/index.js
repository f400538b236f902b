// A measured profile: its file is read by the server, which may ask about it (trace.js, loaded with the first file).

import { tooLarge } from "../../static/js/channel.js"
import { fetched, on, say } from "../../static/js/dom.js"
import { me, view } from "../../static/js/store.js"

export function connect() {
  on("profile", "click", ({ target }) => { target.value = "" }) // so that the same file can be chosen again
  on("profile", "change", ({ target }) => { if (target.files[0]) readProfile(target.files[0]) })
  view(["status"], () => { if (me.status.errors) say("profile-error", me.status.errors.profile) })
}

async function readProfile(file) {
  const large = tooLarge(file)
  if (large)
    return say("profile-error", `profile: ${file.name} has ${large}; thin it out. The run on screen stays.`)
  const content = await file.arrayBuffer()
  return (await fetched(() => import("./trace.js")))?.read(content)
}
