"""Whether a measured curve can be that of a scene: signs, origins and units that a fit would try in vain."""

from math import exp

import numpy as np

from ..scene import Scene
from ..tables import DataError
from .measurement import Measurement

PEAK = (2.0 / exp(1.0)) ** 0.5  # of one spring's shear traction over phi_t/delta_t
FAR = 1e3  # factor between a measured force and that of the interface beyond which its unit is wrong


def check_plausible(scene: Scene, measured: Measurement) -> None:
    """Raises DataError, with the remedy, for a sign, an origin or a unit that no parameters explain.

    The largest friction of an interface is compared: phi_t/delta_t over the whole width, N/m, times PEAK.
    """
    U_x, F = measured.U_x, measured.values["F_bar"]
    if (F < 0.0).mean() > 0.95:
        raise DataError(f"F is negative at {(F < 0.0).sum()} of {F.size} points; turn its sign: F = -F")
    start, span = float(U_x[0]), float(np.ptp(U_x))
    if abs(start) > max(span, 10.0 * scene.spacing):
        reason = f"U_x begins at {start:.6g} nm and spans {span:.4g} nm, and a run begins at 0"
        raise DataError(f"{reason}; subtract {start:.6g} nm from U_x")
    most = PEAK * scene.phi_t / scene.delta_t * scene.width
    largest = float(np.abs(F).max()) * (measured.unit or scene.width * scene.E)
    if most and not most / FAR**2 < largest < most * FAR:
        reason = f"F reaches {largest:.3g} N/m; an interface as that of the scene resists with {most:.3g} N/m at most"
        raise DataError(f"{reason}; check the unit of F, which is a force over the width across the pull")
