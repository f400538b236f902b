// Whose picture this is: where the sliders say another scene than the run on screen, words say which, and an old run is grey.

import { waiting } from "./channel.js"
import { minus, say } from "./dom.js"
import { me } from "./state.js"

const SAID = 4 // parameters at most

// {parameter: value} as the controls have it: what the server told, and what was asked for since
function asked() {
  const changes = waiting().filter(({ what }) => what === "scene").map(({ values }) => values)
  return Object.assign({}, me.status.values, ...changes, me.entered)
}

const labelOf = (name) => document.querySelector(`label[for="${name}-entry"]`)
export const symbol = (name) => (labelOf(name)?.querySelector("i") ?? labelOf(name))?.textContent ?? name
export const inWords = (name) => labelOf(name)?.firstChild.textContent.trim() || name

export function checkTruth() {
  const scene = me.run?.scene, wanted = asked()
  const other = waiting().some(({ what }) => what !== "scene")
  const names = scene ? Object.keys(scene).filter((name) => name in wanted && String(scene[name]) !== String(wanted[name])
    && Number(scene[name]) !== Number(wanted[name])) : []
  me.stale = Boolean(scene) && (names.length > 0 || other)
  const values = names.slice(0, SAID).map((name) => `${symbol(name)} = ${minus(scene[name])}`).join(", ")
  const { dataset } = document.querySelector(".page")
  const mixed = Boolean(me.begun) && me.drawn >= 0 && me.begun !== me.run?.number && me.following // curves come with the shear
  say("stale", me.stale && !(me.dragging && me.run.followed) ? `computed for ${values || "the scene before"}` : mixed ? "curves: still those of the run before" : "")
  for (const [name, is] of Object.entries({ mixed, stale: me.stale && (me.run === me.anchor || me.lost) })) {
    if (is) dataset[name] = "true"
    else delete dataset[name]
  }
}
