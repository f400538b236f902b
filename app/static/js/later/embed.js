// The line below the views of an embedded page: the parameters, and a link to the whole app.

import { by, tell } from "../dom.js"
import { me, view } from "../store.js"
import { described } from "../words.js"

view(["run", "drawn"], () => {
  if (me.drawn < 0) return
  tell(by("caption"), described(me.run, me.drawn))
  const url = new URL(location.href)
  url.searchParams.delete("embed")
  if (by("whole-app").href !== url.href) by("whole-app").href = url.href
})
