// What a file without a server says of its run.

import { by, say, tell } from "../../static/js/dom.js"
import { alone, declared } from "../../static/js/store.js"

export function connect() {
  if (!alone) return
  tell(by("look"), declared.alone.scene)
  say("notes", declared.alone.notes)
}
