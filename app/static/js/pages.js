// The pages beside the experiment: opened and closed here, filled by the server (app/views/pages.py). A page may have
// a module, with any of connect(), opened(), told(news), frame(run, k), painted(), closed().

import { ask, order } from "./channel.js"
import { by, makeButton, makeRow, minus, readdress } from "./dom.js"
import { adopt, drawn, forget, paint, shade } from "./figures.js"
import * as fit from "./pages/fit.js"
import * as law from "./pages/law.js"
import * as matters from "./pages/matters.js"
import * as regimes from "./pages/regimes.js"
import * as solid from "./pages/solid.js"
import * as stickslip from "./pages/stickslip.js"
import { me } from "./state.js"

const modules = { law, stickslip, solid, matters, regimes, fit }
const SETTLE = 120 // ms; of pages picked in quick succession the last one counts
let slots = {} // figure: where it goes
let sheet = { open: "", figures: [] } // what the server said last of the page that is open
let picking = 0
export const slot = (name) => slots[name]
const call = (what, ...values) => modules[sheet.open]?.[what]?.(...values)

export function connect(given) {
  slots = given
  for (const name in modules) modules[name].connect?.()
  for (const button of document.querySelectorAll(".sheet [data-ask]")) {
    button.addEventListener("click", () => ask({ what: button.dataset.ask }))
  }
}

export function openAsked() {
  const asked = new URLSearchParams(location.search).get("page")
  if (asked) openPage(by(asked)?.classList.contains("sheet") ? asked : "")
}

export function openPage(name) {
  document.querySelector(".page").dataset.page = name
  for (const button of document.querySelectorAll("nav button")) button.setAttribute("aria-pressed", button.dataset.page === name)
  for (const section of document.querySelectorAll(".sheet")) section.hidden = section.id !== name
  if (name) by(name).dataset.drawing = ""
  readdress((asked) => { if (name) asked.set("page", name); else asked.delete("page") })
  clearTimeout(picking)
  picking = setTimeout(() => order("page", { page: name }), SETTLE)
}

export function told(text) {
  const news = { open: "", figures: [], ...JSON.parse(text) }
  if (sheet.open !== news.open) {
    call("closed")
    sheet.figures.forEach(forget)
    sheet = news
    for (const name of sheet.figures) adopt(name, slots[name].children[0])
    paint()
    call("opened")
    awaitFigures(sheet.open)
  }
  sheet = news
  for (const id in sheet.texts) by(id).textContent = sheet.texts[id]
  for (const id in sheet.hidden) by(id).hidden = sheet.hidden[id]
  for (const id in sheet.tables) by(id).replaceChildren(...sheet.tables[id].map((cells) => makeRow(cells.map(cellOf))))
  shadeImages()
  for (const part of by(sheet.open)?.querySelectorAll("progress, [data-ask=cancel]") ?? []) {
    part.hidden = (sheet.busy ?? null) === null
    part.value = sheet.busy ?? 0
  }
  call("told", sheet)
  framePage()
}

const cellOf = (cell) => (typeof cell === "string" ? minus(cell)
  : makeButton({ "aria-pressed": cell.pressed, onclick: () => ask(cell.ask) }, cell.said))

// Until the figures are on screen, the page says so
function awaitFigures(name) {
  if (!name || sheet.open !== name) return
  if (drawn(sheet.figures)) delete by(name).dataset.drawing
  else requestAnimationFrame(() => awaitFigures(name))
}

function shadeImages() {
  for (const name in sheet.images) shade(...name.split("."), ...sheet.images[name])
}

// The increment on screen, for the page
export function framePage() {
  if (me.run?.length && me.drawn >= 0) call("frame", me.run, Math.min(me.drawn, me.run.length - 1))
}

export function paintPage() {
  shadeImages()
  call("painted")
}
