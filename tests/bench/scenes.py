"""Random scenes that the benches share, and the small things that every bench does: runs, caches, options.

Scenes are plain dicts of parameters, so that they print and serve as keys of a cache; `scene_of` builds the Scene. The
word `profile` stands for the seed of a measured profile. Every generator is seeded: scene k is the same in every run.
"""

import argparse
import json
import sys
import time
from pathlib import Path

import numpy as np

from solver import NotConverged, Scene, load_path, read_profile
from solver.run.frame import slips_in

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "shared"))  # of plain_gfmd

BOX = {"E": (10.0, 1000.0), "delta_bar": (-0.6, 1.0), "phi_ratio": (0.02, 2.0)}  # the app's sliders
# The motion took this slip two sites on, the paper's takes it one.
ROUGH_2575 = {
    "surface": "rough", "seed": 2575, "nodes": 128, "width": 264.115397683123, "E": 173.3318586095888, "nu": 0.33,
    "height": 2.7601823210574468, "phi_n": 0.8799312253531433, "phi_ratio": 0.8548195534479851,
    "delta_bar": 0.0351084354227964, "rms_slope": 0.00526988312518478, "hurst": 0.5026754983498698, "cut_off": 0.2,
}  # fmt: skip


HELD_TENSION = {  # under this load sensitivities described another slip
    "hold": "load", "E": 856.01968, "phi_ratio": 0.40262, "delta_bar": -0.2989, "u_x_max": 14.0,
}  # fmt: skip


def geometric(rng, low, high):
    """A random number, its logarithm evenly distributed."""
    return float(f"{np.exp(rng.uniform(np.log(low), np.log(high))):.5g}")


def even(rng, low, high):
    """A random number, evenly distributed."""
    return float(f"{rng.uniform(low, high):.5g}")


def cells(count, seed=30):
    """Parameters of small cells: rough, wavy, flat and measured surfaces in turn; the first is ROUGH_2575.

    Versions of the solver were tuned on those of seed 30; another seed tests them on scenes they have not seen.
    """
    yield from [ROUGH_2575][:count]
    for k in range(1, count):
        rng = np.random.default_rng((seed, k))
        kind = ("rough", "wave", "rough", "measured", "flat")[k % 5]
        nodes = int(rng.integers(64, 193))
        values = {
            "surface": kind,
            "nodes": nodes,
            "width": nodes * even(rng, 1.7, 2.8),
            "E": geometric(rng, 10.0, 1000.0),
            "nu": float(rng.choice([0.0, 0.33, 0.45, 0.49])),
            "height": geometric(rng, 0.3, 5.0),
            "phi_n": geometric(rng, 0.5, 4.0),
            "phi_ratio": geometric(rng, 0.1, 2.0),
            "delta_bar": even(rng, -0.3, 1.0),
        }
        rng.integers(4)  # a draw of no use: without it the scenes that follow would be others than those measured
        values["damping"] = float(rng.choice([1.0, 1.0, 1.0, 1.05, 2.0]))
        if kind == "rough":
            values |= {"seed": int(rng.integers(1, 10_000)), "rms_slope": geometric(rng, 2e-3, 0.02)}
            values |= {"hurst": even(rng, 0.3, 1.0), "cut_off": float(rng.choice([0.1, 0.2]))}
        if kind == "wave":
            waves, amplitude = int(rng.integers(1, 5)), geometric(rng, 0.3, 5.0)
            steepest = 0.2999 * values["width"] / (2.0 * np.pi * waves)  # nm; Scene allows slopes up to 0.3
            values |= {"waves": waves, "amplitude": min(amplitude, steepest)}
        if kind == "measured":
            values |= {"profile": int(rng.integers(1, 10_000))}
        yield values


def soft_punches(count):
    """Parameters of soft punches with strong friction: 512 nodes of the default spacing, pulled to 40 nm."""
    for k in range(count):
        rng = np.random.default_rng((31, k))
        own = {"E": even(rng, 11.0, 14.0), "phi_ratio": even(rng, 1.2, 2.0), "delta_bar": even(rng, -0.2, 0.8)}
        yield {"nodes": 512, "width": 1250.0, "radius": 5.0, "u_x_max": 40.0} | own


def extremes(count):
    """Parameters of `count` scenes outside the sliders: very soft layers and strong adhesion in turn."""
    rng = np.random.default_rng(77)
    for k in range(count):
        soft = k % 2 == 0
        own = {"E": geometric(rng, *((0.2, 1.0) if soft else (3.0, 8.0)))}
        own |= {} if soft else {"phi_n": even(rng, 10.0, 20.0)}
        own |= {"delta_bar": even(rng, *BOX["delta_bar"]), "phi_ratio": geometric(rng, *BOX["phi_ratio"])}
        yield own | {"u_x_max": 10.0}


def slider_box(count, seed=20, **others):
    """Parameters of `count` scenes of the app's sliders: E and phi_ratio even in their logarithms, delta_bar even."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        log_E = rng.uniform(*np.log(BOX["E"]))
        own = {"E": float(np.exp(log_E)), "delta_bar": float(rng.uniform(*BOX["delta_bar"]))}
        yield own | {"phi_ratio": float(np.exp(rng.uniform(*np.log(BOX["phi_ratio"]))))} | others


def held_box(count):
    """Parameters of `count` scenes under a held load, a third of them in tension; the first is HELD_TENSION."""
    rng = np.random.default_rng(35)
    yield from [HELD_TENSION][:count]
    for values in slider_box(count - 1, 36, hold="load", u_x_max=16.0):
        yield values | {"delta_bar": even(rng, -0.4, 0.8)}


def profile_of(seed, width):
    """A Profile of 240 points over `width` nm: eight random cosines, root mean square slope 0.002 to 0.02."""
    rng, k = np.random.default_rng((33, seed)), np.arange(1, 9)
    x = np.linspace(0.0, width, 241)
    z = (k**-1.3 * np.cos(2.0 * np.pi * np.outer(x / width, k) + rng.uniform(0.0, 2.0 * np.pi, k.size))).sum(axis=1)
    z *= geometric(rng, 2e-3, 0.02) / np.sqrt(np.mean(np.gradient(z, x) ** 2))
    rows = "\n".join(f"{a!r}, {b!r}" for a, b in zip(x.tolist(), z.tolist(), strict=True))
    return read_profile(rows, unit="nm")


def scene_of(values, **others):
    """The Scene of such parameters; raises SceneError."""
    values = values | others
    if "profile" in values:
        profile = profile_of(values.pop("profile"), values["width"])
        values |= {"measured": profile, "width": profile.length}
    return Scene(**values)


def ran(scene, limit=120.0, until=lambda frame: False):
    """(frames, seconds, failure) of a run, up to the first frame of which `until` is true; limit: processor time, s."""
    frames, start, failure = [], time.process_time(), None
    try:
        for frame in load_path(scene):
            frames.append(frame)
            if until(frame):
                break
            if time.process_time() > start + limit:
                failure = f"not done in {limit:g} s"
                break
    except NotConverged as given_up:
        failure = str(given_up)
    return frames, time.process_time() - start, failure


def sheared(frames):
    """The SlipEvents in shear, in order; the jump where a held load takes over is none."""
    return [e for frame in frames if frame.stage == "shear" for e in slips_in(frame)]


class Cache:
    """A JSON file of results by their parameters; None: kept in memory only."""

    def __init__(self, path):
        self.path = Path(path) if path else None
        self.rows = json.loads(self.path.read_text(encoding="utf-8")) if self.path and self.path.exists() else {}

    def get(self, values, compute):
        """The row of these parameters, computed and written if it is not there."""
        key = json.dumps(values)
        if key not in self.rows:
            self.rows[key] = compute(values)
            if self.path:
                self.path.write_text(json.dumps(self.rows), encoding="utf-8")
        return self.rows[key]


def spread(values):
    """(median, 95 in 100, worst)."""
    return [float(value) for value in np.percentile(values, [50, 95, 100])] if len(values) else [np.nan] * 3


def options(doc):
    """A parser of the command line with the options that every bench has."""
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", metavar="FILE", help="write every row here")
    return parser


def numbered(doc, scenes):
    """The same for benches of numbered scenes; scenes: default of --scenes."""
    parser = options(doc)
    parser.add_argument("--scenes", metavar="N", type=int, default=scenes, help="how many (default: %(default)s)")
    parser.add_argument("--from", metavar="K", type=int, default=0, dest="first", help="skip the first K scenes")
    return parser


def write(path, rows):
    """Write rows as JSON, if there is a path."""
    if path:
        Path(path).write_text(json.dumps(rows, indent=2), encoding="utf-8")
