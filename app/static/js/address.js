// The address of the page: it brings scene, increment and page back, and each settled change is an entry of the
// browser's history, so that Back undoes. While a page is open Back closes it.

import { by, lastSearch, on, readdress } from "./dom.js"
import { goto } from "./player.js"
import { restore } from "./steer.js"
import { beginChange, me, view } from "./store.js"

const REST = 250 // ms for which an increment must be looked at before the address names it
const LARGEST = 1e6

let written = null // the scene in the address, as text; null before it is known to be that of the status
let writtenOf = null // the move of which the address has something
let entry = history.state?.entry ?? 0, top = entry // number of this entry of the history, and of the last
let resting = 0
let undoing = false // Back was asked for by Undo, not by the browser's button
let wanted = asked() // the increment to go to once the run is there
let wantedOf = me.move // unless parameters have been changed since

function asked() {
  const text = new URLSearchParams(location.search).get("k")
  return /^\d+$/.test(text ?? "") && Number(text) < LARGEST ? Number(text) : null
}

const sceneNames = () => ["preset", "profile", ...Object.keys(me.status.values)]

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

export function writeAddress() {
  if (!me.status.values) return
  const { address } = me.status, text = JSON.stringify(address)
  if (text === written) return
  const sameMove = written && writtenOf === me.move && difference(JSON.parse(written), address) === me.move.name
  const push = written !== null && !sameMove
    && !["wait", "ask", "show", "why"].includes(document.documentElement.dataset.tour)
  if (push) top = ++entry
  readdress((now) => {
    for (const name of sceneNames()) now.delete(name)
    for (const name in address) now.set(name, address[name])
  }, push ? { entry } : { ...history.state, entry }, push)
  written = text
  writtenOf = me.move
  tellHistory()
}

// Another entry of the history, for what is no change of the scene; more: of its state
export function addEntry(change, more) {
  top = ++entry
  readdress(change, { entry, ...more }, true)
  tellHistory()
}

export const undo = () => {
  if (entry <= 0) return
  undoing = true
  history.back()
}
export const redo = () => { if (entry < top) history.forward() }

function tellHistory() {
  by("undo").disabled = entry <= 0
  by("redo").disabled = entry >= top
}

// Show the scene of parameters {name: text} as an address has them, and an increment of it
export function goBackTo(scene, k = null) {
  beginChange()
  restore(scene)
  wanted = k
  wantedOf = me.move
}

// beside the scene: going back leaves them as they are
const VIEWED = ["theme", "embed", "tour", "view", "pin", "force"]
const openedPage = () => document.querySelector(".page").dataset.page
let pinned = new URLSearchParams(location.search).getAll("pin") // still to be brought back
function popped(event) {
  if (event.state?.entry === undefined) return
  const closing = openedPage() && !undoing && event.state.entry < entry // Back closes a page and undoes nothing
  entry = event.state.entry
  undoing = false
  const k = asked(), before = lastSearch(), seen = [...new URLSearchParams(before)]
  const same = !me.status.values || !difference(sceneOf(before), sceneOf(location.search))
  const kept = closing ? [...VIEWED, "k", ...sceneNames()] : same ? [...VIEWED, "k"] : VIEWED
  readdress((now) => {
    for (const name of kept) now.delete(name)
    for (const [name, text] of seen) if (kept.includes(name)) now.append(name, text)
    if (closing) now.delete("page")
  })
  if (!same && !closing) {
    written = null
    goBackTo(sceneOf(location.search), k)
  }
  tellHistory()
}

// The increment at rest goes into the address
function tellIncrement() {
  const { run, drawn: k } = me
  if (k < 0) return
  const url = new URLSearchParams(location.search)
  clearTimeout(resting)
  if (me.playing && wanted === null && url.has("k")) readdress((now) => now.delete("k"))
  if (me.playing || me.following || me.preview !== null || wanted !== null || !run.whole || run.followed
    || me.status.state === "refining") return
  resting = setTimeout(() => readdress((now) => now.set("k", k)), REST)
}

// Once the run is whole: to the increment that was asked for, and then what else there was beside the run
export function goToAsked() {
  if (!me.run?.length || !["finished", "skipped", "failed"].includes(me.status.state)) return
  const k = wanted, texts = pinned
  wanted = null
  pinned = []
  if (k !== null && wantedOf === me.move) goto(k)
  if (texts.length) import("./later/pins.js").then(({ fromLink }) => fromLink(texts))
}

// The address of what is on screen now, for others; more: further parameters [[name, text], ...]
export function linkTo(more = []) {
  const url = new URL(location.pathname, location.origin), page = openedPage()
  for (const name in me.status.address) url.searchParams.set(name, me.status.address[name])
  if (me.drawn >= 0) url.searchParams.set("k", me.drawn)
  if (page) url.searchParams.set("page", page)
  for (const [name, text] of more) url.searchParams.append(name, text)
  return url.href
}

export function connect() {
  readdress(() => {}, { ...history.state, entry }) // so that Back comes to it
  view(["drawn", "run", "playing", "following", "preview", "status"], tellIncrement)
  addEventListener("popstate", popped)
  on("undo", "click", undo)
  on("redo", "click", redo)
  tellHistory()
}
