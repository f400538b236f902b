// The pages beside the experiment: opened and closed here, filled by the server (app/pages). A page may have a script,
// app/pages/NAME/page.js, loaded when the page is first opened, with any of connect() (once), where it adds its charts,
// receive(all that the page has published), also in another look, which is {} as it closes, frame(run, k) with every
// frame, and over(pen, box, run, k) over the punch.

import { ask, order } from "./channel.js"
import { addEntry, viewed } from "./address.js"
import { charts, CURVES } from "./charts.js"
import { by, fetched, readdress } from "./dom.js"
import { goto } from "./player.js"
import { declared, me, redraw, redrawPunch, view } from "./store.js"

const modules = {} // {page: its script}, as loaded so far
const SETTLE = 120 // ms; of pages picked in quick succession the last one counts
let sheet = { open: "" } // what the server has told of the open page
let picking = 0
const call = (what, ...values) => modules[sheet.open]?.[what]?.(...values)

export function connect() {
  for (const button of document.querySelectorAll(".sheet .close")) button.addEventListener("click", closePage)
  for (const button of document.querySelectorAll(".sheet [data-ask]")) {
    button.addEventListener("click", () => ask({ what: button.dataset.ask }))
  }
  for (const link of document.querySelectorAll("nav a")) link.addEventListener("click", bringScene)
  addEventListener("popstate", showAddressed)
  view(["look"], () => call("receive", sheet))
  view(["picture"], () => framePage("frame"))
  for (const name in charts) connectChart(name)
  charts.punch.fill("page", { draw: (...punch) => framePage("over", ...punch) })
}

// A research page opens with the scene on screen; back from there this page is as it was, in its class
function bringScene({ currentTarget: link }) {
  const { theme } = document.documentElement.dataset
  link.search = new URLSearchParams({ ...viewed(), lab: link.dataset.lab, theme, ...me.status.address })
}

const shown = () => document.querySelector(".page").dataset.page

// Open a page, or none, as another entry of the browser's history; wish: what to ask it for then
export function openPage(name, wish = null) {
  if (name === shown()) return
  addEntry((asked) => { if (name) asked.set("page", name); else asked.delete("page") },
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
  document.querySelector(".page").dataset.page = name
  for (const button of document.querySelectorAll("nav button"))
    button.setAttribute("aria-pressed", button.dataset.page === name)
  for (const section of document.querySelectorAll(".sheet")) section.hidden = section.id !== name
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
  if (!declared.scripts.includes(name) || name in modules) return
  const script = await fetched(() => import(`../../pages/${name}/page.js`))
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

const resized = new ResizeObserver(redraw) // what rests is drawn anew, in the size of the text there

// Beside the mouse a chart says what is there. On a curve of the run, that increment is shown in every view while
// playback rests, and a click goes there
function connectChart(name) {
  const chart = charts[name], { view: surface } = chart, curve = CURVES.includes(name)
  resized.observe(surface)
  const px = (event) => {
    const { left, top } = surface.getBoundingClientRect()
    return { x: event.clientX - left, y: event.clientY - top }
  }
  const there = (at) => (me.run?.sheared >= 0 && chart.box ? me.run.nearest(chart.placeOf(at).x, me.at) : null)
  const point = (at) => {
    me.pointed = at && { name, ...at }
    if (curve && (at === null || !me.playing)) me.preview = at && there(at)
  }
  surface.addEventListener("pointermove", (event) => { if (event.pointerType !== "touch") point(px(event)) })
  surface.addEventListener("pointerleave", () => point(null))
  if (!curve) return
  surface.addEventListener("click", (event) => {
    const k = there(px(event))
    if (k !== null) goto(k)
  })
}
