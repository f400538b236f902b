"""What a worker does after a slider has come to rest, over what it did in another checkout.

    git worktree add /tmp/other COMMIT
    python tests/bench/rested.py /tmp/other [--only NAME ...] [--repeats N] [--json FILE]

This checkout checks the prediction of a move and packs it; the other one computes the exact run in slices, and packs
its frames. Both run in turn, each in a process of its own, after the same for another move, which loads the kernels.
It prints medians of the processor time, ms, their ratio, the force evaluations and the bytes for the browser. "known":
the worker has certified a scene of another depth before. A prediction that is refused counts with its exact run.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median

from scenes import options, write

HERE = Path(__file__).resolve().parents[2]
MOVES = {  # name: (parameters of the run before, of the move)
    "depth +0.05": ({}, {"delta_bar": 0.05}),
    "E 70 -> 60": ({}, {"E": 60.0}),
    "ratio 1 -> 1.2": ({}, {"phi_ratio": 1.2}),
    "depth 1 -> 0.9": ({"delta_bar": 1.0}, {"delta_bar": 0.9}),
    "ratio 2 -> 1.8": ({"phi_ratio": 2.0}, {"phi_ratio": 1.8}),
    "known": ({}, {"delta_bar": 0.05}),
    "rough": ({"surface": "rough", "E": 70.0}, {"E": 75.0}),
}
COMPUTED = """
import json, sys, time
from app.service import worker
from solver import Scene
values, move, known = json.loads(sys.argv[1])
def visit(scene):
    begun, state, parts = time.process_time(), None, []
    while True:
        part = worker.compute(scene, state)
        parts.append(getattr(part, "made", part))
        if not hasattr(part, "state"):
            return time.process_time() - begun, parts
        state = part.state
visit(Scene(E=90.0))
seconds, parts = visit(Scene(**values | move))
sizes = sum(len(block) for part in parts for block in part.blocks)
print(json.dumps([seconds, sum(part.evaluations for part in parts), sizes, ""]))
"""
CHECKED = """
import json, sys, time
from app.service import worker
from app.service.skeletons import certified
from solver import Scene, follow, skeleton_of
values, move, known = json.loads(sys.argv[1])
before = skeleton_of(Scene(**values))
certified(Scene(E=90.0), follow(skeleton_of(Scene()), Scene(E=90.0)))
if known:
    nearer = before.scene.changed(delta_bar=before.scene.delta_bar + 0.02)
    certified(nearer, follow(before, nearer))
scene = Scene(**values | move)
skeleton = follow(before, scene)
begun = time.process_time()
made = certified(scene, skeleton)
seconds, evaluations, sizes = time.process_time() - begun, made.about.evaluations, len(made.body)
if made.failure:
    begun, state = time.process_time(), None
    while True:
        part = worker.compute(scene, state)
        evaluations += getattr(part, "made", part).evaluations
        if not hasattr(part, "state"):
            break
        state = part.state
    seconds += time.process_time() - begun
print(json.dumps([seconds, evaluations, sizes, made.failure]))
"""


def ran(checkout, script, move):
    """[processor time, s; force evaluations; bytes; what was found] of a move in a checkout."""
    environment = os.environ | {"PYTHONPATH": str(checkout)}
    command = [sys.executable, "-c", script, json.dumps(move)]
    ended = subprocess.run(command, cwd=checkout, env=environment, capture_output=True, text=True)
    if ended.returncode:
        raise RuntimeError(f"{checkout}: {ended.stderr.strip().splitlines()[-1]}")
    return json.loads(ended.stdout.splitlines()[-1])


def main():
    parser = options(__doc__)
    parser.add_argument("other", type=Path, help="another checkout of this repository")
    parser.add_argument("--only", nargs="+", choices=list(MOVES), default=list(MOVES), metavar="NAME")
    parser.add_argument("--repeats", type=int, default=5, help="runs of each move (default: %(default)s)")
    arguments, rows = parser.parse_args(), []
    other = arguments.other.resolve()
    print(f"{'move':16}{'ms':>8}{'other':>8}{'ratio':>7}{'evaluations':>13}{'other':>8}{'bytes':>9}{'other':>9}")
    for name in arguments.only:
        move = *MOVES[name], name == "known"
        pairs = [(ran(HERE, CHECKED, move), ran(other, COMPUTED, move)) for _ in range(arguments.repeats)]
        mine, others = ([median(pair[side][k] for pair in pairs) for k in range(3)] for side in (0, 1))
        found = pairs[0][0][3]
        rows.append({"move": name, "mine": mine, "other": others, "ratio": mine[0] / others[0], "found": found})
        times = f"{1e3 * mine[0]:8.0f}{1e3 * others[0]:8.0f}{mine[0] / others[0]:7.2f}"
        print(f"{name:16}{times}{mine[1]:13.0f}{others[1]:8.0f}{mine[2]:9.0f}{others[2]:9.0f}  {found}", flush=True)
    write(arguments.json, rows)


if __name__ == "__main__":
    main()
