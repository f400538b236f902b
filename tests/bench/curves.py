"""Error against run time by four methods, and the branches that they reach: the solver, and three transients.

    python tests/bench/curves.py [--quick] [--set NAME=VALUE ...] [--picture FILE] [--page]
                                 [--json FILE]

Sweeps the tolerance of one scene as `python -m solver accuracy` does, with mass-weighted GFMD and FIRE beside the
paper's GFMD (tests/shared/transients.py). Then it compares states after each slip with those of the paper's GFMD from
equilibrium to equilibrium (`Halving`). Slips whose landing is sensitive are left out: the transient itself bifurcates.
--picture draws the sweep, docs/accuracy.png, with the extra `docs`. --page writes what the page "Accuracy" opens with.
"""

import json
import sys
from dataclasses import asdict
from itertools import pairwise
from math import inf
from pathlib import Path

import numpy as np
from scenes import options, write

from transients import Fire, Halving, MassWeighted  # isort: skip  (scenes makes it importable)
from solver import NotConverged, Scene, load_path, scene_from_text, whole_surface
from solver.accuracy.compare import in_range
from solver.accuracy.measure import SERIES, measure, shortened

ROOT = Path(__file__).parents[2]
sys.path.append(str(ROOT / "docs"))
from evidence import origin  # noqa: E402

PAGE = ROOT / "app" / "features" / "accuracy" / "accuracy.json"
METHODS = SERIES | {"gfmd mass-weighted": MassWeighted, "FIRE": Fire}
# Colours of Okabe & Ito, which colour-blind readers distinguish; markers for print
STYLE = dict(zip(METHODS, (("#0072B2", "o"), ("#D55E00", "s"), ("#009E73", "^"), ("#CC79A7", "D")), strict=True))
WORK = {"seconds": "run time [s of one core]", "evaluations": "force evaluations"}
SAME = 0.1  # of min(delta_n, delta_t): equilibria farther apart are two; a node that slips moves farther
STEP = 0.5  # nm, the longest increment of the judge; longer than a site, it would hide slips
TOLERANCE = 1e-5  # nm, of the judge: branches lie ten thousand times as far apart


def judge_of(scene):
    """The scene for `Halving`: at long increments that the scene's own divide, and at the tolerance TOLERANCE."""
    for name in ("du_x", "du_z"):
        own = getattr(scene, name)
        longer = [own * factor for factor in (5, 2) if own * factor <= STEP]
        scene = scene.changed(**{name: in_range(scene, name, [*longer, own])[0]})
    return scene.changed(tolerance=max(TOLERANCE, 2.0 * scene.attainable))


def states(scene, method):
    """{U_x: u of the whole surface} and the slips in shear, by a method; up to a failure."""
    found, slips = {}, []
    try:
        for frame in load_path(scene, method):
            if frame.stage == "shear":
                found[round(frame.U_x, 9)] = whole_surface(frame)
                slips += frame.slips
    except NotConverged as failure:
        print(f"{method}: {failure}")
    return found, slips


def branches(scene, sensitive):
    """{method: (slips after which it is where the paper's GFMD is, slips compared)}; sensitive: loads left out."""
    right, slips = states(judge_of(scene), Halving)
    ends = [event.load for event in slips] + [inf]
    parts = [(low, high) for low, high in pairwise(ends) if all(abs(low - load) > STEP for load in sensitive)]
    counts = {}
    for name, method in METHODS.items():
        own, _ = states(scene, method)
        same = []
        for low, high in parts:
            # an increment beyond the first: near the end of a branch a loose tolerance may delay the slip
            both = [at for at in sorted(own.keys() & right.keys()) if low < at < high]
            both = [at for at in both if low + scene.du_x * scene.delta_t < at][:1] or both[-1:]
            same += [np.abs(own[at] - right[at]).max() < SAME * min(scene.delta_n, scene.delta_t) for at in both]
        counts[name] = sum(map(int, same)), len(same)
    return counts


def picture(points, file):
    """Draw the error before the first slip over run time and over force evaluations."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(1, 2, figsize=(11, 4.3), sharey=True, layout="constrained")
    for plot, (work, label) in zip(axes, WORK.items(), strict=True):
        for name, (colour, marker) in STYLE.items():
            own = [p for p in points if p.series == name]
            place = [getattr(p, work) for p in own], [p.branch_error for p in own]
            plot.loglog(*place, color=colour, marker=marker, label=name)
            for x, y, p in zip(*place, own, strict=True):
                plot.annotate(f"{p.value:g}", (x, y), (5, 5), textcoords="offset points", fontsize=8, color=colour)
        plot.set_xlabel(label)
    axes[0].set_ylabel("F, L, A before the first slip: largest relative error")
    axes[0].set_title("tolerance swept [nm]: values beside the points", fontsize=10)
    axes[1].legend()
    figure.savefig(file, dpi=100)


def main():
    parser = options(__doc__)
    parser.add_argument("--quick", action="store_true", help="one slip and fewer tolerances")
    parser.add_argument("--set", nargs="+", default=[], metavar="NAME=VALUE", help="parameters of the scene")
    parser.add_argument("--picture", metavar="FILE", help="draw the sweep")
    parser.add_argument("--page", action="store_true", help=f"write {PAGE.name} of the app, for the default scene")
    chosen = parser.parse_args()
    scene = scene_from_text(dict(pair.split("=", 1) for pair in chosen.set)) if chosen.set else Scene()
    *_, (_, report) = measure(scene, chosen.quick, series=METHODS)
    points = [p for p in report.of("tolerance") if p.branch_error is not None]
    print(f"{'method':20}{'tolerance':>10}{'seconds':>10}{'evaluations':>12}{'error':>9}")
    for p in points:
        print(f"{p.series:20}{p.value:10.0e}{p.seconds:10.2g}{p.evaluations:12}{p.branch_error:9.0e}")
    sensitive = [event.load for event in report.known_slips if event.sensitive]
    counts = branches(shortened(report.scene, report.slips)[0], sensitive)
    print("Where the paper's GFMD is after a slip:", ", ".join(f"{n} {a} of {b}" for n, (a, b) in counts.items()))
    if chosen.picture:
        picture(points, chosen.picture)
    if chosen.page:
        own = [asdict(p) for p in points if p.series in SERIES]
        PAGE.write_text(json.dumps(origin() | {"points": own}, indent=1) + "\n", encoding="utf-8")
    write(chosen.json, {"points": [asdict(p) for p in points], "branches": counts})


if __name__ == "__main__":
    main()
