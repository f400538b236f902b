// The connection with the server. Once it is lost, changes of the scene wait, and pages are locked; when the server
// answers the page is loaded again as it was: parameters and what was asked for since in its address, the increment
// shown beside it.

import { isThere, silence } from "../../static/js/channel.js"
import { by, keepForTab, one, readdress, takeFromTab } from "../../static/js/dom.js"
import { warn } from "../../static/js/opening.js"
import { CARRIED, declared, me, now } from "../../static/js/store.js"

const LOOK = 1000 // ms between two looks at orders without an answer
const SILENT = 4000 // ms without one, after which the server is asked whether it is there
const DEAF = 12000 // ms: it is, but this page is not heard any more
const PATIENCE = 3000 // ms it has to say so
// ms between attempts, the last again and again: a class must not wait long, nor a server be stormed
const PAUSES = [500, 1000, 2000]
const AS_IT_WAS = "as it was"

export function connect() {
  restore()
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
  const address = one('link[href*="/static/all.css"]').href
  try {
    return (await fetch(address, { method: "HEAD", cache: "no-store", signal: AbortSignal.timeout(PATIENCE) })).ok
  } catch {
    return false
  }
}

async function lost() {
  if (me.lost || !isThere()) return
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
      for (const name of ["k", ...declared.scene]) address.delete(name)
      for (const [name, value] of Object.entries({ ...wanted, ...me.entered })) address.set(name, value)
    })
  }
  const { playing, speed, run } = me, shown = run?.length ? run.place(now()) : null
  keepForTab(AS_IT_WAS, JSON.stringify({ playing, speed, shown, carried: gives() }))
  location.reload()
}

// What features take along: {name: what it gives}
const gives = () => Object.fromEntries(Object.entries(CARRIED).map(([name, { give }]) => [name, give()]))

// What a page opened anew has from the one before; it is used once
function restore() {
  const kept = takeFromTab(AS_IT_WAS)
  if (!kept) return
  const { playing, speed, shown, carried } = JSON.parse(kept)
  Object.assign(me, { playing, place: shown })
  if (shown) me.following = false
  by("speed").value = speed
  for (const name in carried) CARRIED[name]?.take(carried[name])
}
