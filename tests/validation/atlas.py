"""The scenes of the stability atlas: stiff and extreme values one at a time, and several at random.

Scenes are given in coordinates that show what is extreme: those of AXES, with delta_t = 1 nm and coarse increments, so
that a short run contains the approach, first slips and some sliding.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from solver.scene import LIMITS, Scene, SceneError

# name: values tried one at a time; the first and the last are the extremes. `spacing` is a/delta_t, `normal` is
# delta_n/delta_t, `step` is du over 0.1 (its default), for both du_z and du_x.
AXES = {
    "E": (1e-2, 0.1, 1.0, 10.0, 1e3, 1e4, 1e5, 1e6),
    "phi_ratio": (0.0, 0.01, 0.1, 10.0, 100.0),
    "delta_bar": (-1.0, -0.5, -0.15, 0.3, 1.0, 2.0, 3.0),
    "nu": (0.0, 0.25, 0.49, 0.499, 0.4999),
    "height": (0.01, 0.03, 0.1, 10.0, 100.0),
    "radius": (0.1, 0.3, 1.0, 25.0, 1000.0),
    "nodes": (8, 9, 13, 61, 127, 255, 509, 1024, 1021, 4099, 8192, 16381, 16384),
    "spacing": (0.3, 0.7, 1.0, 1.5, 5.0, 10.0),
    "normal": (0.1, 0.3, 3.0, 10.0),
    "step": (0.01, 0.1, 1.0, 10.0),
}
CENTRE = {
    "E": 70.0,
    "phi_ratio": 1.0,
    "delta_bar": 0.0,
    "nu": 0.45,
    "height": 1.0,
    "radius": 2.5,
    "nodes": 256,
    "spacing": 2.44,
    "normal": 1.0,
    "step": 5.0,
}
BASES: tuple[dict[str, Any], ...] = ({}, {"surface": "flat"}, {"nodes": 1024}, {"delta_bar": 0.3, "nodes": 255})
RANDOM = 1800  # with the axes one at a time, and those repeated at a tolerance in reach, some 2,200 scenes
QUICK = 11  # the quick atlas has every 11th scene: a prime, so that it meets every axis and base
COARSEST = LIMITS["tolerance"].high
SEED = 20190610  # any number; another one gives other random scenes
SHEAR = 40  # increments of the shear; at coarse increments some 8 lattice periods of the default
# Waves (`slope`: their steepest) and rough surfaces from hardly any to the steepest and longest
SHAPES = (
    {"surface": "flat"},
    {"surface": "wave", "amplitude": 1e-3, "waves": 1},
    {"surface": "wave", "amplitude": 1.0, "waves": 3},
    {"surface": "wave", "slope": 0.1, "waves": 7},
    {"surface": "wave", "slope": 0.3, "waves": 1},
    {"surface": "rough", "rms_slope": 1e-5, "cut_off": 0.1},
    {"surface": "rough", "cut_off": 0.2, "seed": 2},
    {"surface": "rough", "rms_slope": 0.1, "hurst": 0.0, "cut_off": 0.07, "seed": 3},
    {"surface": "rough", "rms_slope": 0.1, "hurst": 1.0, "roll_off": 1.0, "cut_off": 0.1, "seed": 999999},
)
LOADINGS = (
    {"path": "unload"},
    {"path": "loop"},
    {"hold": "load"},
    {"path": "loop", "hold": "load"},
    {"damping": 0.5},
    {"damping": 0.25, "path": "loop"},
    {"damping": 0.2},
    {"damping": 4.0, "hold": "load"},
)
# Ranges of the Scene that are not axes
OTHERS = (
    *({"tolerance": value} for value in (1e-12, 1e-3)),
    *({"window_t": value} for value in (4.0, 20.0)),
    *({"phi_n": value} for value in (1e-3, 1e3)),
    *({"scale": value} for value in (1e-2, 1e2)),
    {"delta_bar": 30.0, "step": 10.0},
)
CELLS = tuple({"nodes": nodes} for nodes in (61, 97, 127))  # small, so that all modes of their frames are computed
VARIANTS = SHAPES, LOADINGS, OTHERS, CELLS


@dataclass(frozen=True)
class Case:
    """One entry: its number and Scene fields as a dict."""

    number: int
    probed: tuple  # names of the extreme parameters
    values: dict

    def scene(self) -> Scene:
        """The Scene; raises SceneError where it is rejected."""
        return Scene(**self.values)

    @property
    def line(self) -> str:
        """The options with which `python -m solver run` computes it."""
        defaults = {f.name: f.default for f in fields(Scene)}
        changed = (f"{name}={value}" for name, value in self.values.items() if value != defaults[name])
        return "--set " + " ".join(changed)


def scene_fields(surface: str = "circular", scale: float = 1.0, **point) -> dict:
    """Scene fields of a point: coordinates of AXES (CENTRE where not given), `scale` = delta_t in nm, Scene fields."""
    at = CENTRE | {name: point.pop(name) for name in list(point) if name in CENTRE}
    du = 0.1 * at["step"]
    values = {
        "surface": surface,
        "delta_t": scale,
        "delta_n": at["normal"] * scale,
        "width": at["nodes"] * at["spacing"] * scale,
        "du_z": du,
        "du_x": du,
        "u_x_max": SHEAR * du * scale,
    }
    plain = {name: at[name] for name in ("E", "phi_ratio", "delta_bar", "nu", "height", "radius", "nodes")}
    return plain | values | point


def cases(quick: bool = False) -> list[Case]:
    """Every Case of the atlas, or every QUICK-th of them, the same ones each time."""
    points = [
        *(((name,), base | {name: v}) for base in BASES for name, values in AXES.items() for v in values),
        *((tuple(variant), variant) for variants in VARIANTS for variant in variants),
        *map(_random, range(RANDOM)),
    ]
    listed = [(probed, scene_fields(**_steep(point))) for probed, point in points]
    listed += [*_remedied(listed)]
    return [Case(k, *each) for k, each in enumerate(listed[:: QUICK if quick else 1])]


def _random(number):
    """(names, point) of a random scene: few coordinates away from the centre, or most, and some of the VARIANTS."""
    random = np.random.default_rng((SEED, number))
    share, point = random.uniform(0.0, 0.8), {}  # beyond, most scenes are refused for their combination
    for variants in VARIANTS:
        if random.random() < 1.0 / 3.0:
            point |= variants[random.integers(len(variants))]
    point = {name: _drawn(random, name) for name in AXES if random.random() < share} | point
    return tuple(point), point


def _drawn(random, name):
    """A value of an axis: one of its extremes, or half the time any between, on a log scale if all are positive."""
    low, high = AXES[name][0], AXES[name][-1]
    if random.random() < 0.5:
        return (low, high)[random.integers(2)]
    value = np.exp(random.uniform(np.log(low), np.log(high))) if low > 0 else random.uniform(low, high)
    return round(value) if name == "nodes" else float(f"{value:.4g}")


def _remedied(points):
    """Scenes with a tolerance below the round-off of their soft layer, with the tolerance that the message names."""
    for probed, values in points:
        try:
            least = Scene(**values | {"tolerance": COARSEST}).attainable
        except SceneError:  # rejected for another reason
            continue
        if least > values.get("tolerance", Scene.tolerance):
            yield (*probed, "tolerance"), values | {"tolerance": min(float(f"{1.1 * least:.2g}"), COARSEST)}


def _steep(point):
    """The point with the amplitude of a wave whose steepest `slope` is given: a little less, as 0.3 is the largest."""
    if "slope" not in point:
        return point
    nodes, spacing = (point.get(name, CENTRE[name]) for name in ("nodes", "spacing"))
    wavelength = nodes * spacing * point.get("scale", 1.0) / point["waves"]
    amplitude = float(f"{0.999 * point['slope'] * wavelength / (2.0 * np.pi):.4g}")
    return {name: value for name, value in point.items() if name != "slope"} | {"amplitude": amplitude}
