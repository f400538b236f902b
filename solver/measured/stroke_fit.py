"""Parameters from a curve along U_x: bounded least squares with exact derivatives over continued runs.

A slip cuts the curve at a load that depends on the parameters. So a point is compared with the branch on which it was
measured, and the load of each slip is a datum of its own: it lies between the points on both sides.
Source of the method: Branch, Coleman & Li 1999, doi:10.1137/S1064827595289108 (scipy's "trf").
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import exp
from time import thread_time

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..analysis.partial import continuous
from ..analysis.prediction import AHEAD
from ..continuation.state import TINY, OutOfTime
from ..scene import LIMITS, Scene
from ..surfaces import DataError
from ..text import in_ascii
from .measurement import JUMP, Measurement
from .trial import NO_RUN, Model, inside

APART = 0.99  # correlation from which a fit warns: each parameter then has 7 times the error it has alone
FLAT = 1e-12  # eigenvalues below are round-off, of the normal matrix scaled to a unit diagonal
PEAK = (2.0 / exp(1.0)) ** 0.5  # of one spring's shear traction over phi_t/delta_t
SAME = 4.0  # standard errors, within which two searches found the same minimum
FAR = 1e3  # factor between a measured force and that of the interface beyond which its unit is wrong
UNITS = {"offset_U": "nm", "offset_F": "wE"}  # of free parameters that belong to the measurement


@dataclass(frozen=True, eq=False, repr=False)
class Fit:
    """Values and standard errors in the units of Scene (offset_U nm, offset_F as F_bar), correlations (n, n).

    chi2: per degree of freedom; reached: whether the curve fits within its noise; runs: trials computed; given: other
    parameters that change the curve nearly as the free ones do, "E = 70": make sure of them. rows: (U_x, quantity,
    measured, model) of every point; residuals (k,): over the noise, those of slips last.
    """

    values: dict[str, float]
    errors: dict[str, float]
    correlations: NDArray[np.float64]
    chi2: float
    reached: bool
    runs: int
    warnings: tuple[str, ...]
    given: tuple[str, ...]
    rows: list[tuple[float, str, float, float]]
    residuals: NDArray[np.float64]

    def __repr__(self) -> str:
        units = {name: LIMITS[name].unit if name in LIMITS else UNITS.get(name, "") for name in self.values}
        lines = [
            f"{name} = {v:.6g} +- {self.errors[name]:.2g} {units[name]}".rstrip() for name, v in self.values.items()
        ]
        fits = "fits within the noise" if self.reached else "does not fit within the noise"
        verdict = f"The curve {fits}: chi^2 = {self.chi2:.3g} per degree of freedom, {self.runs} runs"
        given = [f"Given: {', '.join(self.given)}; another value changes the curve nearly as the free parameters do"]
        cautions = (f"Caution: {each}" for each in self.warnings)
        return in_ascii("\n".join([*lines, verdict, *cautions, *given * bool(self.given)]))


def fit_of_stroke(scene: Scene, data: Measurement, free: tuple[str, ...], limit: float) -> Fit:
    """The Fit of a curve along U_x; parameters and errors as of `fit`."""
    check_plausible(scene, data)
    longest = max(float(data.U_x[-1]), scene.u_x_max)
    if "offset_U" in free:  # points move along the curve
        longest *= AHEAD
    base, begun = scene.changed(u_x_max=longest, path="shear"), thread_time()
    end = begun + limit
    model = Model(base, data, free, end)
    trial, caution = _optimum(model, limit)
    if data.slips and not _fits(trial) and thread_time() < end:  # slips may be missed, or be none
        uncut = Model(base, replace(data, slips=()), free, end)
        other, its_caution = _optimum(uncut, limit)
        if _chi2(other) < _chi2(trial):
            model, trial, caution = uncut, other, its_caution
    found = _fit_of(model, trial, caution)
    if not found.reached or found.warnings or thread_time() > end:
        return found
    return _checked(model, trial, found, limit, thread_time() - begun)


def _checked(model, trial, found, limit, spent):
    """The Fit, or that of a better minimum; searches from both sides tell whether others fit within the noise.

    Each search takes at most as long as the first one, `spent` s.
    """
    best, second, runs = trial, None, model.runs
    errors = np.array(list(found.errors.values()))
    for side in (-1.0, 1.0):
        other = Model(model.scene, model.measured, model.free, min(model.end, thread_time() + spent))
        other.restart(trial.predicted.skeleton)
        try:
            again, caution = _optimum(other, limit, _side(model, trial.x, side))
        except (*NO_RUN, OutOfTime):
            again, caution = trial, ""
        runs += other.runs
        if not caution and _fits(again) and (np.abs(again.x - trial.x) > SAME * errors).any():
            second = again
    if second is None:
        return replace(found, runs=runs)
    if second.cost < trial.cost:
        best, second = second, trial
    values = ", ".join(f"{name} = {value:.4g}" for name, value in zip(model.free, second.x, strict=True))
    warning = f"the curve at {values} fits within the noise, too; fix one of these, or measure L or A as well"
    found = _fit_of(model, best, "")
    return replace(found, runs=runs, warnings=(warning, *found.warnings))


def _side(model, x, side):
    """A start (n,) beyond the optimum x (n,), seen from the first start (1), or beyond that start (-1)."""
    step, size = x - model.start(), model.sizes()
    far = np.clip((1.5 - 0.5 * side) * np.abs(step), 0.3 * size, (0.75 - 0.25 * side) * size)
    return inside(x + side * np.copysign(far, step), model.bounds(), size)


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


def _optimum(model, limit, start=None):
    """(the best Trial of a Model, of an exact run if there is one; what limits its value, or ""). Raises as `fit`.

    start (n,): by default that of the Model.
    """
    x, trial = model.start() if start is None else start, None
    try:
        for _ in range(4):  # a search that has not settled after two corrections by an exact run goes to and fro
            # one that converges takes some 6 trials; with 400 points ftol is a change by 0.003 standard errors
            least_squares(
                model.residuals, x, model.jacobian, model.bounds(),
                x_scale=model.sizes(), max_nfev=30, xtol=1e-7, ftol=1e-8,
            )  # fmt: skip
            trial = model.best
            x, exact = trial.x, model.exact(model.scene_of(trial.x))
            continued, trial = trial, model.trial(x, exact)
            if np.abs(trial.residuals - continued.residuals).max() < 1.0:  # standard deviation of a point
                return trial, ""
            model.restart(exact)
    except NO_RUN as error:
        if trial is None:
            raise
        return trial, f"no exact run confirms these values: {error}".rstrip(".")
    except TimeoutError:
        trial = model.best or trial
        if trial is None:
            raise OutOfTime(f"no trial was computed within {limit:g} s; allow more, or raise E") from None
        return trial, f"stopped after {limit:g} s: the values are the best so far"
    return trial, "the exact run at these values differs from the continued one; vary the start"


def _freedom(trial):
    """Degrees of freedom: data less parameters."""
    return max(1, trial.residuals.size - trial.x.size)


def _chi2(trial):
    """Per degree of freedom."""
    return 2.0 * trial.cost / _freedom(trial)


def _fits(trial):
    """Whether chi^2 is no larger than noise makes it, to five standard deviations."""
    return _chi2(trial) < 1.0 + 5.0 * (2.0 / _freedom(trial)) ** 0.5


def _fit_of(model, trial, caution):
    """The Fit of the best Trial of a Model, with that caution."""
    chi2, reached = _chi2(trial), _fits(trial)
    deviation, correlations = uncertainty(trial.jacobian)
    errors = deviation * (1.0 if reached else chi2**0.5)
    warnings = [caution] if caution else []
    if not reached:
        misfit = f"the best curve does not fit: chi^2 is {chi2:.3g} per degree of freedom"
        warnings.append(f"{misfit}; {_remedy(model, trial)}")
    warnings += _of_slips(model, trial) + _of_parameters(model, trial, errors, correlations)
    given = _given(model, trial) if reached else ()
    named = [dict(zip(model.free, map(float, numbers), strict=True)) for numbers in (trial.x, errors)]
    return Fit(
        *named, correlations, chi2, reached, model.runs, tuple(warnings), given, _rows(model, trial), trial.residuals
    )


def uncertainty(jacobian: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(standard deviations (n,), correlations (n, n)) of parameters, from residuals' derivatives (k, n)."""
    size = np.maximum(np.linalg.norm(jacobian, axis=0), TINY)
    curvature, ways = np.linalg.eigh((jacobian / size).T @ (jacobian / size))
    with np.errstate(invalid="ignore", divide="ignore"):  # without a derivative a deviation is inf
        covariance = (ways / np.maximum(curvature, FLAT)) @ ways.T / np.outer(size, size)
        deviation = np.sqrt(np.diag(covariance))
        return deviation, covariance / np.outer(deviation, deviation)


def _rows(model, trial):
    """As of Fit."""
    measured, kept, rows = model.measured, model.kept, []
    for name, off in zip(model.names, np.split(trial.residuals, np.arange(1, 4) * kept.sum()), strict=False):
        y = measured.values[name][kept]
        curve = y + off * measured.noise[name]
        rows += zip(measured.U_x[kept].tolist(), [name] * y.size, y.tolist(), curve.tolist(), strict=True)
    return rows


def _remedy(model, trial):
    """What to do about a curve that does not fit."""
    period, apart = trial.predicted.skeleton.period, np.diff(model.intervals.mean(axis=0))
    if period and trial.predicted.slipping and apart.size:
        measured = float(np.median(apart))
        if abs(measured / period - 1.0) > 0.25:  # slips go on by another number of sites
            return f"the data slip every {measured:.3g} nm, the curve every {period:.3g} nm; vary E or phi_ratio"
    return "check units and noise, free other parameters, or vary the start"


def _of_slips(model, trial):
    """A warning about predicted slips that the data do not show."""
    measured, chi = model.measured, min(1.0, _chi2(trial)) ** 0.5  # noise may be overestimated
    count = trial.predicted.count(JUMP * trial.noise * chi)
    if count <= len(measured.slips):
        return []
    used = f"{len(measured.slips)} of {count} predicted slips are recognised in the data and used"
    return [f"{used}; compare the curves, or measure more densely"]


def _of_parameters(model, trial, errors, correlations):
    """Warnings about parameters that the data do not determine."""
    free, x, (low, high), warnings = model.free, trial.x, model.bounds(), []
    size = np.linalg.norm(trial.jacobian, axis=0)
    at_end = np.minimum(x - low, high - x) <= 1e-9 * np.maximum(1.0, np.abs(x))  # scipy stays 1e-10 of it inside
    for i, name in enumerate(free):
        # from an error of half the value on, the 95 % interval contains 0
        vague = errors[i] > 0.5 * abs(x[i]) and name not in ("offset_U", "offset_F", "delta_bar")
        if vague or at_end[i] or size[i] <= TINY:
            found = f"{x[i]:.4g} +- {errors[i]:.2g}" + ", at the end of its range" * bool(at_end[i])
            warnings.append(f"the data do not determine {name}: {found}; fix it, or measure more")
    return [*warnings, *alike(free, correlations)]


def alike(free: Sequence[str], correlations: NDArray[np.float64]) -> list[str]:
    """Warnings about pairs of parameters (n,) that correlations (n, n) do not tell apart."""
    return [
        f"the data do not tell {free[j]} from {free[i]} (correlation {correlations[i, j]:.3f}), and their errors mean"
        " little; fix one of them"
        for i in range(len(free))
        for j in range(i)
        if abs(correlations[i, j]) > APART
    ]


def _given(model, trial):
    """Fixed parameters that change the curve nearly as the free ones do, "E = 70": a wrong value stays hidden."""
    scene, n = trial.predicted.skeleton.scene, len(model.free)
    fixed = tuple(name for name in continuous(scene) if name not in model.free)
    x = np.array([*trial.x, *(getattr(scene, name) for name in fixed)])
    try:
        slopes = Model(scene, model.measured, model.free + fixed).trial(x, trial.predicted.skeleton).jacobian
    except NO_RUN:  # these derivatives are a check only
        return ()
    slopes /= np.maximum(np.linalg.norm(slopes, axis=0), TINY)
    along = slopes[:, :n] @ np.linalg.lstsq(slopes[:, :n], slopes[:, n:], rcond=FLAT)[0]
    alike = [name for name, share in zip(fixed, np.linalg.norm(along, axis=0), strict=True) if share > APART]
    return tuple(f"{name} = {getattr(scene, name):.4g}" for name in alike)
