// Elements of the page, its address, and what the browser keeps of it.

// What holds this page; in a layout of somebody else's, another element (app/bundle.py)
export const root = document.documentElement
export const one = (selector) => root.querySelector(selector)
export const all = (selector) => root.querySelectorAll(selector)
export const by = (id) => (id ? one(`#${CSS.escape(id)}`) : null)
export const focused = () => root.getRootNode().activeElement
export const on = (id, event, call) => by(id).addEventListener(event, call)
// Where in a list the number nearest to a value is
export const closest = (list, value) => (
  list.reduce((best, v, i) => (Math.abs(v - value) < Math.abs(list[best] - value) ? i : best), 0))

// What a pointer does from where it goes down on an element: begin(event) tells what is held, if anything
export function onDrag(element, begin, move, end = () => {}) {
  let held = null
  const drop = () => { if (held) end(held); held = null }
  element.addEventListener("pointerdown", (event) => { held = begin(event) })
  element.addEventListener("pointermove", (event) => { if (held) move(event, held) })
  for (const name of ["pointerup", "pointercancel"]) element.addEventListener(name, drop)
}

// Write what an element says, if it says another thing
export const tell = (element, text) => { if (element.textContent !== text) element.textContent = text }

// A script that is loaded when it is needed; undefined where it does not arrive
export const fetched = (importing) => importing().catch(() =>
  say("notes", "A part of the page did not arrive. Check the connection, then reload the page."))

// Text with a paragraph of its own, which is there only while there is something to say
export function say(id, text) {
  by(id).hidden = !text
  tell(by(id), text || "")
}

// Change the parameters of the address in the browser's bar; push: as another entry of its history
let written = location.search
export const lastSearch = () => written // its text before the browser went back
export function readdress(change, state = history.state, push = false) {
  if ("placed" in root.dataset) return // the address is that of somebody else's page
  const address = new URL(location.href)
  change(address.searchParams)
  if (push || address.href !== location.href || state !== history.state)
    history[push ? "pushState" : "replaceState"](state, "", address)
  written = address.search
}

// Another entry of the browser's history, with a change of the address; state: of the entry
export const entries = { add: (change, state) => readdress(change, state, true) }

// An element with properties, attributes where they have a hyphen, and `data` of its own; and what it holds
export function make(tag, { data = {}, ...given } = {}, ...parts) {
  const made = document.createElement(tag)
  for (const name in given) if (name.includes("-")) made.setAttribute(name, given[name]); else made[name] = given[name]
  Object.assign(made.dataset, data)
  made.append(...parts)
  return made
}
export const makeButton = (given, ...parts) => make("button", { type: "button", ...given }, ...parts)

// A shape of a drawing with its attributes, and what it holds
export function makeShape(tag, attributes, ...parts) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag)
  for (const name in attributes) made.setAttribute(name, attributes[name])
  made.append(...parts)
  return made
}

// Save a Blob as a file with this ending; returns its name
export function download(blob, ending) {
  const name = `mixed-mode-contact${ending}`, link = make("a", { href: URL.createObjectURL(blob), download: name })
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000)
  return name
}

// What the browser keeps, in the tab or for good. It may forbid that, as for pages in frames of other sites: then
// nothing is kept, and each visit begins as the first one
function attempt(call) {
  try {
    return call()
  } catch {
    return null
  }
}

export const kept = (name) => attempt(() => localStorage.getItem(name))
export const keep = (name, value) => attempt(() => localStorage.setItem(name, value))

// Of the tab, for once
export const keepForTab = (name, value) => attempt(() => sessionStorage.setItem(name, value))
export const takeFromTab = (name) => attempt(() => {
  const value = sessionStorage.getItem(name)
  sessionStorage.removeItem(name)
  return value
})
