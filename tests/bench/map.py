"""Cost and errors of a map of first slips: delta_bar x phi_ratio, 41 x 31 points, on two processes.

    python tests/bench/map.py [--set NAME=VALUE ...] [--points X Y] [--workers N] [--checks N] [--json FILE]

Prints the share of points followed and force evaluations; on stderr, the seconds that the map took, with the start of
its processes. Random points are then run from their start: how many are of another regime, the largest error of U_s
(nm), how many followed points are wrong.
"""

import sys
import time
from dataclasses import asdict

import numpy as np
from scenes import options, sheared, write

from solver import NotConverged, load_path
from solver.analysis.maps import Axis, Map, explore_map
from solver.analysis.maps.point import touches
from solver.analysis.maps.task import computed
from solver.cli.options import scene_of
from solver.executors import processes

WANTED = 1e-3  # nm, of U_s


def slip_of(scene):
    """(U_s or None, whether it touches) of a run up to its first slip; shares nothing with maps but `load_path`."""
    begun = None
    try:
        for frame in load_path(scene):
            if frame.stage != "shear":
                continue
            begun = frame if begun is None else begun
            if events := sheared([frame]):
                return events[0].load, touches(begun)
            if frame.U_x > 1.2 * scene.spacing and frame.u[0].min() > scene.spacing:  # all of it slides
                return None, touches(begun)
    except NotConverged:
        return np.nan, False
    return None, touches(begun)


def checked(grid, points, count):
    """Rows of `count` random points against runs."""
    rng = np.random.default_rng(5)
    for k in rng.choice(len(points), min(count, len(points)), replace=False):
        point = points[k]
        values = {grid.x.name: float(grid.x.values[point.i]), grid.y.name: float(grid.y.values[point.j])}
        exact, _ = computed(grid.scene.changed(**values))
        U_s, touching = slip_of(grid.scene.changed(**values))
        U_s = U_s if touching else None
        off = 0.0 if U_s == point.U_s else np.inf if None in (U_s, point.U_s) else abs(U_s - point.U_s)
        alike = (point.regime, point.sites) == (exact.regime, exact.sites)
        yield values | {"off": off, "alike": alike, "followed": point.followed, "regimes": [point.regime, exact.regime]}


def summary(points, seconds, rows):
    followed, run = ([p for p in points if p.followed == which] for which in (True, False))
    touching = [p for p in points if p.regime != "never touches"]
    spent = {name: [p.evaluations for p in some] for name, some in (("followed", followed), ("run", run))}
    return {
        "points": len(points),
        "seconds": seconds,
        "followed": len(followed) / len(points),
        "followed_of_touching": sum(p.followed for p in touching) / max(1, len(touching)),
        "evaluations": {name: [int(sum(n)), float(np.median(n or [0]))] for name, n in spent.items()},
        "cost": sum(p.evaluations for p in points) / (len(points) * float(np.median(spent["run"] or [np.nan]))),
        "no_result": sum(bool(p.reason) for p in points),
        "checked": len(rows),
        "other_regime": sum(not row["alike"] for row in rows),
        "U_s_worst": max((row["off"] for row in rows), default=0.0),
        "wrong_follows": sum(row["followed"] and (row["off"] > WANTED or not row["alike"]) for row in rows),
        "followed_checked": sum(row["followed"] for row in rows),
    }


def report(found, rows):
    print(f"complete after {found['seconds']:.1f} s", file=sys.stderr)
    print("{points} points, followed {followed:.1%}, of those that touch {followed_of_touching:.1%}".format(**found))
    for name, (total, median) in found["evaluations"].items():
        print(f"evaluations, {name}: {total}, median {median:g}")
    print(f"evaluations of the map over those of a run of this median at every point: {found['cost']:.2f}")
    print(
        "{checked} checked: {other_regime} of another regime, U_s off by {U_s_worst:.1e} nm at most;"
        " {wrong_follows} of {followed_checked} followed are wrong".format(**found)
    )
    for row in rows:
        if row["off"] > WANTED or not row["alike"]:
            print(row, file=sys.stderr)


def main():
    parser = options(__doc__)
    parser.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE")
    parser.add_argument("--points", nargs=2, type=int, default=[41, 31], metavar=("X", "Y"))
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--checks", type=int, default=60)
    arguments = parser.parse_args()
    x, y = arguments.points
    grid = Map(scene_of(arguments.set), Axis("delta_bar", -1.0, 1.0, x), Axis("phi_ratio", 0.02, 2.0, y, True))
    start = time.perf_counter()
    points = list(explore_map(grid, processes(arguments.workers)))
    seconds = time.perf_counter() - start
    rows = list(checked(grid, points, arguments.checks))
    found = summary(points, seconds, rows)
    report(found, rows)
    write(arguments.json, {"summary": found, "points": [asdict(p) for p in points], "rows": rows})
    return 0


if __name__ == "__main__":
    sys.exit(main())
