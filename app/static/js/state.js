// What this visitor sees now: the run on screen and the one before, the increment shown, whether it plays.

export const reduced = matchMedia("(prefers-reduced-motion: reduce)").matches
export const embedded = new URLSearchParams(location.search).get("embed") === "1" // in a page of somebody else's
// ms after a change in which the new run has the processor, and between two pictures of a growing one
export const QUIET = 150
export const declared = {} // what Python declares, as main.js is told
export const me = Object.seal({ // what is not declared here cannot be set
  // the run on screen, the pale one behind it, the one that a change will leave there, the one on screen as it began
  run: null, ghost: null, behind: null, anchor: null,
  origin: null, // the run that a change carries on from
  at: 0, preview: null, drawn: -1, // the frame played at, pointed at, on screen
  playing: !reduced, following: true, speed: 0, status: {},
  // no server; the sliders say another scene; the place of the path to go to once it is there
  lost: false, stale: false, place: null,
  entered: null, dragging: false, // {parameter: text} not yet sent; whether a slider is held
  rests: 400, // ms without a move, after which a hand rests although it holds on
  // frames not drawn yet; map up to date; run whose curves are drawn; whether the approach is drawn
  fresh: false, mapped: true, begun: null, approach: false,
  quiet: 0, clock: 0, // ms until which a new run has the processor; s of playing
})

// The increment played at, of the run on screen; -1 before there is any
export const now = () => Math.min(Math.floor(me.at), (me.run?.length ?? 0) - 1)

// Everything is drawn anew with the next picture of the screen
export const anew = () => { me.fresh = Boolean(me.run) }

// What else is drawn with every frame: functions of the run and the frame
const followers = []
export const onFrame = (call) => followers.push(call)
export const frameDrawn = (run, k) => { for (const call of followers) call(run, k) }

// Whether a run was computed, and does not follow a held slider
export const exact = (run) => Boolean(run) && !run.followed && !run.stored

// A change begins: what is on screen stays behind it, pale, unless there is nothing to compare
export function leaveBehind(compare = true) {
  me.anchor = me.run
  if (!compare) me.behind = null
  else if (exact(me.run)) me.behind = me.run
}

window.punch = me // for the console, and for tests
