// What is entered and pressed: sliders, entries, buttons, keys, and the mouse on the curves; and the start of it all.

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
  event.target.blur() // so that Space plays
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
by("speed").addEventListener("change", (event) => {
  me.speed = Number(event.target.value)
  event.target.blur()
})
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
  if (event.key === "Escape" && by("drawer").open && !document.querySelector("dialog[open]:not(#drawer)")) by("drawer").close()
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
if (asked) openPage(by(asked)?.classList.contains("sheet") ? asked : "")
