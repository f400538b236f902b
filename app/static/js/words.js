// The words of a scene.

import { one } from "./dom.js"
import { named } from "./quantities.js"
import { declared, me } from "./store.js"

const labelOf = (name) => one(`label[for="${name}-entry"]`)
export const inWords = (name) => labelOf(name)?.firstChild.textContent.trim() || name

export const titleOf = (preset) => declared.titles[preset] ?? preset

// Names of the parameters in which a scene, as an address has it, differs from its preset
export const changedIn = (address) => Object.keys(address).filter((name) => name in me.status.values)

const MAIN = ["delta_bar", "phi_ratio", "E"]

// Parameters of the scene on screen: the preset, those with a slider, and what differs from the preset
export function parameters({ values, address, preset } = me.status) {
  const changed = changedIn(address), names = new Set([...MAIN, ...changed])
  const text = [...names].map((name) => named(name, values[name])).join(", ")
  return `${titleOf(preset)}${changed.length ? ", changed" : ""}: ${text}`
}
