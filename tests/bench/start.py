"""How long the first run of an installation takes, and of a process: with and without kept machine code.

    python tests/bench/start.py [--other CHECKOUT] [--repeats N] [--json FILE]

A process imports the solver and runs a small scene with a slip, with an empty folder for Numba's machine code (cold),
then again with what the first one left there (warm). It prints medians of the processor time, s, the compiled
functions of the solver and, of another checkout run in turn, the ratios. A cold start needs a minute of patience.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from scenes import options, write

HERE = Path(__file__).resolve().parents[2]
START = """
import json, time
from numba.core.event import Listener, install_listener
from solver import Scene, simulate

class Compiled(Listener):
    found = []
    def on_start(self, event): pass
    def on_end(self, event): self.found.append(event.data["dispatcher"].py_func.__module__)

with install_listener("numba:compile", Compiled()):
    simulate(Scene(nodes=128, width=312.5, radius=20.0, u_x_max=16.0))
print(json.dumps([time.process_time(), sum(name.startswith("solver.") for name in Compiled.found)]))
"""


def started(checkout):
    """((processor time, s; compilations) of a cold start, and of a warm one) in a checkout."""
    with tempfile.TemporaryDirectory() as folder:
        environment = os.environ | {"PYTHONPATH": str(checkout), "NUMBA_CACHE_DIR": folder}
        command = [sys.executable, "-c", START]
        ran = (subprocess.run(command, cwd=checkout, env=environment, capture_output=True, check=True) for _ in "12")
        return tuple(json.loads(one.stdout) for one in ran)


def row_of(checkouts, repeats):
    """For each checkout: medians of the cold and the warm start, s, and the compiled functions of the cold one."""
    starts = [[started(checkout) for checkout in checkouts] for _ in range(repeats)]
    for k in range(len(checkouts)):
        cold, warm = (median(start[k][which][0] for start in starts) for which in (0, 1))
        yield {"cold": cold, "warm": warm, "compiled": starts[0][k][0][1], "again": starts[0][k][1][1]}


def main():
    parser = options(__doc__)
    parser.add_argument("--other", type=Path, help="another checkout of this repository")
    parser.add_argument("--repeats", type=int, default=3, help="starts of each kind (default: %(default)s)")
    arguments = parser.parse_args()
    other = [arguments.other.resolve()] if arguments.other else []
    rows = [*row_of([HERE, *other], arguments.repeats)]
    for row in rows:
        cold, warm, counts = row["cold"], row["warm"], (row["compiled"], row["again"])
        print(f"cold start {cold:.1f} s, {counts[0]} functions compiled; warm start {warm:.2f} s, {counts[1]} compiled")
    if other:
        mine, others = rows
        print(f"over the other: cold {mine['cold'] / others['cold']:.2f}, warm {mine['warm'] / others['warm']:.2f}")
    write(arguments.json, rows)
    return 0


if __name__ == "__main__":
    sys.exit(main())
