// Every quantity in one table: its symbol, its unit, in words as well, and how its numbers are written. Forces are per
// metre of depth.

// A number, or a word, as a page writes it
export const minus = (text) => `${text}`.replace(/-(?=\d)/g, "−")
export const digits = (value, count = 3) => minus(Number(value.toPrecision(count)))
export const fixed = (value, places) => minus((Math.round(value * 10 ** places) / 10 ** places).toFixed(places))

const SPOKEN = { nm: "nanometres", "N/m": "newtons per metre" }
const DECIMALS = 4 // of a number in three digits: what is smaller is round-off
const length = (symbol) => ({ symbol, unit: "nm", places: 1 })
const force = (symbol) => ({ symbol, unit: "N/m" })
const QUANTITIES = { // {symbol, unit, places: of its numbers, else three digits; given: as it was entered}
  U_x: length("Uₓ"), delta: length("δ"), A: length("A"), F: force("F"), L: force("L"), F_s: force("Fₛ"),
  E: { symbol: "E", unit: "GPa", given: true },
  delta_bar: { symbol: "δ/δ₀", unit: "", given: true },
  phi_ratio: { symbol: "φₜ/φₙ", unit: "", given: true },
  phi_n: { symbol: "φₙ", unit: "N/m", given: true },
  delta_n: { symbol: "δₙ", unit: "nm", given: true }, delta_t: { symbol: "δₜ", unit: "nm", given: true },
  nu: { symbol: "ν", unit: "", given: true }, radius: { symbol: "R", unit: "w", given: true },
  width: { symbol: "width", unit: "nm", given: true }, u_x_max: { symbol: "u_x_max", unit: "nm", given: true },
  drive_t: { symbol: "drive kₜ", unit: "MPa/nm", given: true },
  drive_n: { symbol: "drive kₙ", unit: "MPa/nm", given: true },
}
const quantityOf = (name) => QUANTITIES[name] ?? { symbol: name, unit: "", given: true }

export function number(name, value) {
  const { places, given } = quantityOf(name)
  if (given) return minus(value)
  return places === undefined ? digits(Number(value.toFixed(DECIMALS))) : fixed(value, places)
}
const followed = (text, unit) => (unit ? `${text} ${unit}` : text)
export const withUnit = (name, value) => followed(number(name, value), quantityOf(name).unit)
// "E = 70 GPa"
export const named = (name, value) => `${quantityOf(name).symbol} = ${withUnit(name, value)}`
// As one says it: "195 newtons per metre"
export const spoken = (name, value) => `${number(name, value)} ${SPOKEN[quantityOf(name).unit]}`

// Names of the parameters in which scenes differ, of those that both have; a number may be written as a text
export const differing = (a, b) => Object.keys(a).filter((name) => (
  name in b && String(a[name]) !== String(b[name]) && Number(a[name]) !== Number(b[name])))
