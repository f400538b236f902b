"""How long a picture of the stress inside takes: median and worst of its runs, once compiled, one thread.

Run `python tests/bench/picture.py [--runs N] [--size COLUMNS ROWS]`.
"""

import argparse
import os
import statistics
from time import perf_counter

import numpy as np

from solver import Scene, load_path
from solver.analysis.raster import QUANTITIES, mesh, picture

HALF, DEPTH = 250.0, 250.0  # nm


def cases():
    """(name, scene, first, traction, window): the default contact under shear, and the most nodes allowed."""
    scene = Scene(delta_bar=0.2, u_x_max=5.0)
    frame = list(load_path(scene))[-1]
    middle = scene.width / 2.0
    window = middle - HALF, middle + HALF, DEPTH
    yield "default scene, 1024 nodes", scene, frame.first, frame.T, window
    traction = np.random.default_rng(0).normal(size=(2, 600))
    for width, half, depth in ((40000.0, HALF, DEPTH), (2500.0, HALF, DEPTH), (40000.0, 10.0, 10.0)):
        scene, middle = Scene(nodes=16384, width=width), width / 2.0
        window = middle - half, middle + half, depth
        yield f"16384 nodes, w = {width:g} nm, {depth:g} nm deep", scene, 8192 - 300, traction, window


def timed(runs, call):
    """Milliseconds of each run, after one that compiles."""
    call()
    times = []
    for _ in range(runs):
        start = perf_counter()
        call()
        times.append(1e3 * (perf_counter() - start))
    return times


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=30)
    parser.add_argument("--size", type=int, nargs=2, default=(400, 150), metavar=("COLUMNS", "ROWS"))
    options = parser.parse_args()
    load = " ".join(f"{part:.1f}" for part in os.getloadavg())
    print(f"{options.size[0]} x {options.size[1]} points; load of this machine {load}, {os.cpu_count()} cores")
    for name, scene, first, traction, window in cases():
        print(name)
        calls = {
            q: (lambda q=q, c=(scene, first, traction), w=window: picture(*c, q, w, options.size)) for q in QUANTITIES
        }
        calls["mesh"] = lambda c=(scene, first, traction), w=window: mesh(*c, (0.0, 0.0), w)
        for what, call in calls.items():
            times = timed(options.runs, call)
            print(f"  {what:10s} median {statistics.median(times):6.2f} ms   worst {max(times):6.2f} ms")


if __name__ == "__main__":
    main()
