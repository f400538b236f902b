// The pages beside the experiment: opened and closed here, filled by the server (feature.py). A page may have a script,
// features/NAME/page.js, loaded when the page is first opened, with any of connect() (once), where it adds its charts,
// receive(all that the page has published), also in another look, which is {} as it closes, frame(run, k) with every
// frame, and over(pen, box, run, k) over the punch.

import { order, take } from "../../static/js/channel.js"
import { addPart, charts } from "../../static/js/charts.js"
import { all, by, entries, fetched, one, readdress, root } from "../../static/js/dom.js"
import { connectChart } from "../../static/js/hover.js"
import { alone, declared, embedded, me, memory, redraw, redrawPunch, view } from "../../static/js/store.js"

const modules = {} // {page: its script}, as loaded so far
const SETTLE = 120 // ms; of pages picked in quick succession the last one counts
let sheet = { open: "" } // what the server has told of the open page
let picking = 0
const call = (what, ...values) => modules[sheet.open]?.[what]?.(...values)

export function connect() {
  for (const button of all(".sheet .close")) button.addEventListener("click", closePage)
  for (const button of all(".sheet [data-ask]")) {
    button.addEventListener("click", () => ask({ what: button.dataset.ask }))
  }
  for (const button of all("nav button")) {
    button.addEventListener("click", () => (button.dataset.page ? openPage(button.dataset.page) : closePage()))
  }
  addEventListener("popstate", showAddressed)
  view(["look"], () => call("receive", sheet))
  view(["lost"], () => { // the server makes pages
    if (me.lost) for (const button of all("nav button, [data-ask]")) button.disabled = true
  })
  view(["picture"], () => framePage("frame"))
  addPart("punch", "page", { kind: "drawing", draw: (...punch) => framePage("over", ...punch) })
  view(["look"], closeForProjector)
  take("opened", receive, read)
  if (!alone && !embedded) showAddressed()
}

// Pages have no room on a projector as it begins
const changed = memory()
function closeForProjector() {
  const { view: of } = root.dataset
  if (changed(of) && of === "projector" && shown()) openPage("")
}

// Ask the page that is open for something
export const ask = (values) => order("ask", values)

const shown = () => one(".sheet:not([hidden])")?.id ?? ""

// Open a page, or none, as another entry of the browser's history; wish: what to ask it for then
export function openPage(name, wish = null) {
  if (name === shown()) return
  entries.add((asked) => { if (name) asked.set("page", name); else asked.delete("page") },
    { opened: Boolean(name) && !shown() })
  show(name, wish)
}

// Close the page: back to the entry before it, where opening it was the last change
export const closePage = () => (history.state?.opened ? history.back() : openPage(""))

// The page that the address names, as it is opened and after Back
export function showAddressed() {
  const name = new URLSearchParams(location.search).get("page") ?? ""
  if (!name || by(name)?.classList.contains("sheet")) {
    if (name !== shown()) show(name)
  } else {
    readdress((now) => now.delete("page"))
    order("page", { page: name.slice(0, 64) }) // the server names it in a note
  }
}

function show(name, wish = null) {
  for (const button of all("nav button"))
    button.setAttribute("aria-pressed", button.dataset.page === name)
  for (const section of all(".sheet")) section.hidden = section.id !== name
  if (name) {
    by(name).dataset.drawing = ""
    by(name).scrollIntoView() // on a phone it lies below the experiment
  }
  load(name)
  clearTimeout(picking)
  picking = setTimeout(() => {
    order("page", { page: name })
    if (wish) ask(wish)
  }, SETTLE)
}

// The script of a page, once it is there
async function load(name) {
  if (!declared.scripts_of.includes(name) || name in modules) return
  const script = await fetched(() => import(`../${name}/page.js`))
  if (!script || name in modules) return
  modules[name] = script
  const before = { ...charts }
  script.connect?.()
  for (const added in charts) if (!(added in before)) connectChart(added)
}

// What a message holds, once the script of its page is there
export async function read(message) {
  await load(message.open ?? "")
  return { open: "", ...message }
}

export function receive(news) {
  if (sheet.open !== news.open) {
    call("receive", {})
    sheet = news
    redraw() // in this theme and size, and without what the page before has drawn over the punch
  } else sheet = { ...sheet, ...news }
  for (const id in sheet.texts) by(id).textContent = sheet.texts[id]
  for (const id in sheet.hidden) by(id).hidden = sheet.hidden[id]
  for (const part of by(sheet.open)?.querySelectorAll("progress, [data-ask=cancel]") ?? []) {
    part.hidden = (sheet.busy ?? null) === null
    part.value = sheet.busy ?? 0
  }
  if (news.open) delete by(news.open).dataset.drawing
  call("receive", sheet)
  redrawPunch() // and the page's charts
}

// The increment on screen, for the page
function framePage(what, ...punch) {
  const { run, k } = me.picture ?? {}
  if (run && run === me.run) call(what, ...punch, run, k)
}
