// What slips, in lattice sites.

// By how many sites every node of frame `at` has moved since the frame before; the same node in either
export function movedSites(run, at) {
  const [now, before] = [at, at - 1].map((k) => ({ head: run.headOf(k), x: run.frame(k).x }))
  const shift = now.head.first - before.head.first, { spacing, flat } = now.head
  if (flat) return Float32Array.from(now.x, () => Math.round((run.u(at) - run.u(at - 1)) / spacing))
  return now.x.map((x, i) => (i + shift in before.x ? Math.round((x - before.x[i + shift]) / spacing) : 0))
}
