// A measured curve and a run: which stage of the run each segment belongs to, and how far both are apart. The rules are
// those of solver/measured/comparison.py; a test compares both.

const WAY = { approach: "approach", retract: "unload" } // stages of a run for segments of a load
const SLIDES = ["shear", "back", "forth", "move"]
const TRIALS = 200 // zeros of delta that are tried
const FINER = 30 // halvings of the step around the best of them

// The quantity that the curves are compared by
export const mainOf = ({ kind }) => (kind === "load" ? "L" : kind.startsWith("area") ? "A" : "F")

// The quantities that scale and zero of the instrument act on
const scaledOf = (curve) => {
  const newtons = Object.keys(curve.units).filter((name) => curve.units[name] === "N")
  return newtons.length ? newtons : [mainOf(curve)]
}

// The stages of a run in their order: {kind, from, to}, frames [from, to)
function stagesOf(run) {
  const stages = []
  for (let k = 0; k < run.length; k++) {
    const leg = run.leg(k)
    if (stages.at(-1)?.leg !== leg) stages.push({ leg, kind: run.stage(k), from: k, to: k })
    stages.at(-1).to = k + 1
  }
  return stages
}

const firstSlip = (run) => run.curves.slip.findIndex((slipped, k) => slipped && SLIDES.includes(run.stage(k)))

// The stage of a run for the i-th segment of a curve; undefined where it has none
function stageFor(curve, i, run) {
  const { kind, segments, virgin } = curve, stages = stagesOf(run), { name } = segments[i]
  if (kind === "load") {
    const again = name === "approach" && segments.slice(0, i).some((one) => one.name === "retract")
    return stages.find((stage) => stage.kind === (again ? "reload" : WAY[name]))
  }
  if (kind === "area over load") return stages[0]
  const slides = stages.filter((stage) => SLIDES.includes(stage.kind))
  if (kind === "area over force") { // up to the first slip
    const slip = firstSlip(run), [first] = slides
    return first && { ...first, to: slip < 0 ? first.to : Math.min(first.to, slip) }
  }
  const same = slides.filter((stage) => (stage.kind === "back") === (name === "back"))
  return (kind !== "loop" || virgin) && same.includes(slides[i]) ? slides[i] : same.at(-1)
}

// What a number of a curve is multiplied by to be that of a run: N/m or nm
export function unitOf(curve, name, run) {
  const { force, middle } = run.head, { F, F_slip, A } = run.curves
  switch (curve.units[name]) {
    case "w E": return force
    case "w": return 2 * middle
    case "A_0": return A[Math.max(0, run.sheared)] || 1
    case "F_s": {
      const slip = firstSlip(run)
      return slip < 0 ? Math.max(...F.map(Math.abs)) : F_slip[slip]
    }
    default: return 1
  }
}

// Points {x, y} of a quantity as they are drawn over a run, in its units; set: {scale, zero, shift}
export function pointsOf(curve, name, run, set, segments = curve.segments) {
  const scaled = scaledOf(curve), { over } = curve, drawn = segments.filter((one) => one[name])
  const scale = (of, v) => (scaled.includes(of) ? set.scale * v + set.zero : v)
  const lengths = over === "U_x" || over === "delta", unit = unitOf(curve, name, run)
  const place = lengths ? 1 : unitOf(curve, over, run)
  const across = lengths ? (v) => v + set.shift : (v) => place * scale(over, v)
  return { x: drawn.flatMap(({ x }) => x.map(across)),
    y: drawn.flatMap((one) => one[name].map((v) => unit * scale(name, v))) }
}

// A run along one of its stages as a function of the abscissa; beyond its ends it keeps the last value
function along(run, over, name, { from, to }) {
  const frames = Array.from({ length: to - from }, (_, i) => from + i)
  frames.sort((a, b) => run.curves[over][a] - run.curves[over][b])
  const [x, y] = [over, name].map((of) => frames.map((k) => run.curves[of][k])), last = x.length - 1
  return { low: x[0], high: x[last], value(at) {
    if (at <= x[0]) return y[0]
    if (at >= x[last]) return y[last]
    let low = 0, high = last
    while (high - low > 1) {
      const half = (low + high) >> 1
      if (x[half] <= at) low = half
      else high = half
    }
    return y[low] + ((y[high] - y[low]) * (at - x[low])) / (x[high] - x[low])
  } }
}

export const largest = (list) => list.reduce((most, v) => Math.max(most, Math.abs(v)), 0)

// A curve over a run: legs, the segments with the run along their stages; null where the run has none for one of them
export function laidOver(curve, run) {
  const name = mainOf(curve), stages = curve.segments.map((_, i) => stageFor(curve, i, run))
  if (!stages.every((stage) => stage && stage.to - stage.from > 1)) return null
  const legs = curve.segments.map((segment, i) => ({ segment, ...along(run, curve.over, name, stages[i]) }))
  return new LaidOver(curve, run, legs)
}

class LaidOver {
  constructor(curve, run, legs) {
    Object.assign(this, { curve, run, legs, name: mainOf(curve), unit: unitOf(curve, mainOf(curve), run) })
    this.points = legs.reduce((sum, { segment }) => sum + segment.x.length, 0)
  }

  // How far both are apart: {rms, noise, outside, points, from, to}; rms, of the points within the run, and noise in
  // the unit of the curve (N/m for N); from and to: the range of its abscissa. Null where no point lies within
  apart(set) {
    const found = { outside: 0, points: this.points, from: Infinity, to: -Infinity }
    let sum = 0
    for (const { segment, value, low, high } of this.legs) {
      const { x, y } = pointsOf(this.curve, this.name, this.run, set, [segment])
      for (const [k, at] of x.entries()) {
        found.from = Math.min(found.from, at)
        found.to = Math.max(found.to, at)
        if (at < low || at > high) found.outside++
        else sum += ((y[k] - value(at)) / this.unit) ** 2
      }
    }
    const times = this.curve.units[this.name] === "N" ? Math.abs(set.scale) : 1, inside = this.points - found.outside
    return inside && { ...found, rms: Math.sqrt(sum / inside), noise: times * this.curve.noise[this.name] }
  }

  // Scale and zero with the least squares at a shift, of the points within the run; of a force that an area is over,
  // the largest of both
  scaled(shift) {
    const { curve, legs, name, run, unit } = this
    if (scaledOf(curve).includes(curve.over)) {
      const most = largest(legs.flatMap(({ low, high }) => [low, high])) / unitOf(curve, curve.over, run)
      return { scale: most / largest(legs.flatMap(({ segment }) => segment.x)), zero: 0, shift }
    }
    const pairs = legs.flatMap(({ segment, value, low, high }) => segment.x.flatMap((x, k) => (
      x + shift < low || x + shift > high ? [] : [[value(x + shift) / unit, segment[name][k]]])))
    const [f, y] = [0, 1].map((side) => pairs.reduce((sum, pair) => sum + pair[side], 0) / pairs.length)
    const square = pairs.reduce((sum, pair) => sum + (pair[1] - y) ** 2, 0)
    const scale = square ? pairs.reduce((sum, pair) => sum + (pair[0] - f) * (pair[1] - y), 0) / square : 1
    return { scale, zero: f - scale * y, shift }
  }

  // The setting of the instrument with the least squares; all: also scale and zero of a force whose unit is known.
  // Null where it is sought, and none with a positive scale brings half of the points over the run
  matched(all = false) {
    const { curve, legs } = this, inNewtons = Object.values(curve.units).includes("N")
    const setting = (shift) => (all || inNewtons ? this.scaled(shift) : { scale: 1, zero: 0, shift })
    const far = (shift) => {
      const set = setting(shift), apart = set.scale > 0 && this.apart(set)
      return apart && 2 * apart.outside <= apart.points ? apart.rms / (inNewtons ? set.scale : 1) : Infinity
    }
    if (!curve.free) return (!all && !inNewtons) || far(0) < Infinity ? setting(0) : null
    const xs = legs.flatMap(({ segment }) => segment.x)
    const first = Math.min(...legs.map(({ low }) => low)) - Math.max(...xs)
    let step = (Math.max(...legs.map(({ high }) => high)) - Math.min(...xs) - first) / TRIALS
    const tried = Array.from({ length: TRIALS - 1 }, (_, k) => first + (k + 1) * step).map((at) => [far(at), at])
    let best = tried.reduce((a, b) => (b[0] < a[0] ? b : a))
    for (let k = 0; k < FINER; k++) {
      step /= 2
      for (const at of [best[1] - step, best[1] + step]) if (far(at) < best[0]) best = [far(at), at]
    }
    return best[0] < Infinity ? setting(best[1]) : null
  }
}
