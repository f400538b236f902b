// The connection with the server. Once it is lost, changes of the scene wait, and pages are locked; when the server
// answers the page is loaded again as it was: parameters and what was asked for since in its address, the increment
// shown beside it.

import { silence } from "./channel.js"
import { by, keepForTab, readdress, takeFromTab } from "./dom.js"
import { warn } from "./opening.js"
import { declared, me, now } from "./store.js"

const LOOK = 1000 // ms between two looks at orders without an answer
const SILENT = 4000 // ms without one, after which the server is asked whether it is there
const DEAF = 12000 // ms: it is, but this page is not heard any more
const PATIENCE = 3000 // ms it has to say so
// ms between attempts, the last again and again: a class must not wait long, nor a server be stormed
const PAUSES = [500, 1000, 2000]
const AS_IT_WAS = "as it was"

export function connect() {
  document.addEventListener("connection-lost", lost) // Bokeh's, see app/experiment.py
  document.addEventListener("visibilitychange", () => { if (!document.hidden) look() }) // it may have slept
  addEventListener("offline", async () => { if (!(await answers())) lost() }) // a server on this machine stays
  setInterval(look, LOOK)
}

// Whether the server still answers, if it has been silent for long
async function look() {
  const silent = silence()
  if (me.lost || silent < SILENT) return
  if (!(await answers()) || silence() > DEAF) lost()
}

async function answers() {
  const address = document.querySelector('link[href*="/static/style.css"]').href
  try {
    return (await fetch(address, { method: "HEAD", cache: "no-store", signal: AbortSignal.timeout(PATIENCE) })).ok
  } catch {
    return false
  }
}

async function lost() {
  if (me.lost) return
  me.lost = true
  let attempts = 0
  do await pause(PAUSES[attempts++] ?? PAUSES.at(-1))
  while (!(await answers()))
  openAnew()
}

// So many ms, or until the visitor wants it now
const pause = (time) => new Promise((go) => {
  setTimeout(go, time)
  warn("Connection lost:",
    "you can play and scrub; what you change takes effect when the server answers. Trying again … ", go)
})

// The last scene that the server sent, then what was asked for since
function openAnew() {
  let wanted = { ...me.status.address }
  // a picture is newer than the status
  if (me.run?.followed) for (const name in declared.positions) wanted[name] = me.run.scene[name]
  for (const { what, values } of me.waiting) {
    if (what === "scene") Object.assign(wanted, values)
    else wanted = { ...values }
  }
  if (me.status.values) {
    readdress((address) => {
      for (const name of ["preset", "profile", "k", ...Object.keys(me.status.values)]) address.delete(name)
      for (const [name, value] of Object.entries({ ...wanted, ...me.entered })) address.set(name, value)
    })
  }
  const { playing, speed, run } = me, shown = run?.length ? run.place(now()) : null
  keepForTab(AS_IT_WAS, JSON.stringify({ playing, speed, shown, curve: me.laid?.name }))
  location.reload()
}

// What a page opened anew has from the one before; it is used once
export function restore() {
  const kept = takeFromTab(AS_IT_WAS)
  if (!kept) return
  const { playing, speed, shown, curve } = JSON.parse(kept)
  Object.assign(me, { playing, place: shown })
  if (shown) me.following = false
  by("speed").value = speed
  if (curve) import("./later/overlay.js").then(({ askAgain }) => askAgain(curve)) // the server has forgotten it
}
