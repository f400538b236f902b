// What the server says of the run and of what was entered, in words; and whose picture this is:
// where the sliders say another scene than the run on screen, words say which, and an old run is grey.

import { heard as acknowledged, order, outdated } from "./channel.js"
import { all, by, on, one, say, tell } from "./dom.js"
import { differing, fixed, named } from "./quantities.js"
import { describeAll } from "./sliders.js"
import { sendNext } from "./steer.js"
import { alone, ended, me, view } from "./store.js"

export function connect() {
  on("skip", "click", () => order("skip"))
  setInterval(() => { if (me.status.state === "running") tellState() }, 1000)
  view(["run", "status", "waiting", "entered", "dragging", "lost", "picture", "charted"], checkTruth)
  view(["status", "dragging", "waiting", "entered"], tellScene)
  view(["status"], tellNotes)
  view(["run", "status", "playing", "lost"], tellState)
}

// news: what has changed of the status
export function heard(news) {
  const old = me.status
  me.status = { ...old, ...news }
  acknowledged(me.status.acknowledged)
  sendNext()
  if (me.waiting.length) return // it was sent before the server heard of another scene
  if (me.status.frames !== old.frames || me.status.run !== old.run) newsAt = performance.now()
  if (ended() && me.run && me.status.frames === me.run.length) {
    by("scrub").max = me.run.length - 1
    if (me.following && me.playing) me.at = me.run.beginning
    me.following = false
  }
}

let described = null // the status that the controls show
function tellScene() {
  const { status } = me
  // the echo of a position the slider has left
  if (!status.values || me.waiting.length || me.entered || outdated(status)) return
  if (described !== status) {
    describeAll(status, described?.values)
    described = status
  }
}

function tellNotes() {
  const { values, notes, cautions } = me.status
  if (!values) return
  say("notes", notes.join(" "))
  say("cautions", cautions.join(" "))
  by("caution").hidden = !cautions.length
}

const SAID = 4 // parameters at most

// {parameter: value} as the controls have it: as the server sent them, or as of the prediction that is newer; with what
// was asked for since
function asked() {
  const changes = me.waiting.filter(({ what }) => what === "scene").map(({ values }) => values)
  const newer = me.run?.followed && outdated(me.status) ? me.run.scene : {}
  return Object.assign({}, me.status.values, newer, ...changes, me.entered)
}

// Whether a run that pixels come from is not that of the numbers beside them. While a slider is held predictions follow
// it, and say so; without a server the words do
const outOfDate = (run) => Boolean(run) && !me.lost && !(me.dragging && run.followed)
  && (differing(run.scene, asked()).length > 0 || restoring())
const restoring = () => me.waiting.some(({ what }) => what !== "scene")

function checkTruth() {
  const names = me.run ? differing(me.run.scene, asked()) : []
  me.stale = Boolean(me.run) && (names.length > 0 || restoring())
  const values = names.slice(0, SAID).map((name) => named(name, me.run.scene[name])).join(", ")
  tell(by("stale"), me.lost && me.stale ? `The picture is that of ${values || "the scene before"}.` : "")
  const stale = outOfDate(me.picture?.run), mixed = outOfDate(me.charted)
  one(".hero").ariaBusy = stale
  for (const figure of all(".curves > figure")) figure.ariaBusy = mixed
}

const LONG = 3 // s of computing after which a run says what it does, and may be skipped
const TRUSTED = 0.1 // of the increments, before their pace says anything
const SLIP = 1.5 // s without news: it is at a slip, all else is quick

let newsAt = 0 // ms
const waited = () => (performance.now() - newsAt) / 1000

// What a slow run is at, and how long it will take at its pace until now
function doing() {
  const { frames, total, seconds } = me.status, run = me.run
  if (!run?.length || seconds + waited() < LONG || me.lost) return ""
  const k = run.length - 1, normal = run.normal || run.sheared < 0
  const slip = normal ? `a jump near δ = ${fixed(run.curves.delta[k], 1)} nm`
    : `a slip near ${fixed(run.curves.U_x[k], 1)} nm`
  const left = (seconds / frames) * (total - frames) - waited(), told = left > 1 && frames > TRUSTED * total
  const at = waited() > SLIP ? ` · solving ${slip} for ${Math.round(waited())} s` : ""
  return `${at}${told ? ` · about ${Number(left.toPrecision(left < 10 ? 1 : 2))} s left` : ""}`
}

function gettingReady() {
  const [done, kernels] = me.status.compiled ?? [0, 0]
  return done ? `compiling: ${done} of ${kernels} kernels` : "the solver gets ready"
}

const STATES = { // {state of a run: its text}
  warming: gettingReady,
  running: ({ frames, total }) => `${frames} of ${total} increments${doing()}`,
  refining: ({ frames, total }) => `${frames} of ${total} increments`,
  skipped: ({ frames, total }) => `the last ${total - frames} of ${total} increments; what was computed stays`,
  failed: ({ why }) => why,
  finished: ({ why }) =>
    Number.isFinite(me.run?.dissipated) ? `dissipated in a cycle: ${me.run.dissipated.toPrecision(4)} nJ/m` : why,
}

function tellState() {
  const { state, seconds } = me.status, { stored, followed, checked, sheared } = me.run ?? {}
  if (stored && state !== "failed") return tellStored(state)
  if (!state) return
  if (alone) return tellSaved()
  if (followed && (state !== "failed" || me.dragging))
    showState("followed", state === "refining" ? "the exact run comes" : "exact once the slider rests")
  else if (checked && state === "finished") showState("exact", "")
  else showState(state === "finished" && !me.playing ? "paused" : state, STATES[state](me.status))
  by("skip").hidden = !(state === "running" && seconds + waited() > LONG && sheared >= 0)
  tellWork(me.status)
}

const counted = (count, of) => `${count} ${of}${count === 1 ? "" : "s"}`

function tellWork({ state, frames, total, evaluations, seconds, tolerance, known, residual }) {
  if (me.run?.followed) return tell(by("computed"), "This run is predicted from the run before.")
  const time = known ? "computed before" : `${seconds} s`
  if (me.run?.checked && state === "finished") {
    const counts = ["state", "fold", "landing"].map((of, i) => counted(me.run.checked[i], of)).join(", ")
    return tell(by("computed"), `This run was predicted, and is exact: ${counts} checked, `
      + `${evaluations} force evaluations, ${time}; `
      + `largest residual ${residual.toExponential(0)} nm. Increments lie between these states.`)
  }
  const end = state === "finished" ? `: all increments converged to ${tolerance.toExponential(0)} nm.` : "."
  tell(by("computed"), `${frames} of ${total} increments, ${evaluations} force evaluations, ${time}; `
    + `largest residual ${residual.toExponential(0)} nm${end}`)
}

function showState(shown, text) {
  by("status").dataset.state = shown
  tell(by("status").firstElementChild, { warming: "warming up", finished: "computed" }[shown] ?? shown)
  tell(by("status").querySelector("span"), text)
}

// A Result that is played: of which scene it is
function tellSaved() {
  showState("saved", "")
  tell(by("look"), me.status.words)
}

// A run that was computed in advance stands in for the one to come
function tellStored(state) {
  showState("stored", state === "warming" ? gettingReady() : "the computed run follows")
  tell(by("computed"), "This run was computed in advance.")
}
