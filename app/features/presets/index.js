// Experiments: a row of pictures, and a menu of all; what to look for in the one on screen.

import { outdated } from "../../static/js/channel.js"
import { all, by, on, tell } from "../../static/js/dom.js"
import { play } from "../../static/js/player.js"
import { withUnit } from "../../static/js/quantities.js"
import { restore } from "../../static/js/steer.js"
import { beginChange, declared, me, reduced, set, view } from "../../static/js/store.js"
import { changedIn, inWords, titleOf } from "../../static/js/words.js"

export function connect() {
  on("row", "change", ({ target }) => choosePreset(target.value))
  view(["status", "dragging", "waiting", "entered"], tellPreset)
}

let told = null // the status that the menu shows
function tellPreset() {
  const { status } = me
  if (!status.values || me.waiting.length || me.entered || outdated(status) || told === status) return
  told = status
  namePreset()
  tell(by("look"), presetText())
}

// An experiment chosen starts: it is shown as it is computed, then played from its beginning
function choosePreset(preset) {
  beginChange(false)
  set({ following: true, preview: null, place: null, at: 0 })
  restore({ preset })
  if (!reduced) play(true)
}

// The menu, which says so where the scene is no longer that of the preset; choosing the preset then brings it back
function namePreset() {
  const menu = by("preset"), { preset, address } = me.status
  menu.options[0].textContent = `${titleOf(preset)} – changed`
  menu.value = changedIn(address).length ? "" : preset
  for (const radio of all("#row input")) radio.checked = radio.value === menu.value
}

// What to look for, where the scene is still that of the preset
function presetText() {
  const { preset, address } = me.status
  const changed = changedIn(address).map((name) => `${inWords(name)} = ${withUnit(name, address[name])}`)
  return changed.length ? `changed: ${changed.join(", ")}` : declared.looks[preset]
}
