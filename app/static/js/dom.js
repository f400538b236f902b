// Elements of the page, its address, and how numbers are written.

export const by = (id) => document.getElementById(id)
export const on = (id, event, call) => by(id).addEventListener(event, call)
export const minus = (text) => `${text}`.replace("-", "−")
export const fixed = (value, digits) => minus((Math.round(value * 10 ** digits) / 10 ** digits).toFixed(digits))

// Text with a paragraph of its own, which is there only while there is something to say
export function say(id, text) {
  by(id).hidden = !text
  by(id).textContent = text ?? ""
}

// Change the parameters of the address in the browser's bar
export function readdress(change) {
  const address = new URL(location.href)
  change(address.searchParams)
  if (address.href !== location.href) history.replaceState(history.state, "", address)
}

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

// A button in a figure's caption that opens its numbers
export function offerTable(figure, view, name, open) {
  const onclick = async () => open(await import("./tables.js"))
  figure.querySelector("figcaption")?.append(makeButton({ className: "as-table", title: "As a table", data: { view }, "aria-label": `${name}, as a table`, onclick }, "▦"))
}
