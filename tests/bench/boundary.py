"""Boundaries of stick-slip, `solver.boundary` against bisection by whole runs, and what marks cost.

    python tests/bench/boundary.py [--scenes 24] [--from K] [--limit 120] [--json FILE]
    PYTHONPATH=CHECKOUT python tests/bench/boundary.py --costs [--json FILE]

Punches, waves, rough surfaces, flats and held loads in turn, each by phi_ratio or by E. For each it prints the boundary
over that of bisection, and whether runs slip at 0.997 and 1.003 of it. With --costs it prints the processor time and
the force evaluations of the marks, without those of the run, of the version that CHECKOUT holds.
"""

import statistics
import sys
import time

import numpy as np
from scenes import even, geometric, numbered, ran, scene_of, sheared, write

from solver import NotConverged, NotFollowed, skeleton_of
from solver.analysis.marks import ENDS, of_skeleton
from solver.mechanics.contact import Contact

NAMES = "phi_ratio", "E"
FINE = 1e-6  # relative width of the bracket of bisection
BESIDE = 0.003  # of the boundary: runs there slip on one side only
REPEATS = 5  # of which the least processor time counts


def scenes(count):
    """(parameters, name) of scenes; every second one slides smoothly or nearly so."""
    for k in range(count):
        rng, name = np.random.default_rng((69, k)), NAMES[k % 2]
        kind = ("circular", "wave", "rough", "flat", "held", "circular")[k // 2 % 6]
        smooth = k // 2 % 2
        values = {"E": geometric(rng, 20.0, 300.0), "phi_ratio": geometric(rng, *((0.3, 2.0), (0.005, 0.05))[smooth])}
        nodes = int(rng.integers(64, 193))
        cell = {"nodes": nodes, "width": nodes * even(rng, 2.2, 2.7), "height": geometric(rng, 0.5, 2.0)}
        if kind == "circular":
            values |= {"delta_bar": even(rng, -0.25, 0.8)}
        if kind == "held":
            values |= {"delta_bar": even(rng, 0.0, 0.8), "hold": "load"}
        if kind == "wave":
            values |= cell | {"surface": kind, "waves": int(rng.integers(1, 4)), "amplitude": geometric(rng, 0.3, 3.0)}
            values |= {"delta_bar": even(rng, 0.0, 0.5)}
        if kind == "rough":
            values |= cell | {"surface": kind, "seed": int(rng.integers(1, 10_000)), "cut_off": 0.1}
            values |= {"rms_slope": geometric(rng, 2e-3, 0.01), "delta_bar": even(rng, 0.0, 0.5)}
        if kind == "flat":
            values |= cell | {"surface": kind, "delta_bar": even(rng, 0.0, 0.3)}
        yield values | {"u_x_max": 40.0}, name


def slips(values, name, value, limit):
    """Whether a run slips in shear before it repeats itself; None if it ends early."""
    frames, _, failure = ran(scene_of(values, **{name: float(value)}), limit, lambda f: f.repeated or sheared([f]))
    return None if failure else bool(sheared(frames))


def bisected(values, name, guess, limit):
    """(the boundary by whole runs, their number), between 0.9 and 1.1 of a guess; nan where both ends are alike."""
    way = 1.0 if name == "phi_ratio" else -1.0  # slips are at larger phi_ratio, at smaller E
    low, high = (guess * (1.0 - 0.1 * way), guess * (1.0 + 0.1 * way))  # smooth, slips
    runs = 2
    if slips(values, name, low, limit) is not False or slips(values, name, high, limit) is not True:
        return np.nan, runs
    while abs(high / low - 1.0) > FINE:
        middle = 0.5 * (low + high)
        runs += 1
        if slips(values, name, middle, limit):
            high = middle
        else:
            low = middle
    return 0.5 * (low + high), runs


def compared(values, name, limit):
    """The row of a scene: its boundary against bisection and against runs beside it."""
    from solver import boundary

    scene = scene_of(values)
    try:
        found = boundary(scene, name)
    except NotConverged as failure:
        return {"value": None, "why": str(failure)}
    row = {"value": found.value, "evaluations": found.evaluations, "why": found.why}
    if found.value is None:
        return row
    low, high = min(ENDS[name]), max(ENDS[name])
    row["on the slider"] = low <= found.value <= high
    way = 1.0 if name == "phi_ratio" else -1.0
    beside = [slips(values, name, found.value * (1.0 + sign * way * BESIDE), limit) for sign in (-1.0, 1.0)]
    row["beside"] = beside == [False, True]
    exact, row["runs"] = bisected(values, name, found.value, limit)
    return row | {"exact": exact, "off": abs(found.value / exact - 1.0)}


def counted():
    """[force evaluations so far, of all contacts], from now on."""
    count, before = [0], Contact.evaluated

    def evaluated(self, *moving, **more):  # older versions know no `times`
        count[0] += more.get("times", 1)
        return before(self, *moving, **more)

    Contact.evaluated = evaluated
    return count


def cost(values, count):
    """{slider: (mark, processor time in s, force evaluations)} of the marks of a scene; None without a skeleton."""
    try:
        skeleton = skeleton_of(scene_of(values))
    except (NotFollowed, NotConverged):
        return None
    row = {}
    for name in NAMES:
        times = []
        for _ in range(REPEATS):
            before, start = count[0], time.process_time()
            marks = of_skeleton(skeleton, name)
            times.append(time.process_time() - start)
        row[name] = [marks[0][0] if marks else None, min(times), count[0] - before]
    return row


def main():
    options = numbered(__doc__, 24)
    options.add_argument("--limit", type=float, default=120.0, help="processor time of a run, s")
    options.add_argument("--costs", action="store_true", help="of the marks alone")
    chosen, rows, count = options.parse_args(), [], counted()
    for k, (values, name) in enumerate(scenes(chosen.scenes)):
        if k < chosen.first or (chosen.costs and k % 2):  # costs are of both sliders
            continue
        row = cost(values, count) if chosen.costs else compared(values, name, chosen.limit)
        rows.append({"scene": values, "name": name, "found": row})
        print(k, values.get("surface", values.get("hold", "circular")), name, row, file=sys.stderr, flush=True)
        write(chosen.json, rows)
    if chosen.costs:
        spent = [by for row in rows if row["found"] for by in row["found"].values()]
        seconds, evaluations = (statistics.median(by[i] for by in spent) for i in (1, 2))
        print(f"{len(spent)} sliders, {sum(by[0] is not None for by in spent)} marks; median {seconds:.3f} s,", end=" ")
        print(f"{evaluations:g} force evaluations")
        return
    found = [row["found"] for row in rows if row["found"]["value"] is not None]
    errors = [row["off"] for row in found if np.isfinite(row["off"])]
    print(f"{len(rows)} scenes, {len(found)} boundaries, {sum(row['on the slider'] for row in found)} on the slider;")
    print(f"largest error {max(errors, default=np.nan):.2g} of {len(errors)} bisected;", end=" ")
    print(f"no slip below and a slip above: {sum(row['beside'] for row in found)} of {len(found)}")


if __name__ == "__main__":
    main()
