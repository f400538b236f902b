"""The toughness of an interface, for workers."""

import numpy as np

from solver import Scene
from solver.analysis.toughness import toughness


def relative_toughness(law: str, ratio: float, delta_t: float, angles: tuple[float, ...]) -> list[float]:
    """Return the toughness of an interface over phi_n at mode angles, degrees.

    ratio: phi_t over phi_n; delta_t: over delta_n. Raises ValueError where there is no toughness.
    """
    scene = Scene(law=law, phi_n=1.0, phi_ratio=ratio, delta_t=delta_t, nodes=64, width=64.0 * delta_t)
    return toughness(scene, np.radians(angles)).tolist()
