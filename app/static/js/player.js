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
  const said = changed.map((name) => `${name} = ${address[name]}`).join(", ")
  const { after } = me.status
  if (after && me.origin?.number === after[0]) {
    return `carried on from increment ${after[1]} (Uₓ = ${me.origin.curves.U_x[after[1]].toFixed(1)} nm) with ${said || "the preset's values"}; the address holds the parameters only`
  }
  return changed.length ? `changed: ${said}` : plain(looks)[preset]
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
  const word = { warming: "warming up", finished: "computed" }[shown] ?? shown
  const text = {
    warming: "the solver gets ready; the first time takes up to a minute",
    running: `${frames} of ${total} increments`,
    paused: `after ${frames} of ${total} increments`,
    failed: why,
  }
  const cycle = me.run?.dissipated ?? null
  const done = `${frames} increments, ${evaluations} evaluations, ${known ? "computed before" : `${seconds} s`} · all increments converged to ${tolerance.toExponential(0)} nm${cycle === null ? "" : ` · dissipated in a cycle: ${cycle.toPrecision(4)} nJ/m`}`
  by("status").dataset.state = shown
  by("status").firstElementChild.textContent = word
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
  const v = run.values(k), fixed = (x, d) => (Math.round(x * 10 ** d) / 10 ** d).toFixed(d).replace("-", "−")
  const stage = run.stage(k)
  by("scrub").setAttribute("aria-valuetext", `${stage} increment ${v.index}`)
  const said = [
    `${stage} ${v.index}: Uₓ = ${fixed(v.U_x, 1)} nm,`, `δ = ${fixed(v.delta, 1)} nm,`,
    `F̄ = ${fixed(v.F * 1000, 3)}·10⁻³,`, `L̄ = ${fixed(v.L * 1000, 3)}·10⁻³,`,
    `Ā = ${fixed(v.A * 1000, 1)}·10⁻³${v.slip ? (run.head.abscissa === "delta" ? ", JUMP" : ", SLIP") : ""}`,
    `${stage !== "approach" && run.head.span[0] < 0 && run.head.abscissa === "U_x" ? `work since shear began ${fixed(v.work - run.curves.work[run.sheared], 0)} nJ/m, ` : ""}residual ${v.residual.toExponential(0)} nm, ${v.evaluations} evaluations`,
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
