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

// A button in a figure's caption that opens its numbers
export function offerTable(figure, view, name, open) {
  const button = Object.assign(document.createElement("button"), { type: "button", className: "as-table", title: "As a table", textContent: "▦" })
  button.dataset.view = view
  button.setAttribute("aria-label", `${name}, as a table`)
  button.addEventListener("click", async () => open(await import("./tables.js")))
  figure.querySelector("figcaption")?.append(button)
}
