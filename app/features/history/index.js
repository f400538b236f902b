// The address of the page: it brings scene, increment and page back, and each settled change is an entry of the
// browser's history, so that Back goes to the change before. While a page is open Back closes it.

import { outdated } from "../../static/js/channel.js"
import { by, entries as adding, lastSearch, one, readdress } from "../../static/js/dom.js"
import { goto } from "../../static/js/player.js"
import { restore } from "../../static/js/steer.js"
import { beginChange, declared, ended, me, view } from "../../static/js/store.js"

const REST = 250 // ms for which an increment must be looked at before the address names it

// The entries of the browser's history that belong to this page, and the scene in the address
class Entries {
  now = history.state?.entry ?? 0 // number of the one shown
  scene = null // of the address, as text; null before it is known to be that of the status
  move = null // the move of the user's that led to it

  // Change the parameters of the address, in an entry of its own or in the present one; more: of its state
  write(change, { own = false, more = {} } = {}) {
    if (own) this.now++
    readdress(change, own ? { entry: this.now, ...more } : { ...history.state, entry: this.now }, own)
  }

  // Change the scene {name: text}; each move of the user's is one entry. A question of the tour is none
  writeScene(address) {
    const text = JSON.stringify(address), before = this.scene
    if (text === before || (me.tour && me.lesson?.ask)) return // the address of that question asks for more
    const goesOn = this.move === me.move && before && difference(JSON.parse(before), address) === me.move.name
    const ofTour = ["wait", "ask", "show", "why"].includes(me.tour)
    this.write((now) => {
      for (const name of sceneNames()) now.delete(name)
      for (const name in address) now.set(name, address[name])
    }, { own: before !== null && !goesOn && !ofTour })
    Object.assign(this, { scene: text, move: me.move })
  }

  // The browser went to another one; whether it went back
  moved(to) {
    const back = to < this.now
    this.now = to
    return back
  }
}
const entries = new Entries()

let resting = 0
let wanted = asked() // the increment to go to once the run is there
let wantedOf = me.move // unless parameters have been changed since

function asked() {
  const text = new URLSearchParams(location.search).get("k")
  return /^\d+$/.test(text ?? "") ? Number(text) : null
}

const sceneNames = () => declared.scene

// Parameters of an address that make up the scene
export function sceneOf(search) {
  const names = new Set(sceneNames())
  return Object.fromEntries([...new URLSearchParams(search)].filter(([name]) => names.has(name)))
}

// The names that differ between two scenes
function difference(a, b) {
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].filter((name) => a[name] !== b[name]).toSorted().join()
}

// Whether the address has another scene than the page
export const sceneChanges = () => difference(sceneOf(location.search), me.status.address) !== ""

// Once the controls show what the server sent, as it shows the run
function writeAddress() {
  const { status } = me
  if (!status.values || me.waiting.length || me.entered || outdated(status)) return
  if (status.frames > 0 && !me.dragging) entries.writeScene(status.address)
}

// Another entry of the history, for what is no change of the scene; more: of its state
adding.add = (change, more) => entries.write(change, { own: true, more })

// Show the scene of parameters {name: text} as an address has them, and an increment of it
export function goBackTo(scene, k = null) {
  beginChange()
  restore(scene)
  wanted = k
  wantedOf = me.move
}

// beside the scene: going back leaves them as they are
const viewed = () => declared.viewed.filter((name) => !["k", "page"].includes(name))
// Whether the address opens more than the page as it is: a scene, an increment, a page of the menu
const namesScene = () => [...new URLSearchParams(location.search).keys()].some((name) => !viewed().includes(name))
const openedPage = () => one(".sheet:not([hidden])")?.id

// The browser went back or forward. Where a page is open, Back closes it and changes nothing else
function popped(event) {
  if (event.state?.entry === undefined) return
  const closes = entries.moved(event.state.entry) && openedPage(), before = lastSearch(), k = asked()
  const restores = !closes && me.status.values && difference(sceneOf(before), sceneOf(location.search)) !== ""
  const kept = [...viewed(), ...(restores ? [] : ["k"]), ...(closes ? sceneNames() : [])]
  readdress((now) => {
    for (const name of kept) now.delete(name)
    for (const [name, text] of new URLSearchParams(before)) if (kept.includes(name)) now.append(name, text)
    if (closes) now.delete("page")
  })
  if (restores) {
    entries.scene = null
    goBackTo(sceneOf(location.search), k)
  }
}

// The increment at rest goes into the address
function tellIncrement() {
  const { run, drawn: k } = me
  if (k < 0) return
  clearTimeout(resting)
  if (me.playing && wanted === null && new URLSearchParams(location.search).has("k"))
    readdress((now) => now.delete("k"))
  const moves = me.playing || me.following || me.preview !== null || wanted !== null
  const settles = !run.whole || run.followed || me.status.state === "refining"
  if (moves || settles) return
  resting = setTimeout(() => readdress((now) => now.set("k", k)), REST)
}

// Once the run is whole: to the increment that was asked for
function goToAsked() {
  if (!me.run?.length || !ended()) return
  const k = wanted
  wanted = null
  if (k !== null && wantedOf === me.move) goto(k)
}

export function connect() {
  if (namesScene()) by("grab").hidden = true
  view(["status", "dragging", "waiting", "entered"], writeAddress)
  view(["status"], goToAsked)
  entries.write(() => {}) // so that Back comes to it
  view(["drawn", "run", "playing", "following", "preview", "status"], tellIncrement)
  addEventListener("popstate", popped)
}
