// The dialog about a file: its first rows with menus over the columns, the kind of data, and the part that is used. The
// server says what it sees in the file (`tasks.look`) after each choice.

import { order, take } from "../../static/js/channel.js"
import { by, focused, make, makeButton, makeShape, on, one, say, tell } from "../../static/js/dom.js"
import { digits } from "../../static/js/quantities.js"
import { me } from "../../static/js/store.js"
import { AXES, lay, prepare } from "./laid.js"

const PIECE = 2 ** 19, LARGEST = 20e6 // bytes
const WIDE = 300, HIGH = 100, STEPS = 10_000 // of the drawing; of its handles
const SIGNS = [["1", "1: as in the file"], ["-1", "−1: turned"]]
const CHOOSE = ["", "choose …"], OTHER = "other", TEXTS = ["line", "spacing", "unit"]
const FIELDS = [...TEXTS, "speed", "deflection", "cut_off"]
let file = null, turn = 0 // what is read; counts questions to the server, so that late answers are dropped
let chosen = {}, seen = {} // fields of tasks.Chosen; what the server said last
let other = null // the column whose unit is being written
let arrived = () => {} // called when the server has a piece

// Send a file, and ask about it; given: kind, or earlier choices
export async function open(given, { left = 0, ...before } = {}) {
  if (!by("file-of")) connect()
  const mine = ++turn
  file = given
  chosen = before
  seen = {}
  show({})
  for (const field of FIELDS) by(`file-${field}`).value = before[field] ?? ""
  tell(by("file-title"), file.name)
  say("file-others", left ? `One file is read at a time: ${left} more left out.` : "")
  if (!by("file-of").open) by("file-of").showModal()
  try {
    if (me.lost) throw new Error("the server does not answer; choose the file again when it does")
    if (!file.size) throw new Error("it is empty; choose a file with columns of numbers")
    if (file.size > LARGEST)
      throw new Error(`it has ${(file.size / 1e6).toFixed(1)} MB, allowed: 20 MB; thin it out`)
    if (await send(given, () => mine === turn)) ask()
  } catch ({ message }) {
    if (mine === turn) show({ why: message })
  }
}

// Send the pieces one after another, while the file is still wanted; returns whether all are there
async function send(given, wanted) {
  const { size } = given, bar = by("file-sent")
  bar.hidden = false
  for (let at = 0; at < size; at += PIECE) {
    bar.value = at / size
    const piece = given.slice(at, at + PIECE), content = await piece.arrayBuffer().catch(() => null)
    if (content?.byteLength !== piece.size)
      throw new Error("it has changed, or cannot be read any more; choose it again")
    if (!wanted()) return false
    const there = new Promise((done) => { arrived = done })
    order("piece", { at, of: size, content })
    await there
  }
  return wanted()
}

function ask(more = {}) {
  by("file-sent").hidden = false
  by("file-sent").removeAttribute("value")
  order("choice", { turn: ++turn, ...chosen, ...more })
}

function choose(values) {
  chosen = Object.fromEntries(Object.entries({ ...chosen, ...values }).filter(([, value]) => value !== null))
  ask()
}

function use() {
  lay.name = file.name
  ask({ use: true })
}

function receive({ got, turn: answered, file: given }) {
  if (got) return arrived()
  if (answered !== turn || !file) return
  if (given.used) {
    if (given.used !== "surface") lay.again = { file, ...chosen }
    return by("file-of").close()
  }
  show(given)
  // the first answer: where something is missing, at the first menu
  if (by("file-of").contains(focused()) && focused().closest(".top"))
    (given.says ? by("file-use") : by("file-kind")).focus()
}

// Its options, where they are others than before: a menu that is open stays
function fill(menu, list, value) {
  if (menu.dataset.list !== `${list}`)
    menu.replaceChildren(...list.map(([name, text]) => make("option", { value: name }, text)))
  menu.dataset.list = `${list}`
  menu.value = value ?? ""
}

// A reason as a sentence; symbols such as x stay small
const sentence = (text = "") =>
  text.replace(/^[a-z](?=[a-z])/, (letter) => letter.toUpperCase()) + (/^$|[.?]$/.test(text) ? "" : ".")

// Everything that the server says about the file
function show(given) {
  seen = { channels: seen.channels, ...given } // sent only by the refusal that asks
  by("file-sent").hidden = true
  const { fields = {} } = seen
  for (const [name, list, value] of [["kind", seen.kinds, seen.kind], ["channel", seen.channels, chosen.channel]]) {
    fill(by(`file-${name}`), [CHOOSE, ...Object.entries(list ?? {})], value)
    by(`file-${name}`).parentNode.hidden = !list
  }
  for (const field of FIELDS) {
    by(`file-${field}`).parentNode.hidden = !fields[field]
    by(`file-${field}`).previousSibling.data = `${fields[field] ?? ""} `
  }
  if (fields.deflection) by("file-deflection").value = seen.deflection ?? "" // what the file names is filled in
  by("file-smooth").hidden = !seen.cut_off
  tell(by("file-smooth"), seen.cut_off ? `Remove waves shorter than ${seen.cut_off} nm` : "")
  tell(by("file-says"), seen.says ? `${seen.says}.` : "")
  say("file-why", sentence(seen.why))
  by("file-use").disabled = !seen.says
  showTable()
  showDrawing()
}

function showTable() {
  const { table } = seen, box = by("file-rows")
  box.hidden = !table
  if (!table) return
  const key = JSON.stringify([file.name, table])
  if (box.dataset.key !== key) {
    box.dataset.key = key
    const named = table.columns.map(({ name }, k) => name || `column ${k + 1}`)
    const menus = (of, what) => make("tr", {}, ...named.map((name, k) => make("td", {}, menu(of, what, name, k))))
    box.replaceChildren(
      make("p", { className: "note" }, ...table.above.slice(-4).flatMap((text) => [text, make("br")])),
      make("table", {},
        make("thead", {}, menus("role", "what it is"), menus("unit", "unit"), menus("sign", "sign"),
          make("tr", {}, ...named.map((name) => make("th", { scope: "col" }, name)))),
        make("tbody", {}, ...table.first.map((row) => (
          make("tr", {}, ...named.map((_, k) => make("td", {}, row[k] ?? ""))))))))
  }
  for (const k of table.columns.keys()) showColumn(k)
}

const menu = (of, what, name, k) => make("span", {},
  make("select", { "aria-label": `${name}: ${what}`, data: { of, k }, onchange: change }),
  ...(of === "unit" ? [make("input", { "aria-label": `${name}: what 1 is, such as 0.5 um`, placeholder: "0.5 um",
    hidden: true, data: { of, k }, onchange: change })] : []))
const at = (tag, of, k) => one(`#file-rows ${tag}[data-of="${of}"][data-k="${k}"]`)
const roleOf = (k) => Object.keys(seen.columns).find((role) => seen.columns[role] === k) ?? ""

function showColumn(k) {
  const role = roleOf(k), { known, units, signs = {} } = seen
  fill(at("select", "role", k), [["", "–"], ...Object.keys(known).map((name) => [name, AXES[name] ?? name])], role)
  const menuOf = at("select", "unit", k), entry = at("input", "unit", k), unit = units[role] ?? ""
  const list = known[role] ?? [], own = unit && !list.includes(unit)
  menuOf.hidden = !role
  fill(menuOf, [["", "unit …"], ...(own ? [[unit, unit]] : []), ...list.map((name) => [name, name]),
    [OTHER, "other …"]], unit)
  entry.hidden = other !== k
  if (other === k) menuOf.value = OTHER
  at("select", "sign", k).hidden = !(role in signs)
  const asked = seen.asked?.includes(role) ?? false, first = ["", asked ? "sign: choose ..." : "sign as read"]
  fill(at("select", "sign", k), [first, ...SIGNS], signs[role] ? `${signs[role]}` : "")
  at("select", "sign", k).setAttribute("aria-invalid", asked)
}

function change({ target }) {
  const { of, k } = target.dataset, role = roleOf(Number(k)), { value } = target
  if (of === "role") {
    const others = Object.entries(seen.columns).filter(([name, column]) => name !== value && column !== Number(k))
    const columns = Object.fromEntries([...others, ...(value ? [[value, Number(k)]] : [])])
    seen.columns = columns // until the server answers
    for (const each of seen.table.columns.keys()) showColumn(each)
    return choose({ columns, part: null })
  }
  other = value === OTHER ? Number(k) : null
  if (value === OTHER) {
    showColumn(other)
    return at("input", "unit", k).focus()
  }
  const name = of === "unit" ? "units" : "sign", values = { ...chosen[name] }
  if (value) values[role] = of === "sign" ? Number(value) : value
  else delete values[role]
  return choose({ [name]: values })
}

const place = (end) => by(`file-${end}`).value / STEPS

function showDrawing() {
  const { drawn, part } = seen, box = by("file-drawing")
  box.hidden = !drawn
  if (!drawn) return
  const { x, y, low, high } = drawn, least = Math.min(...y), size = Math.max(...y) - least || 1
  const line = x.map((v, k) => `${((WIDE * (v - low)) / (high - low || 1)).toFixed(1)},`
    + (HIGH * (0.95 - (0.9 * (y[k] - least)) / size)).toFixed(1)).join(" ")
  box.querySelector("svg").replaceChildren(makeShape("rect", { class: "part", y: 0, height: HIGH }),
    makeShape("polyline", { points: line, "vector-effect": "non-scaling-stroke" }))
  for (const [k, end] of ["from", "to"].entries()) {
    by(`file-${end}`).parentNode.hidden = !part
    if (part) by(`file-${end}`).value = STEPS * part[k]
  }
  showPart()
}

// The part between the handles
function showPart() {
  const { drawn: { low, high, unit }, part } = seen, [from, to] = part ? [place("from"), place("to")] : [0, 1]
  const shape = by("file-drawing").querySelector("rect")
  shape.setAttribute("x", WIDE * from)
  shape.setAttribute("width", WIDE * Math.max(0, to - from))
  for (const [end, share] of [["from", from], ["to", to]]) {
    const text = `${digits(low + share * (high - low), 4)} ${unit}`
    by(`file-${end}`).setAttribute("aria-valuetext", text)
    tell(by(`file-${end}`).nextElementSibling, text)
  }
}

function choosePart() {
  const [from, to] = [place("from"), place("to")]
  if (from < to) return choose({ part: [from, to] })
  return say("file-why", "The part must end after it begins: move the handles apart.")
}

function enter(field, { value }) {
  const number = Number(value.replace(",", "."))
  if (field === "deflection" && !value.trim()) return choose({ deflection: 0 }) // none, whatever the file names
  if (TEXTS.includes(field) || !value.trim()) return choose({ [field]: value.trim() || null })
  if (number > 0) return choose({ [field]: number })
  return say("file-why", `${value} is not allowed: give a number above 0.`)
}

const labelled = (text, made, ...more) => make("label", { hidden: true }, `${text} `, made, ...more)
const handle = (end) => labelled(end, make("input", { type: "range", id: `file-${end}`,
  "aria-label": `part ${end}`, min: 0, max: STEPS,
  oninput: showPart, onchange: choosePart }), make("output"))
const entryOf = (field) => labelled("", make("input", { id: `file-${field}`, inputMode: "decimal", size: 8,
  onchange: ({ target }) => enter(field, target) }))

function connect() {
  prepare()
  one(".page").append(make("dialog", { id: "file-of", className: "large", "aria-labelledby": "file-title" },
    make("div", { className: "top" }, make("h2", { id: "file-title" }),
      makeButton({ onclick: () => by("file-of").close() }, "Close")),
    make("p", { id: "file-others", className: "note", hidden: true }),
    make("progress", { id: "file-sent", "aria-label": "Reading the file" }),
    make("div", { className: "asks" },
      labelled("kind", make("select", { id: "file-kind",
        onchange: ({ target }) => choose({ kind: target.value, columns: null, part: null, sign: null }) })),
      labelled("channel", make("select", { id: "file-channel",
        onchange: ({ target }) => choose({ channel: target.value || null, columns: null, part: null }) })),
      ...FIELDS.map(entryOf)),
    make("div", { id: "file-rows", tabIndex: 0, role: "region", "aria-label": "First rows of the file", hidden: true }),
    make("figure", { id: "file-drawing", hidden: true, "aria-label": "The data in the file" },
      makeShape("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, preserveAspectRatio: "none", "aria-hidden": "true" }),
      handle("from"), handle("to")),
    make("p", { id: "file-says", role: "status" }), make("p", { id: "file-why", role: "alert", className: "error" }),
    makeButton({ id: "file-smooth", hidden: true, onclick: () => {
      by("file-cut_off").value = seen.cut_off
      choose({ cut_off: seen.cut_off })
    } }),
    makeButton({ id: "file-use", disabled: true, onclick: use }, "Use it")))
  on("file-of", "close", () => {
    if (by("file-of").open) return // another file was dropped before this event
    file = null
    turn++
    by("file-rows").dataset.key = ""
    order("piece", { at: 0, of: 0, content: new ArrayBuffer(0) }) // the server forgets what was not used
    by("menu").focus()
  })
  take("seen", receive)
}
