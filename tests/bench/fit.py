"""Fits of synthetic curves: whether they find the truth, how long they take, and whether their errors are right.

    python tests/bench/fit.py [--draws N] [--starts N] [--box N] [--sparse N] [--points N] [--json FILE]

Data are F and L at 400 points, with noise of 1 % of the largest of each, and three parameters are free. F alone does
not determine these three, which a fit reports (tests/solver/test_fit.py).
Time: seconds of one fit from 20 % off.
Coverage: 200 draws of truth (within 5 %) and noise; how often the 95 % interval of each parameter holds its truth.
Starts: 30 scenes near one punch from 50 % off; how many fits reach the truth within four standard errors, and what the
others report. A fit that ends elsewhere without a warning is wrong.
Box: the same for 30 scenes of the slider box, those of `follow.py`.
Sparse: F alone at few points (SPARSE) over 13 periods, with and without noise, one parameter from 20 % off, of 24
scenes; how many fits are right, and how many are wrong without a warning.
"""

import argparse
import json
import math
import sys
import time
from itertools import product
from pathlib import Path

import numpy as np

from solver import NotConverged, NotFollowed, Scene, SceneError, follow, skeleton_of
from solver.measured.fit import fit
from solver.measured.measurement import Measurement

sys.path.insert(0, str(Path(__file__).resolve().parent))
from scenes import scene_of, slider_box

BASE = Scene(nodes=256, width=625.0, delta_bar=0.1, u_x_max=40.0)
FREE = ("phi_n", "phi_ratio", "delta_bar")
NOISE = 0.01  # of the largest F, and L
WIDE = 1.96  # standard errors: 95 %
NEAR = 4.0  # standard errors, within which the truth counts as reached
SPARSE = (40, 60, 104)  # points; 3, 5 and 8 a period
ALONE = ("E", "phi_ratio", "delta_bar", "phi_n")  # the parameter of a sparse fit, in turn


def moved(scene, share, rng, signs_only=False):
    """The scene with each of FREE off by up to `share`, or by just that up or down."""
    values = {}
    for name in FREE:
        part = rng.choice((-1.0, 1.0)) if signs_only else rng.uniform(-1.0, 1.0)
        values[name] = getattr(scene, name) * (1.0 + share * part)
    return scene.changed(**values)


def measured(skeleton, points, rng, noise=NOISE, names=("F_bar", "L_bar")):
    U_x = np.linspace(0.0, skeleton.scene.u_x_max, points + 1)[1:]
    curves = zip(names, skeleton.curve(U_x), strict=False)
    return Measurement.of(U_x, {name: y + noise * np.abs(y).max() * rng.normal(size=points) for name, y in curves})


def off(found, scene):
    """Errors of parameters over their standard errors."""
    return {name: (value - getattr(scene, name)) / found.errors[name] for name, value in found.values.items()}


def sparse(count):
    """Rows of up to `count` scenes for each of SPARSE, with and without noise: whether a fit is right, or warns."""
    rng, rows = np.random.default_rng(6), []
    for number in range(count):
        values = {"E": (30.0, 150.0), "phi_ratio": (0.3, 2.0)}
        values = {name: math.exp(rng.uniform(*np.log(ends))) for name, ends in values.items()}
        scene, name = BASE.changed(delta_bar=rng.uniform(-0.1, 0.5), **values), ALONE[number % len(ALONE)]
        size = 0.1 if name == "delta_bar" else 0.2 * getattr(scene, name)
        start = scene.changed(**{name: getattr(scene, name) + rng.choice((-1.0, 1.0)) * size})
        try:
            skeleton = skeleton_of(scene)
        except (NotFollowed, NotConverged):
            continue
        for points, noise in product(SPARSE, (0.0, NOISE)):
            data = measured(skeleton, points, rng, noise, ("F_bar",))
            rows.append({"points": points, "noise": noise, "name": name} | one_parameter(start, scene, name, data))
    for points, noise in product(SPARSE, (0.0, NOISE)):
        mine = [row for row in rows if (row["points"], row["noise"]) == (points, noise)]
        right, silent = sum(row["right"] for row in mine), sum(not (row["right"] or row["warnings"]) for row in mine)
        print(f"{points} points, noise {noise:g}: {right} of {len(mine)} right,", end=" ")
        print(f"{silent} wrong without a warning; longest {max(row['seconds'] for row in mine):.3g} s", flush=True)
    return rows


def one_parameter(start, scene, name, data):
    """The row of a fit of one parameter: right within NEAR standard errors or 1 %."""
    begun = time.perf_counter()
    try:
        result = fit(start, data, (name,))
    except (NotFollowed, NotConverged, SceneError) as failure:
        return {"right": False, "warnings": [str(failure)], "seconds": time.perf_counter() - begun}
    truth = getattr(scene, name)
    near = abs(result.values[name] / truth - 1.0) <= 0.01
    right = near or (result.reached and abs(off(result, scene)[name]) <= NEAR)
    row = {"right": bool(right), "value": result.values[name], "truth": truth, "chi2": result.chi2}
    return row | {"warnings": result.warnings, "seconds": time.perf_counter() - begun}


def coverage(base, draws, points):
    rng, rows = np.random.default_rng(3), []
    for number in range(draws):
        scene = moved(BASE, 0.05, rng)
        try:
            data = measured(follow(base, scene), points, rng)
            found = fit(BASE, data, FREE)
        except (NotFollowed, NotConverged) as failure:
            print(f"draw {number}: {failure}", file=sys.stderr, flush=True)
            continue
        rows.append(off(found, scene) | {"chi2": found.chi2, "reached": found.reached})
    for name in FREE:
        held = np.mean([abs(row[name]) <= WIDE for row in rows])
        print(f"{name:10} 95 % intervals hold the truth in {held:.1%} of {len(rows)} draws", flush=True)
    return rows


def near(count):
    """`count` scenes near BASE."""
    rng = np.random.default_rng(4)
    return [moved(BASE, 0.3, rng) for _ in range(count)]


def starts(some, points):
    rng, rows = np.random.default_rng(5), []
    for number, scene in enumerate(some):
        try:
            data = measured(skeleton_of(scene), points, rng)
            found = fit(moved(scene, 0.5, rng, signs_only=True), data, FREE)
        except (NotFollowed, NotConverged, SceneError) as failure:
            rows.append({"right": False, "said": True, "why": str(failure)})
            print(f"start {number}: {failure}", file=sys.stderr, flush=True)
            continue
        right = max(map(abs, off(found, scene).values())) <= NEAR
        right, said = right and found.reached, not found.reached or any("told apart" in one for one in found.warnings)
        rows.append({"right": right, "said": said and not right, "warnings": found.warnings})
        if not rows[-1]["right"]:
            start = f"{scene.E:.4g} GPa, {scene.delta_bar:.3g}, {scene.phi_ratio:.3g}"
            ended = f"chi^2 {found.chi2:.3g}, off by {off(found, scene)}"
            print(f"start {number}: {start}; {ended}", file=sys.stderr, flush=True)
    right, said = (sum(row[name] for row in rows) for name in ("right", "said"))
    print(f"from 50 % off: {right} of {len(some)} reach the truth, {said} say that they did not,", end=" ")
    print(f"{len(some) - right - said} wrong", flush=True)
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=200)
    parser.add_argument("--starts", type=int, default=30)
    parser.add_argument("--box", type=int, default=30)
    parser.add_argument("--sparse", type=int, default=24)
    parser.add_argument("--points", type=int, default=400)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    base, rng = skeleton_of(BASE), np.random.default_rng(2)
    data = measured(base, arguments.points, rng)
    fit(BASE, data, FREE)  # compiled, before anything is timed
    start = time.perf_counter()
    found = fit(moved(BASE, 0.2, rng, signs_only=True), data, FREE)
    seconds = time.perf_counter() - start
    print(
        f"{len(FREE)} parameters, {arguments.points} points: {seconds:.3g} s, {found.runs} runs, chi^2 {found.chi2:.3g}"
    )
    report = {"seconds": seconds, "runs": found.runs}
    report["coverage"] = coverage(base, arguments.draws, arguments.points)
    report["starts"] = starts(near(arguments.starts), arguments.points)
    report["sparse"] = sparse(arguments.sparse)
    report["box"] = starts([scene_of(values) for values in slider_box(arguments.box)], arguments.points)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(report, indent=2), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
