"""Parameters from a measurement: bounded least squares with exact derivatives over followed runs.

A slip cuts the curve at a place that moves with the parameters. So a point is compared with the branch on which it was
measured, and the place of each slip is a datum of its own: it lies somewhere between the points on both sides.
Source of the method: Branch, Coleman & Li 1999, doi:10.1137/S1064827595289108 (scipy's "trf").
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..continuation.state import NotConverged
from ..following.branch import NotFollowed
from ..scene import Scene, SceneError
from .measurement import Measurement
from .outputs import NAMES
from .partial import continuous
from .trial import AXES, Model

APART = 0.99  # correlation beyond which two parameters cannot be told apart
VAGUE = 0.5  # standard error over value, beyond which the data do not determine a parameter
UNLIKELY = 5.0  # standard deviations of chi^2 above what noise makes, beyond which the curve does not fit
STEPS = 30  # runs from one start, at most; a cap against wandering
FLAT = 1e-12  # of the normal matrix scaled to a unit diagonal: curvature that round-off leaves where there is none


@dataclass(frozen=True)
class Fit:
    """Values and standard errors in the units of Scene (offset_U nm, offset_F as F_bar), correlations (n, n).

    chi2: per degree of freedom; reached: whether the curve fits within its noise; runs: followed. rows: (U_x, quantity,
    measured, model) of every point; residuals (k,): over their noise, those of slips last.
    """

    values: dict[str, float]
    errors: dict[str, float]
    correlations: NDArray[np.float64]
    chi2: float
    reached: bool
    runs: int
    warnings: tuple[str, ...]
    rows: list[tuple[float, str, float, float]]
    residuals: NDArray[np.float64]

    def as_dict(self) -> dict[str, object]:
        """By plain names, as JSON has it."""
        numbers = {"values": self.values, "errors": self.errors, "correlations": self.correlations.tolist()}
        found = {"chi2": self.chi2, "reached": self.reached, "runs": self.runs, "warnings": list(self.warnings)}
        return numbers | found | {"residuals": self.residuals.tolist()}


def fit(scene: Scene, measured: Measurement, free: Sequence[str], starts: int = 3) -> Fit:
    """The Fit of the parameters `free` (continuous ones of the scene, or AXES); others are those of the scene.

    The first start is the scene itself; others, at random within APART_BY of it, follow while none fits. Raises
    ValueError for names that cannot be free, NotFollowed where no start has a run that is followed.
    """
    allowed = (*continuous(scene), *AXES)
    for name in free:
        if name not in allowed or list(free).count(name) > 1:
            raise ValueError(f"--free {name}: allowed, once each: {', '.join(allowed)}")
    longest = max(float(measured.U_x[-1]), scene.u_x_max)
    model = Model(scene.changed(u_x_max=longest, path="shear"), measured, tuple(free))
    best, failure, rng = None, None, np.random.default_rng(1)
    for number in range(max(1, starts)):
        try:
            found = _from(model, model.start(rng if number else None))
        except (NotFollowed, NotConverged, SceneError) as error:
            failure = failure or error
            continue
        if best is None or found.cost < best.cost:
            best = found
        if _fits(best):
            break
    if best is None:
        raise failure
    return _told(model, best)


def _from(model, x):
    """scipy's result from a start, with the runs of the model."""
    model.at = model.last = None
    return least_squares(
        model.residuals, x, model.jacobian, model.bounds(), x_scale=model.sizes(), max_nfev=STEPS, xtol=1e-7, ftol=1e-8
    )


def _fits(found):
    """Whether chi^2 is what noise makes."""
    freedom = max(1, found.fun.size - found.x.size)
    return 2.0 * found.cost / freedom < 1.0 + UNLIKELY * (2.0 / freedom) ** 0.5


def _told(model, found):
    """The Fit of scipy's result."""
    n, free = found.x.size, model.free
    chi2 = 2.0 * found.cost / max(1, found.fun.size - n)
    size = np.maximum(np.linalg.norm(found.jac, axis=0), 1e-300)
    least, ways = np.linalg.eigh((found.jac / size).T @ (found.jac / size))
    covariance = (ways / np.maximum(least, FLAT)) @ ways.T / np.outer(size, size)
    deviation = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
        correlations = covariance / np.outer(deviation, deviation)
    reached = _fits(found)
    errors = deviation * (1.0 if reached else chi2**0.5)
    values = dict(zip(free, map(float, found.x), strict=True))
    measured, k = model.measured, int(model.kept.sum())
    rows, names = [], [name for name in NAMES if name in measured.values]
    for i, name in enumerate(names):
        y = measured.values[name][model.kept]
        curve = y + found.fun[i * k : (i + 1) * k] * measured.noise[name]
        rows += zip(measured.U_x[model.kept].tolist(), [name] * k, y.tolist(), curve.tolist(), strict=True)
    said = _warnings(free, found.x, errors, correlations, size, model.bounds())
    if not reached:
        said.insert(0, f"no start led to a curve that fits: chi^2 is {chi2:.3g} per degree of freedom; start nearer")
    named = dict(zip(free, map(float, errors), strict=True))
    return Fit(values, named, correlations, chi2, reached, model.runs, tuple(said), rows, found.fun)


def _warnings(free, x, errors, correlations, size, bounds):
    """What the data do not tell, in sentences."""
    said = []
    for i, name in enumerate(free):
        if size[i] <= 1e-300 or (errors[i] > VAGUE * abs(x[i]) and name not in ("offset_U", "offset_F", "delta_bar")):
            said.append(f"the data do not determine {name}: {x[i]:.3g} +- {errors[i]:.2g}; fix it, or measure more")
        if min(x[i] - bounds[0, i], bounds[1, i] - x[i]) <= 1e-9 * max(1.0, abs(x[i])):
            said.append(f"{name} = {x[i]:.4g} is at the end of its range; its error means nothing")
        for j in range(i):
            if abs(correlations[i, j]) > APART:
                pair = f"{free[j]} and {name} cannot be told apart: correlation {correlations[i, j]:.3f}"
                said.append(f"{pair}; fix one of them, their errors mean little")
    return said
