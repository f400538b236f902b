"""Cost of the paper's figures: the 27 runs of Fig. 8 up to the onset of sliding, and Figs. 4 and 5 in closed form.

    python tests/bench/figures.py [--processes N] [--repetitions N]

Runs Fig. 8 in N processes (default 2), which are started, compiled and warm, and, if N > 1, in this process. Prints the
cost of each run and the median of the repetitions (default 5). The friction curve has 120 moduli.
"""

import argparse
import multiprocessing
import statistics
import time

import numpy as np

from solver import Scene
from solver.analysis.area_laws import threshold_law
from solver.analysis.friction_laws import INDENTATIONS, INTERFACES, friction, onset
from solver.presets import preset

REPETITIONS = 5


def run(task):
    """(interface, delta_bar, Onset, seconds) of one run, in whatever process."""
    name, scene = task
    start = time.perf_counter()
    found = onset(scene)
    return name, scene.delta_bar, found, time.perf_counter() - start


def warm(barrier=None):
    """Compile and plan what the runs need; then wait for the other processes."""
    onset(Scene(u_x_max=0.0))
    if barrier is not None:
        barrier.wait()


def clocked(function):
    start = time.perf_counter()
    result = function()
    return result, time.perf_counter() - start


def repeated(function, times):
    """(last result, seconds of every repetition)."""
    results = [clocked(function) for _ in range(times)]
    return results[-1][0], [seconds for _, seconds in results]


def in_processes(tasks, processes, times):
    """(results, seconds of every repetition) of a pool whose processes are all warm."""
    context = multiprocessing.get_context("spawn")
    barrier = context.Barrier(processes + 1)
    with context.Pool(processes, warm, (barrier,)) as pool:
        barrier.wait()
        return repeated(lambda: pool.map(run, tasks, chunksize=1), times)


def flat(times, count=120):
    """Seconds of the mean friction over `count` moduli."""
    scene = Scene(surface="flat", phi_ratio=0.1)
    moduli = np.geomspace(20.0, 20_000.0, count)
    return statistics.median(repeated(lambda: [friction(scene.changed(E=E)).mean for E in moduli], times)[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--processes", type=int, default=2, metavar="N")
    parser.add_argument("--repetitions", type=int, default=REPETITIONS, metavar="N")
    arguments = parser.parse_args()
    depths = sorted(INDENTATIONS, reverse=True)  # the longest runs first
    tasks = [(name, preset(name).scene.changed(delta_bar=depth)) for depth in depths for name in INTERFACES]
    results, seconds = in_processes(tasks, arguments.processes, arguments.repetitions)
    for name in INTERFACES:
        runs = [(d, found, s) for n, d, found, s in results if n == name]
        law = threshold_law([found.A_s for _, found, _ in runs], [found.F_s for _, found, _ in runs])
        print(f"{name:10}  tau_c {law.tau_c:.3e}  F_s,nc {law.F_nc:.3e}  R^2 {law.r2:.4f}", end="")
        print(f"   ms per run {1e3 * min(s for *_, s in runs):.0f} .. {1e3 * max(s for *_, s in runs):.0f}")
    spread = f"{min(seconds):.2f} .. {max(seconds):.2f}"
    print(
        f"Fig. 8, {len(tasks)} runs in {arguments.processes} processes: {statistics.median(seconds):.2f} s ({spread})"
    )
    if arguments.processes > 1:
        warm()
        alone = repeated(lambda: [run(task) for task in tasks], arguments.repetitions)[1]
        print(f"Fig. 8 in one process: {statistics.median(alone):.2f} s")
    print(f"Fig. 5, 120 moduli: {1e3 * flat(arguments.repetitions):.0f} ms")


if __name__ == "__main__":
    main()
