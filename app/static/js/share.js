// The sheet of what can be taken away

import { linkTo } from "./address.js"
import { drawBands } from "./bands.js"
import { bokehPainted, holderOf, set, svgOf } from "./bokeh.js"
import { order, take } from "./channel.js"
import { colour, isShown } from "./colours.js"
import { by, make, on } from "./dom.js"
import { figures } from "./figures.js"
import { drawFringes } from "./fringes.js"
import { sharpen } from "./pen.js"
import { me } from "./store.js"
import { drawStory } from "./story.js"
import { described, parameters } from "./words.js"

const NAME = "mixed-mode-contact"
const TOP = { U_x_top: "U_x", delta_top: "delta" } // with a drive that has a stiffness
const COLUMNS = ["U_x", "delta", "F_bar", "L_bar", "A_bar", "residual", "evaluations", "slip"] // as solver/files.py
const LINE = 20, MARGIN = 12 // px of a caption
const FONT = "system-ui, 'Segoe UI', Roboto, sans-serif"
let connected = false

// HTML that shows a link in a page of somebody else's
const frameOf = (link) => `<iframe src="${escaped(link)}&embed=1" width="960" height="600"></iframe>`

// Views that are on screen: [name, title]
const views = () => Object.keys(figures).flatMap((name) => {
  const holder = holderOf(figures[name])
  return holder?.clientWidth && holder.clientHeight ? [[name, titleOf(holder)]] : []
})
const captionOf = (holder) => holder.closest("figure")?.querySelector("figcaption")
const titleOf = (holder) => (captionOf(holder)?.querySelector("b") ?? captionOf(holder))?.textContent.trim() ?? "view"

// What the marks above a view mean: [colour, text]
function keyOf(holder) {
  const spans = [...captionOf(holder)?.querySelectorAll(".key span") ?? []].filter((span) => span.checkVisibility()
    && span.querySelector(":scope > i"))
  const pinned = [...document.querySelectorAll(".chip button:first-child[aria-pressed=true]")].map((chip) =>
    [chip.querySelector("path").getAttribute("stroke"), chip.textContent.trim()])
  return [...spans.map((span) => {
    const look = getComputedStyle(span.querySelector("i")), clear = "rgba(0, 0, 0, 0)"
    const ink = [look.backgroundColor, look.borderTopColor].find((shade, i) =>
      shade !== clear && (i === 0 || look.borderTopWidth !== "0px"))
    return [ink ?? colour("--soft"), span.textContent.trim()]
  }), ...(holder.closest("main") && !holder.closest("figure").getAttribute("aria-label").startsWith("Traction")
    ? pinned : [])]
}

function wrapped(pen, text, width) {
  const lines = [""]
  for (const word of text.split(" ")) {
    const longer = `${lines.at(-1)} ${word}`.trim()
    if (pen.measureText(longer).width > width && lines.at(-1)) lines.push(word)
    else lines[lines.length - 1] = longer
  }
  return lines
}

const escaped = (text) => text.replaceAll("&", "&amp;").replaceAll("<", "&lt;").replaceAll('"', "&quot;")
const textAt = (x, y, text, more = "") =>
  `<text x="${x}" y="${y}" dominant-baseline="middle" ${more}>${escaped(text)}</text>`

// What the colours of a view mean, where its caption has a scale
function scaleOf(name) {
  const [low, high] = ["low", "high"].map((end) => document.getElementById(`${name}-${end}`)?.textContent)
  return high ? `colours: from ${low} GPa (attraction) over 0 to ${high} (repulsion)` : ""
}

// Call with the axis of a view visible, also where it stands above another that has the same
async function withAxis(name, call) {
  const [axis] = figures[name].below, { visible } = axis
  if (visible || (name === "punch" && isShown(by("bands")))) return call() // the bands have the places
  set(axis, { visible: true })
  try {
    await bokehPainted()
    await bokehPainted()
    return await call()
  } finally {
    set(axis, { visible })
  }
}

const canvasesIn = (part) =>
  [...part.querySelectorAll(":scope > canvas")].filter(({ width, clientHeight }) => width && clientHeight)
const imageOf = (canvas, y = 0) => `<image y="${y}" width="${canvas.clientWidth}" height="${canvas.clientHeight}" `
  + `opacity="${getComputedStyle(canvas).opacity}" href="${canvas.toDataURL()}"/>`

// {text, width, height} of a view as an SVG with its title, key and caption, px
function framed(name) {
  const holder = holderOf(figures[name]), { width } = holder.getBoundingClientRect()
  const drawn = canvasesIn(holder), [behind, over] = [true, false].map((which) =>
    drawn.filter((canvas) => canvas.matches(".fringes") === which).map((canvas) => imageOf(canvas)).join(""))
  const [bands] = canvasesIn(holder.parentElement), height = holder.clientHeight + (bands?.clientHeight ?? 0)
  const pen = make("canvas").getContext("2d")
  const parts = [`<rect width="100%" height="100%" fill="${colour("--page")}"/>`]
  let x = MARGIN, y = MARGIN + LINE / 2
  pen.font = `14px ${FONT}`
  parts.push(textAt(x, y, titleOf(holder), 'font-weight="600"'))
  keyOf(holder).forEach(([ink, label], i) => {
    const wide = 24 + pen.measureText(label).width
    if (!i || x + wide > width - MARGIN) [x, y] = [MARGIN, y + LINE]
    parts.push(`<rect x="${x}" y="${y - 2}" width="18" height="4" fill="${ink}"/>`, textAt(x + 24, y, label))
    x += wide + 16
  })
  const top = y + LINE / 2
  const lines = [scaleOf(name), described(me.picture?.run, me.picture?.k)].filter(Boolean).flatMap((text) =>
    wrapped(pen, text, width - 2 * MARGIN))
  const whole = top + height + LINE * lines.length + MARGIN
  parts.push(`<g transform="translate(0 ${top})">${behind}${svgOf(figures[name])}${over}`
    + `${bands ? imageOf(bands, holder.clientHeight) : ""}</g>`)
  lines.forEach((line, i) => parts.push(textAt(MARGIN, top + height + LINE * (i + 0.5), line)))
  const size = `width="${width}" height="${whole}" viewBox="0 0 ${width} ${whole}"`
  const font = `font-family="${FONT}" font-size="14" fill="${colour("--text")}"`
  const spaces = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
  return { text: `<svg ${spaces} ${size} ${font}>${parts.join("")}</svg>`, width, height: whole }
}

export function download(blob, ending) {
  const name = `${NAME}${ending}`, link = make("a", { href: URL.createObjectURL(blob), download: name })
  link.click()
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000)
  say(`saved ${name}`)
}

// A view in so many pixels for each of the page
export async function png(name, scale = 1) {
  drawCanvases(scale)
  const { text, width, height } = framed(name), plot = new Image()
  drawCanvases(null)
  plot.src = `data:image/svg+xml,${encodeURIComponent(text)}`
  await plot.decode()
  const canvas = make("canvas", { width: Math.round(width * scale), height: Math.round(height * scale) })
  canvas.getContext("2d").drawImage(plot, 0, 0, canvas.width, canvas.height)
  return new Promise((done) => canvas.toBlob(done, "image/png"))
}

// So many pixels for each of the page, null: as on this screen
function drawCanvases(scale) {
  if (!me.picture) return
  const { run, k } = me.picture
  sharpen(scale)
  for (const draw of [drawFringes, drawBands, drawStory]) draw(run, k)
  sharpen(null)
}

export const svg = (name) => framed(name).text

const UNITS = "U_x, delta, residual in nm; F_bar = F/(w E), L_bar = L/(w E), A_bar = A/w"
const number = (value) => `${Number(value.toPrecision(7))}` // of single precision

// Comments with the scene and the units, then a row per increment after the approach, as `solver.files.write_csv`
export function csv(run) {
  const { changing } = run, tops = run.driven ? Object.entries(TOP) : []
  const rows = run.curves.stage.flatMap((_, k) => (k < run.sheared ? []
    : [[...COLUMNS.map((name) => (name === "slip" ? `${Number(run.curves.slip[k] > 0)}` : number(run.curves[name][k]))),
      ...tops.map(([, along]) => number(run.top(k, along))), run.leg(k),
      ...changing.map((name) => run.headOf(k).scene[name])].join(",")]))
  const comments = [parameters(me.status, changing), UNITS].map((text) => `# ${text}`)
  const heading = [...COLUMNS, ...tops.map(([name]) => name), "stage", ...changing]
  return [...comments, heading.join(","), ...rows, ""].join("\n")
}

const say = (text) => { by("share-status").textContent = text }

// Browsers lend the clipboard to secure pages only, and may never answer: then the old way
async function copy(field, what) {
  field.select()
  const late = new Promise((_, fail) => setTimeout(fail, 1000))
  const write = async () => navigator.clipboard.writeText(field.value)
  const copied = await Promise.race([write(), late]).then(() => true, () => document.execCommand("copy"))
  say(copied ? `${what} copied` : `The browser forbids copying. The ${what} is selected: press Ctrl+C.`)
}

function showFile({ why, ending, body }) {
  if (why) say(why)
  else download(new Blob([body]), `.${ending}`)
  document.querySelector(`[data-file=${ending}]`).disabled = false
}

function showSheet({ link, qr, python }) {
  if (link !== by("share-link").value) return
  by("share-qr").src = qr
  by("share-qr").hidden = !qr
  by("share-python").value = python
  by("share-python").rows = python.split("\n").length
}

function connect() {
  connected = true
  take("file", showFile)
  take("sheet", showSheet)
  const view = by("share-view"), scale = by("share-scale")
  on("copy-link", "click", () => copy(by("share-link"), "link"))
  on("copy-frame", "click", () => copy(by("share-frame"), "HTML"))
  on("copy-python", "click", () => copy(by("share-python"), "Python lines"))
  on("save-png", "click", async () => {
    download(await withAxis(view.value, () => png(view.value, Number(scale.value))), `-${view.value}.png`)
  })
  on("save-svg", "click", async () => {
    const text = await withAxis(view.value, () => svg(view.value))
    download(new Blob([text], { type: "image/svg+xml" }), `-${view.value}.svg`)
  })
  on("save-csv", "click", () => download(new Blob([csv(me.run)], { type: "text/csv" }), ".csv"))
  for (const button of document.querySelectorAll("[data-file]")) {
    button.addEventListener("click", () => {
      say("computing the run once more, in full precision …")
      button.disabled = true
      order("export", { kind: button.dataset.file })
    })
  }
}

export function open() {
  if (!connected) connect()
  const link = linkTo(new URLSearchParams(location.search).getAll("pin").map((text) => ["pin", text]))
  by("share-link").value = link
  by("share-frame").value = frameOf(link)
  by("share-view").replaceChildren(...views().map(([name, title]) => new Option(title, name)))
  const { address, after } = me.status
  const sentences = []
  if (address.profile)
    sentences.push("The link shows the measured profile only while this server keeps it; the JSON has it.")
  if (after)
    sentences.push("This run goes on from another. The link starts its scene from the beginning; "
      + "Python and the data have the whole path.")
  if (me.lost) sentences.push("The server does not answer: it is needed for Python, NPZ and JSON.")
  for (const what of document.querySelectorAll("#copy-python, [data-file]")) what.disabled = me.lost
  by("share-python").value = "" // of the run before, until the server answers
  by("share-qr").hidden = true
  if (!me.run?.whole) sentences.push("The run is still being computed: CSV and pictures hold what there is.")
  say(sentences.join(" "))
  order("share", { link })
  by("share").showModal()
}
