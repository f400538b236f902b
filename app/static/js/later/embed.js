// The line below the views of an embedded page: the parameters, and a link to the whole app.

import { by, tell } from "../dom.js"
import { onFrame } from "../state.js"
import { described } from "../words.js"

onFrame((run, k) => {
  tell(by("caption"), described(run, k))
  const url = new URL(location.href)
  url.searchParams.delete("embed")
  if (by("whole-app").href !== url.href) by("whole-app").href = url.href
})
