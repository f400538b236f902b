// The pages beside the experiment: opened and closed here, filled by the server (pages.py); a page's script joins in.

const sheets = {} // page: {opened(), told(news), frame(run, k), painted(), closed()}, whatever it needs of these
let sheet = { open: "" } // what the server said last of the page that is open
const busy = () => by(sheet.open)?.querySelector("progress")

function openPage(name) {
  showSheet(name)
  if (name) by(name).dataset.drawing = ""
  const address = new URL(location.href)
  name ? address.searchParams.set("page", name) : address.searchParams.delete("page")
  history.replaceState(null, "", address)
  clearTimeout(picking)
  picking = setTimeout(() => order("page", { page: name }), SETTLE)
}
const SETTLE = 120 // ms; of pages picked in quick succession the last one counts
let picking = 0

// Ask the page that is open for something
let asks = 0
const ask = (values) => { wire.order = JSON.stringify({ do: "ask", values, ask: asks++ }) }

function showSheet(name) {
  document.querySelector(".page").dataset.page = name
  for (const button of document.querySelectorAll("nav button")) button.setAttribute("aria-pressed", button.dataset.page === name)
  for (const section of document.querySelectorAll(".sheet")) section.hidden = section.id !== name
}

function toldOfPage() {
  const before = sheet
  sheet = { open: "", ...JSON.parse(wire.page) }
  if (before.open !== sheet.open) {
    forgetFigures(before)
    sheets[before.open]?.closed?.()
    if (sheet.open) {
      findFigures()
      sheets[sheet.open]?.opened?.()
      awaitFigures(sheet.open)
    }
  }
  for (const id in sheet.texts) by(id).textContent = sheet.texts[id]
  for (const name in sheet.images) shadeImage(name, sheet.images[name])
  const bar = busy()
  if (bar) {
    bar.hidden = (sheet.busy ?? null) === null
    bar.value = sheet.busy ?? 0
  }
  sheets[sheet.open]?.told?.(sheet)
  if (sheet.open) framePage()
}

// The figures of a page are made after the document: they are found by their names
function findFigures() {
  const models = new Map([...Bokeh.documents[0]._all_models.values()].filter((m) => m.name).map((m) => [m.name, m]))
  for (const view in sheet.parts) {
    figure[view] = models.get(view)
    part[view] = Object.fromEntries(sheet.parts[view].map((label) => [label, models.get(`${view}.${label}`)]))
    tints[view] = sheet.colours[view]
  }
  paint()
}

// Until the figures are on screen, the page says so
function awaitFigures(name) {
  if (sheet.open !== name) return
  const there = Object.keys(sheet.parts).every((view) => Bokeh.index.find_one(figure[view])?.has_finished())
  there ? delete by(name).dataset.drawing : requestAnimationFrame(() => awaitFigures(name))
}

function forgetFigures({ parts }) {
  for (const view in parts) {
    delete figure[view]
    delete part[view]
    delete tints[view]
  }
}

const shadesOf = {} // "view.label": for which limits and theme it has its shades
function shadeImage(name, [low, high]) {
  const [view, label] = name.split(".")
  const mapper = part[view]?.[label]?.glyph.color_mapper
  const key = [low, high, document.documentElement.dataset.theme, mapper?.id].join()
  if (!mapper || shadesOf[name] === key) return
  shadesOf[name] = key
  mapper.setv(shades(low, high), here)
  tellLimits(view, low, high)
}

// The increment on screen, for the page
function framePage() {
  if (me.run?.length && me.drawn >= 0) sheets[sheet.open]?.frame?.(me.run, Math.min(me.drawn, me.run.length - 1))
}

function paintPage() {
  for (const name in sheet.images) shadeImage(name, sheet.images[name])
  sheets[sheet.open]?.painted?.()
}
