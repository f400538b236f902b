// The words and units of a scene and an increment. Forces and areas: per metre of depth, in N, or over wE on
// request (?force=bar); nm, or over w. Parameters by the symbols and words of their controls, or in short.

import { by, digits, fixed, minus, on, readdress } from "./dom.js"
import { me, redraw } from "./store.js"

const FORCES = [[1e3, "kN/m", 1e4], [1, "N/m", 0.5], [1e-3, "mN/m", 0]] // of forces: size, name, from which force on
const BAR = { names: { F: "F_bar", L: "L_bar" }, factor: 1000, text: "10⁻³", symbols: { F: "F̄", L: "L̄" } }

const overE = () => by("bar").checked // whether over wE

// {names, factor, text, symbols, over} of the forces of the runs drawn together: one unit for all of them
export function forceUnit(runs) {
  const changing = runs.some((run) => run?.changing.includes("E"))
  if (overE()) return changing ? { ...BAR, over: ", by the E of each increment" } : BAR
  const most = Math.max(...runs.map((run) => run?.strongestForce ?? 0))
  const [size, text] = FORCES.find(([, , least]) => most >= least)
  return { names: { F: "F", L: "L" }, factor: 1 / size, text, symbols: { F: "F", L: "L" } }
}

// A force of a frame's values with its unit, in four digits
export function forceText(values, name, unit) {
  const value = values[unit.names[name]] * unit.factor
  if (overE()) return `${unit.symbols[name]} = ${fixed(value, 3)}·${unit.text}`
  const whole = Math.max(0, 3 - Math.floor(Math.log10(Math.max(Math.abs(value), 1e-3))) - 1)
  return `${unit.symbols[name]} = ${fixed(value, Math.min(3, whole))} ${unit.text}`
}

export const areaText = ({ A, A_bar }) => `A = ${fixed(A, 1)} nm (Ā = ${fixed(A_bar * 1000, 1)}·10⁻³)`

// Words about the axis of the area where it does not begin at zero
export const tellStart =
  (from) => { by("area-from").textContent = from > 0 ? `axis begins at ${digits(from, 2)} nm` : "" }

export function connect() {
  by("bar").checked = new URLSearchParams(location.search).get("force") === "bar"
  on("bar", "change", () => {
    readdress((asked) => (overE() ? asked.set("force", "bar") : asked.delete("force")))
    redraw()
  })
}

const labelOf = (name) => document.querySelector(`label[for="${name}-entry"]`)
export const symbol = (name) => (labelOf(name)?.querySelector("i") ?? labelOf(name))?.textContent ?? name
export const inWords = (name) => labelOf(name)?.firstChild.textContent.trim() || name

const SYMBOLS = {
  delta_bar: "δ/δ₀", phi_ratio: "φₜ/φₙ", E: "E", phi_n: "φₙ", delta_n: "δₙ", delta_t: "δₜ", nu: "ν", radius: "R",
  damping: "damping", drive_t: "drive kₜ", drive_n: "drive kₙ",
}
const UNITS = {
  E: "GPa", phi_n: "N/m", delta_n: "nm", delta_t: "nm", radius: "w", width: "nm", u_x_max: "nm",
  drive_t: "MPa/nm", drive_n: "MPa/nm",
}
const MAIN = ["delta_bar", "phi_ratio", "E"]

export const value = (name, given) =>
  `${SYMBOLS[name] ?? name} = ${minus(given)}${name in UNITS ? ` ${UNITS[name]}` : ""}`

// Parameters of the scene on screen: the preset, those with a slider, and what differs from the preset
export function parameters({ values, address, preset } = me.status, changing = []) {
  const others = [...new Set([...Object.keys(address), ...changing])].filter((name) =>
    !["preset", "profile", ...MAIN].includes(name))
  const title = document.querySelector(`#preset option[value="${preset}"]`)?.textContent ?? preset
  const changed = others.length || changing.length || MAIN.some((name) => name in address)
  const text = [...MAIN, ...others].map((name) => value(name, values[name])).join(", ")
  return `${title}${changed ? ", changed" : ""}: ${text}`
}

export function described(run, k) {
  if (!me.status.values || !run?.length || k < 0) return ""
  const at = run.values(k)
  const scene = parameters({ ...me.status, values: run.headOf(k).scene }, run.changing)
  return `${scene}; ${run.leg(k)} increment ${at.index}, Uₓ = ${fixed(at.U_x, 1)} nm, δ = ${fixed(at.delta, 1)} nm`
}
