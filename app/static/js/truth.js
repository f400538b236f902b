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

export const symbol = (name) => {
  const label = document.querySelector(`label[for="${name}-entry"]`)
  return (label?.querySelector("i") ?? label)?.textContent ?? name
}

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
  if (mixed) dataset.mixed = "true"
  else delete dataset.mixed
  if (me.stale && (me.run === me.anchor || me.lost)) dataset.stale = "true"
  else delete dataset.stale
}
