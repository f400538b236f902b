"""Whether derivatives are right, and what they cost: 40 scenes of the slider box, and wave, rough and held ones of it.

    python tests/bench/sensitivities.py [--scenes N] [--json FILE]

Scenes are those of `follow.py`, each in turn with the punch, a wave, a rough surface, or a held load. Of the first slip
U_s, F_s and A_s, central differences of followed runs, by every continuous parameter: the largest error over the
derivative (of a force, over that of the larger one), and processor time of sensitivities over that of the run, of slips
alone and of the branches between them as well.
Scenes that stick, or whose run is not followed, say so.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

from solver import NotConverged, NotFollowed, Scene, follow, load_path, skeleton_from
from solver.analysis.partial import continuous
from solver.analysis.sensitivities import sensitivities

sys.path.insert(0, str(Path(__file__).resolve().parent))
from follow import ran, scenes, spread

KINDS = (
    {},
    {"surface": "wave", "waves": 1, "amplitude": 10.0},
    {"surface": "rough", "cut_off": 0.2, "rms_slope": 0.003, "roll_off": 0.45},
    {"hold": "load"},
)
STEPS = (1e-3, 1e-4, 1e-5)  # of a parameter; which is best depends on how close the next fold lies, and on the window:
# a node that crosses its edge on the way makes a jump, no derivative
WANTED = 1e-5


def difference(skeleton, name, step):
    """(4,) of the first slip."""
    value = getattr(skeleton.scene, name)
    h, ends = step * max(abs(value), 0.1), []
    for side in (h, -h):
        beside = follow(skeleton, skeleton.scene.changed(**{name: value + side}))
        ends.append(sensitivities(beside, (), branches=False).slips[0].values)
    return (ends[0] - ends[1]) / (2.0 * h)


def errors(skeleton, slip):
    """{parameter: the least over STEPS of the largest error}; those that are not followed are left out."""
    found = {}
    for name in continuous(skeleton.scene):
        size = np.abs(slip.by[name])
        size[1:3] = size[1:3].max()
        size = np.maximum(size, 1e-12)
        for step in STEPS:
            try:
                error = float((np.abs(difference(skeleton, name, step) - slip.by[name]) / size).max())
            except (NotFollowed, IndexError):
                continue
            found[name] = min(error, found.get(name, np.inf))
    return found


def row_of(scene):
    frames, seconds = ran(scene)
    if frames is None:
        return {"why": "the run has no end"}
    try:
        skeleton = skeleton_from(scene, frames)
        skeleton = follow(skeleton, scene)  # whose nodes are active just as in the runs beside it
        costs = []
        for branches in (False, True):
            start = time.process_time()
            found = sensitivities(skeleton, branches=branches)
            costs.append((time.process_time() - start) / seconds)
    except (NotFollowed, NotConverged) as failure:
        return {"why": str(failure)}
    if not found.slips:
        return {"why": "no slip", "costs": costs}
    return {"costs": costs, "seconds": seconds, "errors": errors(skeleton, found.slips[0])}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=40)
    parser.add_argument("--json", metavar="FILE")
    arguments = parser.parse_args()
    small = Scene(u_x_max=12.0)
    sensitivities(skeleton_from(small, list(load_path(small))))  # compiled, before anything is timed
    rows = []
    for number, scene in enumerate(scenes(arguments.scenes)):
        scene = scene.changed(**KINDS[number % len(KINDS)])
        row = row_of(scene) | {"number": number, "kind": KINDS[number % len(KINDS)]}
        rows.append(row)
        if row.get("errors") == {}:
            print(
                f"{number:3} cost {row['costs'][1]:.1%} of the run; no parameter could be followed both ways",
                flush=True,
            )
        elif "errors" in row:
            name, worst = max(row["errors"].items(), key=lambda one: one[1])
            print(f"{number:3} cost {row['costs'][1]:.1%} of the run; worst {worst:.1e} ({name})", flush=True)
        else:
            print(f"{number:3} {row['why']}", flush=True)
    every = [error for row in rows for error in row.get("errors", {}).values()]
    print(f"{len(every)} derivatives, {np.mean(np.array(every) <= WANTED):.1%} right to {WANTED:g}")
    print("error, median / p95 / worst: " + " / ".join(f"{value:.1e}" for value in spread(every)))
    for k, what in enumerate(("slips alone", "slips and branches")):
        costs = spread([row["costs"][k] for row in rows if "costs" in row])
        print(f"cost of {what} over the run, median / p95 / worst: " + " / ".join(f"{value:.1%}" for value in costs))
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=2), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
