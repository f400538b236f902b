"""Measured curves and example data to be fitted, for workers."""

from typing import Any

import numpy as np

from solver import LIMITS, DataError, Scene
from solver.following.from_run import skeleton_of
from solver.measured.curves import read_measurement
from solver.measured.measurement import Measurement, Recording

POINTS, NOISE, APART = 400, 0.01, 1.2  # of example data: points, noise over the largest F, factor on phi


def measured(scene: Scene, content: bytes, **how: Any) -> Measurement | Recording:
    """Return the curve in a file; raises ValueError with the remedy of the page. how: as of `read_measurement`."""
    try:
        return read_measurement(scene, content, **how)
    except DataError as error:
        remedy = "; read it over the run of the experiment, where the page asks, and fit from there"
        raise ValueError(f"{error.brief}{remedy * bool(error.call)}") from None


def made_up_scene(scene: Scene, seed: int) -> Scene:
    """Return the Scene of example data: slightly different friction and depth."""
    change = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, 2)
    values = {"delta_bar": scene.delta_bar + 0.1 * change[1], "phi_ratio": scene.phi_ratio * APART ** change[0]}
    within = {name: float(np.clip(value, LIMITS[name].low, LIMITS[name].high)) for name, value in values.items()}
    return scene.changed(path="shear", **within)


def made_up_curve(scene: Scene, seed: int) -> Measurement:
    """Return a noisy Measurement of a scene. Raises NotConverged or NotFollowed."""
    U_x, unit = np.linspace(0.0, scene.u_x_max, POINTS + 1)[1:], scene.width * scene.E
    F_bar, L_bar, _ = skeleton_of(scene).curve(U_x)
    noise = NOISE * np.abs(F_bar).max() * np.random.default_rng(seed).normal(size=(2, POINTS))
    return Measurement.of(U_x, {"F_bar": F_bar + noise[0], "L_bar": L_bar + noise[1]}, unit=unit)
