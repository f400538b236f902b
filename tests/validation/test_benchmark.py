"""The public benchmark of docs/benchmark.md: its numbers come from an explicit GFMD that shares only Scene."""

import json
from pathlib import Path

import numpy as np
import pytest

from solver import Scene, load_path
from solver.run.frame import slips_in

STORE = json.loads((Path(__file__).parents[2] / "docs" / "benchmark.json").read_text())["scenes"]


@pytest.mark.slow
@pytest.mark.parametrize("name", STORE)
def test_fast_gives_the_numbers_of_the_public_benchmark(name):
    """F and L of increments to 1e-9 of the largest of the run, U_x of slips to 1e-8, their F and L to 1e-6, A to 1e-6.

    F changes infinitely fast at the end of a branch. The least repulsion that counts in A differs. The largest of the
    run is the scale of slips too: L of the soft scene is close to zero there.
    """
    scene = Scene(**STORE[name]["input"])
    shear = [frame for frame in load_path(scene) if frame.stage == "shear"]
    states = np.array([(f.U_x, f.F, f.L, f.A_bar * scene.width) for f in shear])
    slips = [(e.load, e.F_bar * f.unit, e.L_bar * f.unit, e.A_bar * scene.width) for f in shear for e in slips_in(f)]
    gfmd = {part: np.array(rows) for part, rows in STORE[name]["gfmd"].items()}
    nearest = np.abs(states[:, :1] - gfmd["frames"][:, 0]).argmin(axis=0)
    parts = {
        "frames": (states[nearest], [1e-12, 1e-9, 1e-9, 1e-6]),
        "slips": (np.array(slips), [1e-8, 1e-6, 1e-6, 1e-6]),
    }
    largest = np.abs(np.array([row for rows in gfmd.values() for row in rows])).max(axis=0)
    for part, (ours, bounds) in parts.items():
        assert len(ours) == len(gfmd[part])
        if not len(ours):
            continue
        off = np.abs(ours - gfmd[part]).max(axis=0) / largest
        assert (off <= bounds).all(), (part, off)
