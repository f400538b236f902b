// In what forces and areas are drawn and told: per metre of depth, in N, or over wE on request (?force=bar); nm, or over w.

import { by, fixed, minus, on, readdress } from "./dom.js"

const UNITS = [[1e3, "kN/m", 1e4], [1, "N/m", 0.5], [1e-3, "mN/m", 0]] // of forces: size, name, from which force on
const BAR = { names: { F: "F_bar", L: "L_bar" }, factor: 1000, text: "10⁻³", symbols: { F: "F̄", L: "L̄" } }

let bar = false // whether over wE

// {names, factor, text, symbols, over} of the forces of the runs drawn together: one unit for all of them
export function forceUnit(runs) {
  if (bar) return runs.some((run) => run?.changing.includes("E")) ? { ...BAR, over: ", by the E of each increment" } : BAR
  const most = Math.max(...runs.map((run) => run?.strongestForce ?? 0))
  const [size, text] = UNITS.find(([, , least]) => most >= least)
  return { names: { F: "F", L: "L" }, factor: 1 / size, text, symbols: { F: "F", L: "L" } }
}

// A force of a frame's values with its unit, in four digits
export function forceSaid(values, name, unit) {
  const value = values[unit.names[name]] * unit.factor
  if (bar) return `${unit.symbols[name]} = ${fixed(value, 3)}·${unit.text}`
  const whole = Math.max(0, 3 - Math.floor(Math.log10(Math.max(Math.abs(value), 1e-3))) - 1)
  return `${unit.symbols[name]} = ${fixed(value, Math.min(3, whole))} ${unit.text}`
}

export const areaSaid = ({ A, A_bar }) => `A = ${fixed(A, 1)} nm (Ā = ${fixed(A_bar * 1000, 1)}·10⁻³)`

// Words about the axis of the area where it does not begin at zero
export const tellStart = (from) => { by("area-from").textContent = from > 0 ? `axis begins at ${minus(Number(from.toPrecision(2)))} nm` : "" }

export function connect(redraw) {
  bar = new URLSearchParams(location.search).get("force") === "bar"
  by("bar").checked = bar
  on("bar", "change", () => {
    bar = by("bar").checked
    readdress((asked) => (bar ? asked.set("force", "bar") : asked.delete("force")))
    redraw()
  })
}
