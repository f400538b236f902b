// The line below the views of an embedded page: the parameters, and a link to the whole app.

import { by, tell } from "../dom.js"
import { me, view } from "../store.js"
import { described } from "../words.js"

view(["picture", "status"], () => {
  if (!me.picture) return
  tell(by("caption"), described(me.picture.run, me.picture.k))
  const url = new URL(location.href)
  url.searchParams.delete("embed")
  if (by("whole-app").href !== url.href) by("whole-app").href = url.href
})
