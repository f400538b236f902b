// The slips of a run, as the solver located them. Pure functions of runs.

export const AFTER = 1.0 // nm of the path for which a slip is what happens

// Where the slip that led to frame `at` begins, as the solver located it: {at, U (nm), F and L (N/m), A (nm)}; null
// where there is no slip
export function eventOf(run, at) {
  if (at < 0) return null
  const { slip_at: load, F_slip, L_slip, slip_A } = run.curves
  return { at, U: load[at], F: F_slip[at], L: L_slip[at], A: slip_A[at] * 2 * run.head.middle }
}

// The first slip of the shear; of any stage after the approach where `all` of them count
export const firstSlip = (run, all = false) => eventOf(run, run.curves.slip.findIndex((slipped, i) => (
  slipped && i > Math.max(0, run.sheared) && (all || run.stage(i) === "shear"))))
export const firstOfPath = (run) => firstSlip(run, run.head.abscissa === "path")
