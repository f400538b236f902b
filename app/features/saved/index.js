// What a file without a server says of its run.

import { by, say, tell } from "../../static/js/dom.js"
import { declared } from "../../static/js/store.js"

export function connect() {
  if (!declared.alone) return // a Stage in a layout has them in its status
  tell(by("look"), declared.alone.scene)
  say("notes", declared.alone.notes)
}
