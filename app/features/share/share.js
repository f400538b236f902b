// The sheet of what can be taken away

import { order, take } from "../../static/js/channel.js"
import { charts } from "../../static/js/charts.js"
import { colour } from "../../static/js/colours.js"
import { all, by, download, make, on, one } from "../../static/js/dom.js"
import { digits, fixed } from "../../static/js/quantities.js"
import { framed } from "../../static/js/player.js"
import { opensElsewhere, originForOthers } from "../../static/js/reach.js"
import { declared, me, sees, view as whenever } from "../../static/js/store.js"
import { parameters } from "../../static/js/words.js"

const between = (run) => run.followed || run.checked // its increments lie between states that were solved

// Columns as in `Result.table`: heading, and the value of an increment
const COLUMNS = {
  stage: (run, k) => run.leg(k),
  "U_x (nm)": (run, k) => run.curves.U_x[k], "delta (nm)": (run, k) => run.curves.delta[k],
  "U_x_top (nm)": (run, k) => run.top(k, "U_x"), "delta_top (nm)": (run, k) => run.top(k, "delta"),
  "F (N/m)": (run, k) => run.values(k).F, "L (N/m)": (run, k) => run.values(k).L, "A (nm)": (run, k) => run.values(k).A,
  "residual (nm)": (run, k) => (between(run) ? "" : run.curves.residual[k]),
  evaluations: (run, k) => (between(run) ? "" : run.curves.evaluations[k]),
  slip: (run, k) => (run.curves.slip[k] > 0 ? "True" : "False"),
}
// Columns of the table on screen: heading, and the text of an increment
const CELLS = {
  "Uₓ (nm)": ({ U_x }) => fixed(U_x, 2), "δ (nm)": ({ delta }) => fixed(delta, 2),
  "friction F (N/m)": ({ F }) => digits(F, 4), "load L (N/m)": ({ L }) => digits(L, 4),
  "contact area A (nm)": ({ A }) => digits(A, 4), slip: ({ slip }) => (slip ? "slip" : ""),
}
const LOST = "The server does not answer: it is needed for Python, NPZ and JSON."
let connected = false

// HTML that shows a link in a page of somebody else's
const frameOf = (link) =>
  make("iframe", { src: `${link}${link.includes("?") ? "&" : "?"}embed=1`, width: 960, height: 600 }).outerHTML

// Views that are on screen: [name, title]
const views = () => Object.entries(charts).flatMap(([name, { view }]) => (
  view.clientWidth && view.clientHeight ? [[name, titleOf(view)]] : []))
const captionOf = (view) => view.closest("figure")?.querySelector("figcaption")
const titleOf = (view) => (captionOf(view)?.querySelector("b") ?? captionOf(view))?.textContent.trim() ?? "view"

// A view as it is on screen
export async function png(name) {
  const drawn = charts[name].canvas, { width, height } = drawn
  const canvas = make("canvas", { width, height }), pen = canvas.getContext("2d")
  pen.fillStyle = colour("--page")
  pen.fillRect(0, 0, width, height)
  pen.drawImage(drawn, 0, 0)
  return new Promise((done) => canvas.toBlob(done, "image/png"))
}

// Of single precision
const shown = (value) => (typeof value === "number" ? `${Number(value.toPrecision(7))}` : value)

const afterApproach = (run) => run.curves.stage.map((_, k) => k).filter((k) => k >= run.sheared)

// A comment with the scene, then a row per increment after the approach
export function csv(run) {
  const rows = afterApproach(run).map((k) => Object.values(COLUMNS).map((value) => shown(value(run, k))).join(","))
  return [`# ${parameters()}`, Object.keys(COLUMNS).join(","), ...rows, ""].join("\n")
}

function showTable() {
  const head = make("tr", {}, ...Object.keys(CELLS).map((text) => make("th", { scope: "col" }, text)))
  const rows = afterApproach(me.run).map((k) => (
    make("tr", {}, ...Object.values(CELLS).map((cell) => make("td", {}, cell(me.run.values(k)))))))
  const table = make("table", {}, make("thead", {}, head), make("tbody", {}, ...rows))
  by("table").querySelector(".rows").replaceChildren(table)
  by("table").showModal()
}

const say = (text) => { by("share-status").textContent = text }
const save = (blob, ending) => say(`saved ${download(blob, ending)}`)

// Browsers lend the clipboard to secure pages only, and may never answer: then the old way
async function copy(field, what) {
  field.select()
  const late = new Promise((_, fail) => setTimeout(fail, 1000))
  const write = async () => navigator.clipboard.writeText(field.value)
  const copied = await Promise.race([write(), late]).then(() => true, () => document.execCommand("copy"))
  say(copied ? `${what} copied` : `The browser forbids copying. The ${what} is selected: press Ctrl+C.`)
}

// With the frames of the solver
async function saveCurves() {
  if (between(me.run)) say("computing the run, increment by increment …")
  await framed()
  save(new Blob([csv(me.run)], { type: "text/csv" }), ".csv")
}

function showFile({ why, ending, body }) {
  if (why) say(why)
  else save(new Blob([body]), `.${ending}`)
  one(`[data-file=${ending}]`).disabled = false
}

function showSheet({ link, qr, python }) {
  if (link !== by("share-link").value) return
  if (qr && opensElsewhere()) for (const code of all(".qr img")) code.src = qr
  by("enlarge-qr").hidden = !qr || !opensElsewhere()
  by("share-python").value = python
  by("share-python").rows = python.split("\n").length
}

// The address of what is on screen now, for others
function linkTo() {
  const page = one(".sheet:not([hidden])")?.id, url = new URL(location.pathname, originForOthers())
  for (const name in me.status.address) url.searchParams.set(name, me.status.address[name])
  if (me.drawn >= 0) url.searchParams.set("k", me.drawn)
  if (page) url.searchParams.set("page", page)
  if (sees("more")) url.searchParams.set("more", "1")
  return url.href
}

function connect() {
  connected = true
  take("file", showFile)
  take("shared", showSheet)
  whenever(["lost"], () => { if (me.lost) say(LOST) })
  const view = by("share-view")
  on("copy-link", "click", () => copy(by("share-link"), "link"))
  on("copy-frame", "click", () => copy(by("share-frame"), "HTML"))
  on("copy-python", "click", () => copy(by("share-python"), "Python lines"))
  on("save-png", "click", async () => save(await png(view.value), `-${view.value}.png`))
  on("show-table", "click", showTable)
  on("save-csv", "click", saveCurves)
  on("enlarge-qr", "click", () => by("qr").showModal())
  for (const button of all("[data-file]")) {
    button.addEventListener("click", () => {
      say("computing the run once more, in full precision …")
      button.disabled = true
      order("export", { kind: button.dataset.file })
    })
  }
}

export function open() {
  if (!connected) connect()
  const link = linkTo()
  by("share-link").value = link
  by("share-frame").value = frameOf(link)
  by("share-view").replaceChildren(...views().map(([name, title]) => new Option(title, name)))
  const { address } = me.status
  const sentences = []
  if (address.profile)
    sentences.push("The link shows the measured profile only while this server keeps it; the JSON has it.")
  if (me.lost) sentences.push(LOST)
  for (const what of all("#copy-python, [data-file]")) what.disabled = me.lost
  by("share-python").value = "" // of the run before, until the server answers
  by("enlarge-qr").hidden = true
  by("qr-link").textContent = link
  const elsewhere = opensElsewhere(), [[, command = ""] = []] = declared.reach.commands
  by("share-here").hidden = elsewhere
  by("share-command").textContent = command
  by("share-start").hidden = !command
  if (!me.run?.whole) sentences.push("The run is still being computed: CSV and pictures hold what there is.")
  say(sentences.join(" "))
  order("share", { link })
  by("share").showModal()
}
