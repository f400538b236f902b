// The live sentence: what happens at a frame of a run, and what a change has done, in plain words and true numbers.
// Each rule returns {key, text}: key names the moment, so that a sentence stays while it lasts. The test
// tests/features/sentence/test_page.py reads the text and checks it against the solver. Pure functions of runs.

import { AFTER, eventOf, firstSlip } from "../../static/js/events.js"
import { differing, fixed, number, withUnit } from "../../static/js/quantities.js"
import { WEAK } from "../../static/js/run.js"

const LET_GO = 0.5 // sites of peeling that are worth a word
const MORE = 1.3 // times as far: more on one side
const SAME = 0.01 // a change by less is none

const nm = (length) => `${fixed(length, Math.abs(length) < 99.95 ? 1 : 0)} nm`
const tell = (key, text) => ({ key, text })

const HOLD = 2500 // ms for which a sentence stays while a run plays or follows a slider
const LEAP = 50 // increments, more than between two pictures: the place was changed
const EVENT = /^(slip|in|off|part) / // keys of sentences about a slip or a jump

// The next sentence {key, text, k, since, run}: the one on screen, or the one that is true now. While frames follow
// each other quickly a sentence stays for some time, so that it can be read; but a slip ends it, as does another
// place or another run. While a slider is held (dragging) runs follow each other as frames do
export function saidNext(before, next, { moving, k, time, run, dragging }) {
  const another = run !== before.run, same = next.key === before.key
  const turns = run && !another && run.stage(k) !== run.stage(before.k) // it is raised, or pulled back
  const ends = turns || k < before.k || k > before.k + LEAP || (another && !dragging) || (EVENT.test(next.key) && !same)
  const stays = moving && !ends && time - before.since < HOLD
  if (next.text === before.text || (moving && same && !another) || stays) return { ...before, k, run }
  return { ...next, k, since: time, run }
}

// What happens around frame k while a run plays: one sentence for each phase, without numbers that change with the
// frame
export function phaseSentence(run, k) {
  const lowered = run.normal && k < run.sheared // else not "at rest" while the top moves
  const at = lowered ? k : Math.min(Math.max(k, run.sheared + 1), run.length - 1)
  const stage = run.sheared < 0 ? "" : run.stage(at), sheared = ["shear", "back"].includes(stage)
  const slips = sheared && !run.transient
    ? run.frames((i) => run.curves.slip[i] && i > run.sheared && run.stage(i) === stage) : []
  if (slips.length > 1 && at >= slips[0] + AFTER / run.head.step) return jerks(run, slips)
  return nowSentence(run, at, true)
}

function jerks(run, [first, second]) {
  const [a, b] = [first, second].map((at) => run.slipTo(at))
  if (!(a.all && b.all && a.sites && a.sites === b.sites))
    return tell("jerks", "Sliding in jerks: the contact sticks, slips, sticks again.")
  return tell("jerks", `Sliding in jerks: it sticks, slips ${nm(a.sites * run.head.spacing)}, sticks again.`)
}

// Whether the surfaces hold on to each other at frame k
function holds(run, k) {
  const frame = run.frame(k)
  return frame.T_t.some((T_t, i) => frame.state(i) !== "free" || Math.abs(T_t) > WEAK * run.head.adhesion)
}

// What happens at frame k; playing: without the numbers of a slip
export function nowSentence(run, k, playing = false) {
  if (run.transient)
    return tell("film", "Slow motion through the slip: waves run through the contact until it rests again.")
  const stage = run.stage(k)
  if (!holds(run, k)) {
    if (stage === "approach" || stage === "reload")
      return tell("apart down", "The punch comes down. It is too far away to feel more than a faint pull.")
    return tell("apart", "Too far apart to hold on: only a faint pull reaches across.")
  }
  const slip = run.slipBefore(k, AFTER), normal = ["approach", "reload", "unload"].includes(stage)
  const jumps = normal || slip <= Math.max(0, run.sheared) // there a held load takes over
  if (slip !== null && run.stage(slip) === stage) return jumps ? jumped(run, slip, k) : slid(run, slip, playing)
  return normal ? pressed(run, k, stage) : pulled(run, k)
}

function jumped(run, at, k) {
  const { A, L } = run.curves, frame = run.frame(k), held = frame.T_n.some((_, i) => frame.state(i) !== "free")
  if (run.stage(at) === "unload") {
    if (!held) return tell(`off ${at}`, "It lets go: the surfaces jump apart.")
    return tell(`part ${at}`, "A part of the contact lets go at once.")
  }
  const closer = L[at] < L[at - 1]
  if (A[at] > A[at - 1])
    return tell(`in ${at}`, `It jumps into contact: attraction closes the gap at once, over ${nm(A[at])}.`)
  return tell(`in ${at}`, closer ? "It jumps closer: attraction wins over the stiffness of the punch."
    : "The surface jumps to another shape.")
}

function pressed(run, k, stage) {
  const { A, L, delta } = run.curves, before = Math.max(0, k - 1)
  const raised = stage === "unload" || delta[k] < delta[before]
  if (raised) {
    if (L[k] < 0 && A[k] > 0)
      return tell("held", "Raised, yet it does not let go: adhesion pulls the punch down.")
    if (L[k] < 0)
      return tell("hangs", "Raised: the punch hangs on attraction alone, nothing is pressed together any more.")
    return tell("lifted", "Raised: the contact is still pressed together.")
  }
  if (A[k] === 0)
    return tell("near", "Lowered: the surfaces attract each other, nothing is pressed together yet.")
  if (A[k] > A[before]) return tell("grows", "Lowered: the contact grows.")
  return tell("pressed", "Lowered onto the surface.")
}

function slid(run, at, playing) {
  const { F } = run.curves, start = eventOf(run, at)
  const { gone, all, sites, shiftText } = run.slipTo(at)
  const part = gone && !all ? "A part of the contact slips" : "It slips"
  const far = sites && all ? ` by ${shiftText}, ${nm(sites * run.head.spacing)}` : ""
  const [was, is] = [start.F, F[at]].map(Math.abs), turns = F[at] * start.F < 0
  const numbers = playing ? "" : ` from ${number("F", was)} to ${withUnit("F", is)}${turns ? " the other way" : ""}`
  const changes = is < was ? "drops" : "rises", verb = turns ? "turns round" : changes
  return tell(`slip ${at}`, `${part}${far}: friction ${verb}${numbers}${areaAfter(run, at)}.${doubt(run)}`)
}

// Where slips go over several sites, a prediction may be wrong about where they land until it is checked
const doubt = ({ followed, head: { scene } }) =>
  (followed && scene.surface !== "circular" ? " Predicted: it may land elsewhere." : "")

// What a slip does to the area, unless that is little
function areaAfter({ head, curves: { A } }, at) {
  const before = A[at - 1], after = A[at]
  if (head.flat || Math.abs(after - before) < SAME * Math.max(after, before)) return ""
  if (after > before) return ", and contact comes back"
  return after === 0 ? ", and nothing is pressed together" : ", and contact is lost"
}

// Between slips
function pulled(run, k) {
  const { F, A } = run.curves, way = run.stage(k) === "back" ? -1 : 1, { flat } = run.head
  const begun = stickBegins(run, k)
  if (k <= run.sheared)
    return tell("rest", run.curves.A[k] > 0 || flat ? "In contact and at rest: nothing pulls sideways yet."
      : "Held by attraction, and at rest: nothing pulls sideways yet.")
  const steady = smooth(run, k)
  if (steady)
    return tell("smooth", `It slides without slips: friction swings ${swing(steady)} in every lattice period.`)
  const rising = way * (F[k] - F[Math.max(begun, k - 1)]) >= 0
  if (!rising && way * F[k] < 0)
    return tell("swing", "Still bent the other way: friction pushes it on.")
  if (!rising) return tell("eases", "Friction eases, without a slip.")
  if (way * F[k] < 0)
    return tell("unbend", "The pull first takes the lean out of the punch: friction still acts with the pull.")
  if (A[k] === 0 && !flat)
    return tell("tension", "Nothing is pressed together any more, yet it holds: attraction alone carries the friction.")
  if (flat)
    return tell("stick flat", "It sticks: every spring stretches alike, and friction grows with the pull.")
  const now = run.edges(k), then = run.edges(begun)
  if (!now || !then || run.patches(k).length > 1)
    return tell("stick", "It sticks: the punch leans over, and friction grows with the pull.")
  const both = [now[0] - then[0], then[1] - now[1]], [behind, front] = way > 0 ? both : both.toReversed()
  if (behind > LET_GO && front > LET_GO) {
    const [more, words] = behind > MORE * front ? ["behind", ", more behind than in front"]
      : front > MORE * behind ? ["front", ", more in front than behind"] : ["", ""]
    return tell(`peel both ${more}`, `It sticks and leans over. Both edges of the contact let go${words}.`)
  }
  if (behind > LET_GO)
    return tell("peel behind", "It sticks and leans over. The contact lets go behind.")
  if (front > LET_GO)
    return tell("peel front", "It sticks and leans over. The contact lets go in front.")
  return tell("stick", "It sticks: the punch leans over, and friction grows with the pull.")
}

// The frame from which on it has been stuck at frame k: after the last slip, or where the stage began
function stickBegins(run, k) {
  const { slip, stage } = run.curves
  let at = k
  while (at > Math.max(0, run.sheared) && !slip[at] && stage[at - 1] === stage[k]) at--
  return at
}

// How friction swings without slips, in words
export const swing = ({ low, high }) => (
  number("F", high - low) === "0" ? "too little to be shown"
  : Math.abs(low + high) < SAME * (high - low) ? `by ±${withUnit("F", high)}`
  : `between ${number("F", low)} and ${withUnit("F", high)}`)

// {low, high, from} of F where a whole run slides without slips, from its first top on; null
function smooth(run, k) {
  const { slip, F, U_x, stage } = run.curves
  if (!run.whole || run.normal || run.head.span[0] < 0) return null
  if (run.slides === undefined) {
    let top = Math.max(0, run.sheared) + 1
    while (top < F.length - 1 && F[top + 1] >= F[top]) top++
    const list = F.slice(top), low = Math.min(...list), high = Math.max(...list)
    const slides = top < F.length - 1 && !slip.some((slipped, i) => slipped && i > run.sheared)
      && stage[top] === stage.at(-1) && Math.abs(U_x.at(-1) - U_x[top]) >= run.head.spacing
    run.slides = slides ? { low, high, from: top } : null
  }
  return run.slides && k >= run.slides.from ? run.slides : null
}

const CHANGES = { // parameter: what more and less of it is called
  E: ["Stiffer", "Softer"], delta_bar: ["Pressed deeper", "Pressed less"],
  phi_ratio: ["A stronger grip sideways", "A weaker grip sideways"],
  phi_n: ["A stickier surface", "A less sticky surface"], drive_t: ["A stiffer drive", "A softer drive"],
  radius: ["A blunter punch", "A sharper punch"],
}
const APART = "the surfaces do not hold on to each other any more", TOGETHER = "now the surfaces hold on to each other"
const real = (value) => (value === "inf" ? Infinity : Number(value))
const ALONE = ["surface", "path", "hold"] // another experiment: nothing to compare
const differs = (a, b) => Math.abs(a - b) > SAME * Math.max(Math.abs(a), Math.abs(b))

// What one change has done, against the run before; null where there is nothing to compare
export function changeSentence(run, before) {
  if (!run || !before || run.transient || run.normal !== before.normal || run.head.flat !== before.head.flat
    || !(run.sheared >= 0 && before.sheared >= 0) || !run.whole) return null
  const names = differing(run.scene, before.scene)
  if (names.length !== 1 || ALONE.includes(names[0])) return null
  const [name] = names, up = real(run.scene[name]) > real(before.scene[name])
  const head = CHANGES[name]?.[up ? 0 : 1] ?? "With this change"
  if (run.normal) return lifted(run, before, head)
  const [apart, were] = [run, before].map(apartAlways)
  if (apart !== were) return tell("change apart", `${head}: ${apart ? APART : TOGETHER}.`)
  if (apart) return null
  const now = firstSlip(run), then = firstSlip(before)
  if (!now && !then) return swings(smooth(run, run.length - 1), smooth(before, before.length - 1), head)
  if (!now)
    return tell("change smooth", `${head}: no slip any more within ${nm(run.along.at(-1))}.`)
  if (!then)
    return tell("change slips", `${head}: now it slips, first at ${nm(now.U)}.`)
  const differences = []
  if (differs(now.U, then.U))
    differences.push(`it slips ${now.U < then.U ? "earlier" : "later"}, at ${nm(now.U)} instead of ${nm(then.U)}`)
  if (differs(now.F, then.F))
    differences.push(`${differences.length ? "" : "it slips at "}${forces(now.F, then.F)}`)
  if (!differences.length) return tell("change none", `${head}: hardly a difference.`)
  return tell("change", `${head}: ${differences.join(", ")}${because(run, before, now, then)}.`)
}

// Whether the surfaces never hold on to each other once the top is pulled, as far as the frames are here
const apartAlways = (run) => (
  run.heldNowhere ??= !run.frames((k) => k >= run.sheared).some((k) => holds(run, k)))
const forces = (now, then) => `${withUnit("F", now)} instead of ${withUnit("F", then)}`
const compared = (head, verb, now, then) =>
  (now === then ? tell("change none", `${head}: hardly a difference.`)
  : tell("change", `${head}: ${verb} ${now} instead of ${then}.`))

// Of two runs that slide without slips
function swings(now, then, head) {
  if (!now || !then) return null
  return compared(head, "friction swings", swing(now), swing(then))
}

// Of two runs in which the punch is raised: the strongest pull that this takes
function lifted(run, before, head) {
  const [now, then] = [run, before].map((of) => Math.min(...of.curves.L.filter((_, k) => of.stage(k) === "unload")))
  if (!(now < 0 && then < 0)) return null
  return compared(head, "raising it takes up to", withUnit("F", -now), withUnit("F", -then))
}

// The reason, where the numbers of both runs show it
function because(run, before, now, then) {
  const steep = now.F / now.U, was = then.F / then.U, stronger = now.F > then.F, { flat } = run.head
  const start = run.curves.A[run.sheared], area = before.curves.A[before.sheared]
  const change = (name) => Number(run.scene[name]) - Number(before.scene[name])
  const along = (name, more) => (more ? change(name) > 0 : change(name) < 0)
  const reasons = [ // whether there is more of something, whether that explains the change, words for more and for less
    [steep > was, differs(steep, was) && along("E", steep > was),
      "every nanometre of pull builds up more force", "every nanometre of pull builds up less force"],
    [stronger, flat && along("delta_bar", stronger),
      "closer together, its springs hold on more firmly", "farther apart, its springs hold on less firmly"],
    [start > area, !flat && change("delta_bar") && differs(start, area) && start > area === stronger,
      "there is more contact to hold it", "there is less contact to hold it"],
    [stronger, differs(now.F, then.F) && along("phi_ratio", stronger),
      "the springs hold longer", "the springs give way sooner"],
  ]
  const found = reasons.find(([, explains]) => explains)
  if (!found) return ""
  const [more, , yes, no] = found
  return `; ${more ? yes : no}`
}
