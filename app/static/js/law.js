// The cohesive law, summed over all sites within its window, as solver/mechanics/cohesive_law.py has it.

const DEEPEST = -50, REMOTEST = 60 // of gap / delta_n
const PLACES = 2048 // in a period, of the sums over sites: linear between them, they err by 1e-6

// Sums over the sites of exp(-t^2) and of t exp(-t^2), a node being displaced by r from the nearest one; in delta_t
function sumsAt(r, a, window) {
  let s0 = Math.exp(-r * r), s1 = -r * s0
  for (let k = 1; k <= Math.floor((window + 0.5 * a) / a); k++) {
    for (const t of [k * a - r, -k * a - r].filter((distance) => Math.abs(distance) <= window)) {
      const gaussian = Math.exp(-t * t)
      s0 += gaussian
      s1 += t * gaussian
    }
  }
  return [s0, s1]
}

const tables = new Map() // of these sums, by period and window: a slider changes neither
function sumsOver(a, window) {
  const key = `${a} ${window}`
  if (!tables.has(key)) {
    const sums = Array.from({ length: PLACES + 1 }, (_, k) => sumsAt((k / PLACES - 0.5) * a, a, window))
    tables.set(key, [0, 1].map((i) => Float64Array.from(sums, (pair) => pair[i])))
  }
  return tables.get(key)
}

// law(u, gap, T_x, T_z) fills T_x and T_z, GPa, of nodes displaced by u at a gap, nm; given the numbers of
// `law_constants`
export function lawOf([normal, shear, delta_n, delta_t, a, window, opening]) {
  const [S0, S1] = sumsOver(a, window)
  return (u, gap, T_x, T_z) => {
    for (let i = 0; i < T_x.length; i++) {
      const dn = Math.min(Math.max(gap[i] / delta_n, DEEPEST), REMOTEST), e = Math.exp(-dn)
      const periods = u[i] / delta_t / a + 0.5, at = (periods - Math.floor(periods)) * PLACES, k = Math.floor(at)
      const part = at - k
      T_x[i] = shear * (S1[k] + part * (S1[k + 1] - S1[k])) * (1 + opening * dn) * e
      T_z[i] = -normal * dn * (S0[k] + part * (S0[k + 1] - S0[k])) * e
    }
  }
}
