// The browser's half of the app: receives frames, plays and scrubs them without asking the server, sends what was entered.

const positions = plain(controls)
const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches
const PICTURE = 30 // ms between two pictures while playing: smooth, and leaves time to an old laptop
const QUIET = 150 // ms after a change in which the new run has the processor, and between two pictures of a growing one
const me = { run: null, ghost: null, anchor: null, at: 0, preview: null, playing: !reduced, following: true, status: {}, speed: 4, dragging: false, fresh: false, orders: 0, drawn: -1, drawnAt: 0,
  freshAt: 0, mapped: true, mappedAt: 0, bornAt: 0, clock: 0, begun: 0, quiet: 0 }
window.punch = me // for the console, and for tests

function order(what, values, more) {
  wire.order = JSON.stringify({ do: what, values, n: me.orders++, ...more })
}

// receiving

function receive() {
  const chunk = unpack(wire.chunk)
  if (!me.run || chunk.run !== me.run.number) begin(new Run(chunk.run, chunk.head), me.status.run === chunk.run ? me.status.after : null)
  me.run.add(chunk)
  if (me.following) me.at = me.run.length - 1
  me.fresh = true // drawn with the next picture of the screen: chunks may come faster than those
  const now = performance.now()
  if (me.run.sheared >= 0 && me.begun !== me.run.number && now - me.freshAt > QUIET) painted(() => drawFresh(now))
}

function drawFresh(now) {
  me.fresh = false
  me.freshAt = now
  if (me.run.sheared >= 0) {
    fitFrames(me.run)
    drawCurves(me.run, me.ghost)
    me.begun = me.run.number
    me.mapped = false
  }
  by("scrub").max = Math.max(me.run.length - 1, Number(by("scrub").max) || 0)
  if (me.run.sheared >= 0 || me.following) show()
}

// A new run takes the screen; what was there when the change began stays behind, pale
function begin(run, after) {
  if (after && me.origin?.number === after[0]) run.takeOver(me.origin, after[1])
  if (me.anchor !== null) me.ghost = me.anchor.sheared >= 0 ? me.anchor : me.ghost
  me.anchor = me.dragging ? me.anchor : null
  me.run = run
  me.bornAt = performance.now()
  me.preview = null
}

function heard() {
  const old = me.status
  me.status = JSON.parse(wire.status)
  const { state, values, errors, notes, frames } = me.status
  if (state === "finished" && me.run && frames === me.run.length) {
    by("scrub").max = me.run.length - 1
    if (me.following && me.playing) me.at = me.run.sheared
    me.following = false
  }
  if (me.status.heard === me.orders - 1 && !waiting) { // not the echo of a position the slider has left
    for (const name in values) describe(name, values[name], errors[name], old.values?.[name])
    if (frames > 0 && !me.dragging) writeAddress()
    by("profile-error").hidden = !errors.profile
    by("profile-error").textContent = errors.profile ?? ""
    by("preset").value = me.status.preset
    by("look").textContent = presetSaid()
  }
  by("notes").hidden = notes.length === 0
  by("notes").textContent = notes.join(" ")
  tellState()
}

function describe(name, value, error, before) {
  const entry = by(`${name}-entry`), message = by(`${name}-error`)
  if (!error && document.activeElement !== entry || value !== before) entry.value = value
  entry.setAttribute("aria-invalid", Boolean(error))
  message.hidden = !error
  message.textContent = error ?? ""
  if (!me.dragging && positions[name]) place(name, value)
}

function place(name, value) {
  const list = positions[name], slider = by(name)
  const nearest = list.reduce((best, v, i) => (Math.abs(v - value) < Math.abs(list[best] - value) ? i : best), 0)
  slider.value = nearest
  slider.setAttribute("aria-valuetext", `${value}`)
}

// What to look for, where the scene is still that of the preset
function presetSaid() {
  const { preset, address } = me.status
  const changed = Object.keys(address).filter((name) => name !== "preset")
  return changed.length ? `changed: ${changed.map((name) => `${name} = ${address[name]}`).join(", ")}` : plain(looks)[preset]
}

// What brings this scene back: what differs from the preset
function writeAddress() {
  const address = new URL(location.href)
  for (const name of ["preset", ...Object.keys(me.status.values)]) address.searchParams.delete(name)
  for (const name in me.status.address) address.searchParams.set(name, me.status.address[name])
  if (address.href !== location.href) history.replaceState(null, "", address)
}

function tellState() {
  const { state, frames, total, evaluations, seconds, tolerance, why, known } = me.status
  if (!state) return
  const shown = state === "finished" && !me.playing ? "paused" : state
  const text = {
    warming: "the solver gets ready; the first time takes up to a minute",
    running: `${frames} of ${total} increments`,
    paused: `after ${frames} of ${total} increments`,
    failed: why,
  }
  const cycle = me.run?.dissipated ?? null
  const done = `${frames} increments, ${evaluations} evaluations, ${known ? "computed before" : `${seconds} s`} · all increments converged to ${tolerance.toExponential(0)} nm${cycle === null ? "" : ` · dissipated in a cycle: ${cycle.toPrecision(4)} nJ/m`}`
  by("status").dataset.state = shown
  by("status").firstElementChild.textContent = shown === "warming" ? "warming up" : shown
  by("status").lastElementChild.textContent = state === "finished" ? done : text[state]
}

// showing and playing

// The dearest of the views, in a picture of the screen of its own
function drawLate(now) {
  drawMap(me.run, me.drawn)
  me.mapped = true
  me.stage = me.run.stageOfMap(me.drawn)
  me.mappedAt = now
}

function show() {
  painted(showFrame)
}

function showFrame() {
  const run = me.run
  if (!run?.length) return
  const k = Math.min(Math.floor(me.preview ?? me.at), run.length - 1)
  drawFrame(run, k)
  me.drawn = k
  if (run.sheared >= 0 && k >= run.sheared && me.begun === run.number && me.stage !== run.stageOfMap(k)) me.mapped = false
  framePage()
  me.drawnAt = performance.now()
  if (me.preview === null) by("scrub").value = k
  const v = run.values(k), fixed = (x, d) => x.toFixed(d).replace("-", "−")
  const stage = run.stage(k)
  by("scrub").setAttribute("aria-valuetext", `${stage} increment ${v.index}`)
  const said = [
    `${stage} ${v.index}: Uₓ = ${fixed(v.U_x, 1)} nm,`, `δ = ${fixed(v.delta, 1)} nm,`,
    `F̄ = ${fixed(v.F * 1000, 3)}·10⁻³,`, `L̄ = ${fixed(v.L * 1000, 3)}·10⁻³,`,
    `Ā = ${fixed(v.A * 1000, 1)}·10⁻³${v.slip ? ", SLIP" : ""}`,
    `${stage !== "approach" && run.head.span[0] < 0 && run.head.abscissa === "U_x" ? `W = ${fixed(v.work, 1)} nJ/m, ` : ""}residual ${v.residual.toExponential(0)} nm, ${v.evaluations} evaluations`,
  ]
  said.forEach((text, i) => { by("readout").children[i].textContent = text })
  stateStretch()
}

let before = 0
function tick(now) {
  const passed = Math.min((now - before) / 1000, 0.1)
  before = now
  if (me.fresh && (me.run.whole || me.begun !== me.run.number || now - me.freshAt > QUIET)) painted(() => drawFresh(now))
  else if (!me.mapped && (me.run.whole || now - Math.max(me.mappedAt, me.bornAt) > QUIET)) painted(() => drawLate(now))
  if (me.playing && !me.following && me.run?.sheared >= 0 && me.preview === null) {
    me.clock += passed
    me.at += (passed * me.speed) / me.run.head.step
    const last = me.run.length - 1
    if (me.at > last + me.speed / me.run.head.step && me.status.state === "finished") me.at = me.run.sheared // after a second at the end
    if (Math.min(Math.floor(me.at), last) !== Math.min(me.drawn, last) && now - me.drawnAt > PICTURE && now > me.quiet) show()
  }
  requestAnimationFrame(tick)
}

function play(on) {
  me.playing = on
  if (!on) {
    me.at = Math.min(me.at, (me.run?.length ?? 1) - 1)
    show()
  }
  if (me.status.state === "running" || me.status.state === "paused" || me.status.state === "warming") order(on ? "go" : "pause")
  by("play").textContent = on ? "Pause" : "Play"
  by("play").setAttribute("aria-label", on ? "Pause" : "Play")
  tellState()
}

function move(by_frames) {
  const target = Math.floor(me.at) + by_frames
  if (by_frames > 0 && target >= (me.run?.length ?? 0) && me.status.state === "paused") {
    me.following = true
    order("one")
  } else goto(target)
}

function goto(k) {
  if (me.playing) play(false)
  me.following = false
  me.preview = null
  me.at = Math.max(0, Math.min(k, (me.run?.length ?? 1) - 1))
  show()
}

function reset() {
  Object.assign(me, { ghost: null, anchor: null, following: true, preview: null, playing: !reduced })
  by("speed").value = me.speed = 4
  order("reset")
  by("play").textContent = me.playing ? "Pause" : "Play"
  by("play").setAttribute("aria-label", me.playing ? "Pause" : "Play")
}

// entering: at most one message per 30 ms, always the latest

let waiting = null, last = 0
function enter(name, value) {
  if (me.anchor === null) {
    me.anchor = me.run
    goOnFrom()
  }
  waiting = { ...waiting, [name]: value }
  me.quiet = performance.now() + QUIET
  const rest = 30 - (performance.now() - last)
  rest > 0 ? setTimeout(send, rest) : send()
}

function send() {
  if (!waiting) return
  last = performance.now()
  order("scene", waiting, me.from && { from: me.from })
  waiting = null
}

// With "carry on" a change takes effect at the increment shown, and the run goes on from there
function goOnFrom() {
  const k = Math.min(Math.floor(me.at), (me.run?.length ?? 0) - 1)
  me.from = null
  if (!by("carry").checked || !(me.run?.sheared >= 0) || k < me.run.sheared) return
  me.origin = me.run
  me.from = [me.run.number, k]
}

function letGo() {
  me.dragging = false
  if (me.status.values) writeAddress()
}

for (const name in positions) {
  const slider = by(name), entry = by(`${name}-entry`)
  slider.addEventListener("input", () => {
    me.dragging = true
    entry.value = positions[name][slider.value]
    slider.setAttribute("aria-valuetext", entry.value)
    enter(name, entry.value)
  })
  for (const end of ["pointerup", "keyup", "blur"]) slider.addEventListener(end, letGo)
  slider.closest("form").addEventListener("keydown", (event) => { if (event.key === "Escape") document.activeElement.blur() })
}

for (const entry of document.querySelectorAll("[id$=-entry]")) {
  entry.addEventListener("change", () => enter(entry.id.replace("-entry", ""), entry.value))
}
by("preset").addEventListener("change", (event) => {
  if (me.anchor === null) me.anchor = me.run
  order("preset", { preset: event.target.value })
})
const LARGEST_FILE = 10e6 // bytes, as the server
by("profile").addEventListener("change", async (event) => {
  const file = event.target.files[0]
  event.target.value = "" // so that the same file can be chosen again
  if (!file) return
  if (file.size > LARGEST_FILE) {
    by("profile-error").textContent = `profile: ${file.name} has ${(file.size / 1e6).toFixed(1)} MB, allowed: 10 MB; thin it out. The run on screen stays.`
    by("profile-error").hidden = false
  } else order("profile", { text: await file.text() })
})
by("more").addEventListener("click", () => (by("drawer").open ? by("drawer").close() : by("drawer").show()))
for (const button of document.querySelectorAll("nav button")) button.addEventListener("click", () => openPage(button.dataset.page))

// a button pressed with the mouse gives the keyboard back, so that Space plays whatever was clicked last
document.addEventListener("click", (event) => { if (event.detail > 0) event.target.closest?.("button:not(.hint)")?.blur() })
by("play").addEventListener("click", () => play(!me.playing))
by("step").addEventListener("click", () => { play(false); move(1) })
by("back").addEventListener("click", () => move(-1))
by("reset").addEventListener("click", reset)
by("help").addEventListener("click", () => by("keys").showModal())
by("accuracy").addEventListener("click", openBench)
for (const box of [by("keys"), by("bench")]) box.addEventListener("click", (event) => { if (event.target === box) box.close() }) // beside it
by("scrub").addEventListener("input", (event) => goto(Number(event.target.value)))
by("speed").addEventListener("change", (event) => { me.speed = Number(event.target.value) })
by("theme").addEventListener("click", () => {
  const root = document.documentElement
  root.dataset.theme = root.dataset.theme === "dark" ? "light" : "dark"
  const address = new URL(location.href)
  address.searchParams.set("theme", root.dataset.theme)
  history.replaceState(null, "", address)
  paint()
  paintPage()
  if (me.run?.sheared >= 0) shadeMap(me.run)
})

document.addEventListener("keydown", (event) => {
  const on = (what) => event.target.matches?.(what)
  const taken = on("input[type=text], select") || (on("input") && !" rR".includes(event.key)) || (on("button") && event.key === " ")
  if (event.ctrlKey || event.metaKey || event.altKey || taken || document.querySelector("dialog[open]:not(#drawer)")) return
  const jump = event.shiftKey ? 10 : 1
  const keys = {
    " ": () => play(!me.playing), ArrowRight: () => move(jump), ArrowLeft: () => move(-jump),
    Home: () => goto(0), End: () => goto(Infinity), r: reset, R: reset, "?": () => by("keys").showModal(),
  }
  if (!keys[event.key]) return
  event.preventDefault()
  keys[event.key]()
})

// hovering a curve shows that increment in every view while playback rests; a click goes there
for (const name of ["forces", "area", "map"]) {
  const there = (event) => (me.run?.sheared >= 0 ? me.run.nearest(event.x, me.at) : null)
  figure[name].on_event("mousemove", (event) => { if (!me.playing) { me.preview = there(event); show() } })
  figure[name].on_event("mouseleave", () => { if (me.preview !== null) { me.preview = null; show() } })
  figure[name].on_event("tap", (event) => { const k = there(event); if (k !== null) goto(k) })
}
new ResizeObserver(stateStretch).observe(document.querySelector("figure"))

wire.properties.chunk.change.connect(receive)
wire.properties.status.change.connect(heard)
wire.properties.accuracy.change.connect(measured)
wire.properties.page.change.connect(toldOfPage)
wire.properties.picture.change.connect(pictured)
me.speed = Number(by("speed").value)
paint()
for (const name in positions) place(name, Number(by(`${name}-entry`).value))
play(me.playing)
requestAnimationFrame(tick)
order("hello")
const asked = new URLSearchParams(location.search).get("page")
if (asked && by(asked)?.classList.contains("sheet")) openPage(asked)
