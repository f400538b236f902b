// A scene and an increment in a line, for captions.

import { fixed } from "./dom.js"
import { me } from "./state.js"

const SYMBOLS = { delta_bar: "δ/δ₀", phi_ratio: "φₜ/φₙ", E: "E", phi_n: "φₙ", delta_n: "δₙ", delta_t: "δₜ", nu: "ν", radius: "R", damping: "damping" }
const UNITS = { E: "GPa", phi_n: "N/m", delta_n: "nm", delta_t: "nm", radius: "w", width: "nm", u_x_max: "nm" }
const MAIN = ["delta_bar", "phi_ratio", "E"]

export const value = (name, given) => `${SYMBOLS[name] ?? name} = ${`${given}`.replace("-", "−")}${name in UNITS ? ` ${UNITS[name]}` : ""}`

// Parameters of the scene on screen: the preset, those with a slider, and what differs from the preset
export function parameters({ values, address, preset } = me.status, changing = []) {
  const others = [...new Set([...Object.keys(address), ...changing])].filter((name) => !["preset", "profile", ...MAIN].includes(name))
  const title = document.querySelector(`#preset option[value="${preset}"]`)?.textContent ?? preset
  const changed = others.length || changing.length || MAIN.some((name) => name in address)
  return `${title}${changed ? ", changed" : ""}: ${[...MAIN, ...others].map((name) => value(name, values[name])).join(", ")}`
}

export function described(run, k) {
  if (!me.status.values || !run?.length || k < 0) return ""
  const at = run.values(k)
  const scene = parameters({ ...me.status, values: run.headOf(k).scene }, run.changing)
  return `${scene}; ${run.stage(k)} increment ${at.index}, Uₓ = ${fixed(at.U_x, 1)} nm, δ = ${fixed(at.delta, 1)} nm`
}
