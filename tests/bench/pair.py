"""Processor time and force evaluations of scenes in this checkout over those in another one.

    git worktree add /tmp/other COMMIT
    python tests/bench/pair.py /tmp/other [--only NAME ...] [--repeats N] [--json FILE]

Each run has a process of its own, in this checkout and in the other in turn, after a small run that loads the kernels.
It prints medians of the processor time of `simulate`, s, and of the force evaluations, and this checkout's over the
other's. A run that ends early counts up to its end and is marked so. Scenes outside the sliders (`soft`, `adhesive`,
`tiny`) run if named.
"""

import json
import os
import subprocess
import sys
from pathlib import Path
from statistics import median

from scenes import options, write

HERE = Path(__file__).resolve().parents[2]
SCENES = {  # name: (parameters, options of `simulate`)
    "default": ({}, {}),
    "depth 1": ({"delta_bar": 1.0}, {}),
    "ratio 2": ({"phi_ratio": 2.0}, {}),
    "weak": ({"phi_ratio": 0.02}, {}),
    "rough": ({"surface": "rough"}, {}),
    "held": ({"hold": "load"}, {}),
    "load": ({}, {"load": 10.0}),
    "deep": ({"E": 10.0, "delta_bar": 0.6, "phi_ratio": 1.0}, {}),
}
EXTREME = {
    "soft": ({"E": 0.5, "delta_bar": 0.9, "u_x_max": 3.0}, {}),
    "adhesive": ({"E": 5.0, "phi_n": 20.0, "delta_bar": 0.5, "u_x_max": 3.0}, {}),
    "tiny": ({"nodes": 64, "width": 160.0, "radius": 0.3, "u_x_max": 2.0}, {}),
}
RUN = """
import json, sys, time
from solver import Scene, simulate
values, options = json.loads(sys.argv[1])
simulate(Scene(**{"nodes": 256, "width": 640.0} | values | {"u_x_max": 1.0}))
start = time.process_time()
result = simulate(Scene(**values), **options)
seconds = time.process_time() - start
print(json.dumps([seconds, sum(frame.evaluations for frame in result.frames), result.failure or ""]))
"""


def ran(checkout, scene):
    """(processor time, s; force evaluations; failure) of a scene in a checkout."""
    command = [sys.executable, "-c", RUN, json.dumps(scene)]
    environment = os.environ | {"PYTHONPATH": str(checkout)}
    ended = subprocess.run(command, cwd=checkout, env=environment, capture_output=True, text=True)
    if ended.returncode:
        raise RuntimeError(f"{checkout}: {ended.stderr.strip().splitlines()[-1]}")
    return json.loads(ended.stdout.splitlines()[-1])


def row_of(name, scene, other, repeats):
    """A scene in numbers: medians in this checkout and in the other."""
    runs = [(ran(HERE, scene), ran(other, scene)) for _ in range(repeats)]
    row = {"scene": name, "ended early": [bool(run[2]) for run in runs[0]]}
    for k, what in enumerate(("seconds", "evaluations")):
        mine, others = (median(pair[side][k] for pair in runs) for side in (0, 1))
        row[what] = [mine, others, mine / others]
    return row


def main():
    parser = options(__doc__)
    parser.add_argument("other", type=Path, help="another checkout of this repository")
    parser.add_argument("--only", nargs="+", choices=[*SCENES, *EXTREME], default=list(SCENES), metavar="NAME")
    parser.add_argument("--repeats", type=int, default=5, help="runs of each scene (default: %(default)s)")
    arguments, rows = parser.parse_args(), []
    print(f"{'scene':10}{'time, s':>10}{'other':>10}{'ratio':>8}{'evaluations':>13}{'other':>10}{'ratio':>8}")
    for name in arguments.only:
        row = row_of(name, (SCENES | EXTREME)[name], arguments.other.resolve(), arguments.repeats)
        rows.append(row)
        (mine, others, ratio), counts = row["seconds"], row["evaluations"]
        figures = f"{mine:10.2f}{others:10.2f}{ratio:8.2f}{counts[0]:13.0f}{counts[1]:10.0f}{counts[2]:8.2f}"
        early = "  ended early: {}, {}".format(*row["ended early"]) if any(row["ended early"]) else ""
        print(f"{name:10}{figures}{early}", flush=True)
    write(arguments.json, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
