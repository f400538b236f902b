"""The unstable branch of the first slip of random punches: where it ends, and what it costs.

    python tests/bench/unstable.py [--scenes N] [--seed N] [--json FILE]

A punch is symmetric, so that the mirror image of the fold where the slip begins, moved on by a site, is the fold where
the next branch begins: U_x = spacing - U_s, found without the walk. The cost is processor time over that of the exact
run, both in this process; scenes without a slip in shear, or whose runs have no skeleton, are counted.
"""

import sys
import time
from statistics import median

import numpy as np
from scenes import options, write

from solver import NotFollowed, Scene, simulate, unstable_branch

FAR = 1e-6  # nm, between the end and the mirror image
NAMED = {"default": {}, "depth 1": {"delta_bar": 1.0}, "ratio 2": {"phi_ratio": 2.0}, "E 40": {"E": 40.0}}


def punches(count, seed):
    """{name: parameters of a Scene} within the sliders' ranges, from E = 20 on: softer runs end by flutter."""
    rng, made = np.random.default_rng(seed), dict(NAMED)
    for k in range(count):
        E, ratio = np.exp(rng.uniform(np.log([20.0, 0.1]), np.log([400.0, 3.0])))
        made[str(k)] = {"E": round(float(E), 1), "delta_bar": round(rng.uniform(-0.4, 1.2), 2)}
        made[str(k)]["phi_ratio"] = round(float(ratio), 2)
    return made


def measured(values):
    """A row: "none" says why there is no branch; else its end, cost and points."""
    begun, result = time.process_time(), simulate(Scene(**values))
    run = time.process_time() - begun
    try:
        begun = time.process_time()
        branch = unstable_branch(result)
    except (NotFollowed, IndexError) as reason:
        return {"none": str(reason).split(":")[0]}
    cost = (time.process_time() - begun) / run
    off = abs(branch.U_x[-1] - (result.scene.spacing - branch.U_x[0])) if branch.ends else np.inf
    return {"cost": cost, "points": len(branch.U_x), "evaluations": branch.evaluations, "off": off, "why": branch.why}


def main():
    parser = options(__doc__)
    parser.add_argument("--scenes", type=int, default=60, help="random punches (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    arguments, rows = parser.parse_args(), []
    measured({})  # loads the kernels
    for name, values in punches(arguments.scenes, arguments.seed).items():
        rows.append({"name": name, "scene": values} | measured(values))
        print(rows[-1], file=sys.stderr, flush=True)
    found = [row for row in rows if "cost" in row]
    ended = [row for row in found if row["off"] < np.inf]
    print(f"{len(rows)} punches, {len(found)} with a branch; {len(ended)} lead to the next branch,", end=" ")
    print(f"{sum(row['off'] > FAR for row in ended)} of them elsewhere than mirrored by more than {FAR:g} nm")
    for name, some in (("all", found), ("that end", ended)):
        costs = sorted(row["cost"] for row in some)
        print(f"    {name}: cost over the run, median {median(costs):.2f}, largest {costs[-1]:.2f};", end=" ")
        print(f"points, median {median(row['points'] for row in some):.0f}")
    for row in found[: len(NAMED)]:
        print(f"{row['name']:12}{row['cost']:8.2f}{row['points']:6}{row['evaluations']:8}  {row['why']}")
    write(arguments.json, rows)


if __name__ == "__main__":
    main()
