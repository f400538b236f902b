"""Parameters from a measurement: bounded least squares with exact derivatives over continued runs.

A slip cuts the curve at a load that depends on the parameters. So a point is compared with the branch on which it was
measured, and the load of each slip is a datum of its own: it lies between the points on both sides.
Source of the method: Branch, Coleman & Li 1999, doi:10.1137/S1064827595289108 (scipy's "trf").
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..continuation.state import OutOfTime
from ..scene import Scene
from ..tables import Source
from .measurement import JUMP, Measurement, read_measurement
from .partial import DRIVE, continuous
from .prediction import AHEAD
from .trial import AXES, NO_RUN, Model, TimeUp, Trial

APART = 0.99  # correlation beyond which two parameters count as one: each has 7 times the error it has alone
VAGUE = 0.5  # standard error over value, beyond which a 95 % interval contains 0: the data do not determine it
UNLIKELY = 5.0  # standard deviations of chi^2 above what noise makes, beyond which the curve does not fit
TOO_GOOD = 0.25  # chi^2 that noise does not make: even of 40 points it is known to a third
FLAT = 1e-12  # of the normal matrix scaled to a unit diagonal: curvature that round-off leaves where there is none
ALIKE = 1.0  # standard deviations of a point, by which an exact run may differ from a continued one
PER_PERIOD = 12  # points, with which each slip shows as a drop at once (tests/bench/fit.py --sparse)
PERIODS = 0.25  # relative difference, beyond which slips go on by another number of sites


@dataclass(frozen=True)
class FitOptions:
    """How a fit searches."""

    starts: int = 3  # the scene itself and random ones near it, as long as none fits
    steps: int = 30  # trials from one start, at most: a search that converges takes some 6 (tests/bench/fit.py)
    # optima from one start: each is compared with an exact run, and left from there if it differs. A search that has
    # not settled after two such corrections goes to and fro
    rounds: int = 4
    # relative changes of the parameters and of chi^2 that end a search. With 400 points the latter is a change by 0.003
    # standard errors
    xtol: float = 1e-7
    ftol: float = 1e-8
    limit: float = 60.0  # s, of the whole fit: about as long as somebody waits
    run_limit: float = 20.0  # s, of one exact run: 30 times that of the default scene


USUAL = FitOptions()


@dataclass(frozen=True)
class Fit:
    """Values and standard errors in the units of Scene (offset_U nm, offset_F as F_bar), correlations (n, n).

    chi2: per degree of freedom; reached: whether the curve fits within its noise; runs: trials computed. rows: (U_x,
    quantity, measured, model) of every point; residuals (k,): over the noise, those of slips last.
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
        verdict = {"chi2": self.chi2, "reached": self.reached, "runs": self.runs, "warnings": list(self.warnings)}
        return numbers | verdict | {"residuals": self.residuals.tolist()}


class Optimum(NamedTuple):
    """The best Trial of a Model from a start, and the sentence that limits its value, or ""."""

    model: Model
    trial: Trial
    caution: str = ""


def fit(scene: Scene, measured: Measurement | Source, free: Sequence[str], options: FitOptions = USUAL) -> Fit:
    """Fits parameters of a scene to a measured curve.

    Parameters: scene: where the search starts, and the values of all other parameters; measured: as of
    `read_measurement`, or what that reads; free: names of continuous parameters, or of AXES; options: how it searches.
    Returns a Fit: values, standard errors, correlations, and warnings about what the data do not determine.
    Raises ValueError for names that cannot be free, or none, and for an unusable file; NotFollowed, NotConverged or
    SceneError where no start has a run, OutOfTime where none has one in time.

    Example: `fit(Scene(), "measured.csv", ["phi_n"]).values`
    """
    measured = measured if isinstance(measured, Measurement) else read_measurement(measured, scene)
    allowed = (*continuous(scene), *AXES)
    if isinstance(free, str) or not free:
        raise ValueError(f"free = {free!r}: allowed: a list of names, one or more; write [{free or allowed[0]!r}]")
    for name in free:
        if name not in allowed or list(free).count(name) > 1:
            first = f"; give {name} a number first, as inf is a rigid drive" * (name in DRIVE)
            raise ValueError(f"free = {name!r}: allowed, once each: {', '.join(allowed)}{first}")
    longest = max(float(measured.U_x[-1]), scene.u_x_max)
    if {"offset_U", "scale_U"} & set(free):  # points move along the curve
        longest *= AHEAD
    base, end = scene.changed(u_x_max=longest, path="shear"), perf_counter() + options.limit
    best = _best(Model(base, measured, tuple(free), options.run_limit, end), options)
    if measured.slips and not _fits(best.trial) and perf_counter() < end:  # slips may be missed, or be none
        uncut = Model(base, replace(measured, slips=()), tuple(free), options.run_limit, end)
        best = min(best, _best(uncut, options), key=lambda optimum: _chi2(optimum.trial))
    return _fit_of(best)


def _best(model, options):
    """The Optimum of a Model that fits, or else the best one of all starts; raises as `fit`."""
    best, failure, rng = None, None, np.random.default_rng(1)
    for number in range(max(1, options.starts)):
        try:
            optimum = _optimum(model, model.start(rng if number else None), options)
        except NO_RUN as error:
            failure = failure or error
            continue
        if best is None or optimum.trial.cost < best.trial.cost:
            best = optimum
        if _fits(best.trial) or perf_counter() > model.end:
            break
    if best is None:
        raise failure
    return best


def _optimum(model, x, options):
    """The Optimum from a start x: its Trial is one of an exact run, unless there is none."""
    model.restart()
    trial = None
    try:
        for _ in range(options.rounds):
            least_squares(
                model.residuals, x, model.jacobian, model.bounds(),
                x_scale=model.sizes(), max_nfev=options.steps, xtol=options.xtol, ftol=options.ftol,
            )  # fmt: skip
            trial = model.best
            x, exact = trial.x, model.exact(model.scene_of(trial.x))
            continued, trial = trial, model.trial(x, exact)
            if np.abs(trial.residuals - continued.residuals).max() < ALIKE:
                return Optimum(model, trial)
            model.restart(exact)
    except NO_RUN as error:
        if trial is None:
            raise
        return Optimum(model, trial, f"no exact run confirms these values: {error}".rstrip("."))
    except TimeUp:
        trial = model.best or trial
        if trial is None:
            raise OutOfTime(f"no trial was computed within {options.limit:g} s; allow more, or raise E") from None
        return Optimum(model, trial, f"stopped after {options.limit:g} s: the values are the best so far")
    return Optimum(model, trial, "the exact run at these values differs from the continued one; vary the start")


def _freedom(trial):
    """Degrees of freedom: data less parameters."""
    return max(1, trial.residuals.size - trial.x.size)


def _chi2(trial):
    """Per degree of freedom."""
    return 2.0 * trial.cost / _freedom(trial)


def _fits(trial):
    """Whether chi^2 is no larger than noise makes it."""
    return _chi2(trial) < 1.0 + UNLIKELY * (2.0 / _freedom(trial)) ** 0.5


def _fit_of(optimum):
    """The Fit of an Optimum."""
    model, trial, chi2, reached = optimum.model, optimum.trial, _chi2(optimum.trial), _fits(optimum.trial)
    deviation, correlations = _uncertainty(trial.jacobian)
    errors = deviation * (1.0 if reached else chi2**0.5)
    warnings = [optimum.caution] if optimum.caution else []
    if not reached:
        misfit = f"the best curve does not fit: chi^2 is {chi2:.3g} per degree of freedom"
        warnings.append(f"{misfit}; {_remedy(model, trial)}")
    if chi2 < TOO_GOOD:
        warnings.append(f"chi^2 is {chi2:.3g} per degree of freedom: the noise, and so the errors, are overestimated")
    warnings += _of_slips(model, trial) + _of_parameters(model, trial, errors, correlations)
    named = [dict(zip(model.free, map(float, numbers), strict=True)) for numbers in (trial.x, errors)]
    return Fit(*named, correlations, chi2, reached, model.runs, tuple(warnings), _rows(model, trial), trial.residuals)


def _uncertainty(jacobian):
    """(standard deviations (n,), correlations (n, n)) of parameters, from residuals' derivatives (k, n)."""
    size = np.maximum(np.linalg.norm(jacobian, axis=0), 1e-300)
    curvature, ways = np.linalg.eigh((jacobian / size).T @ (jacobian / size))
    covariance = (ways / np.maximum(curvature, FLAT)) @ ways.T / np.outer(size, size)
    deviation = np.sqrt(np.diag(covariance))
    with np.errstate(invalid="ignore", divide="ignore"):
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
        measured, computed = float(np.median(apart)), period * trial.axes.scale_U
        if abs(measured / computed - 1.0) > PERIODS:
            return f"the data slip every {measured:.3g} nm, the curve every {computed:.3g} nm; vary E or phi_ratio"
    return "check units and noise, free other parameters, or vary the start"


def _of_slips(model, trial):
    """Warnings about slips that the data cannot show, or do not show."""
    predicted, measured, warnings = trial.predicted, model.measured, []
    period, spacing = predicted.skeleton.period, float(np.median(np.diff(measured.U_x)))
    if period and period * trial.axes.scale_U < PER_PERIOD * spacing:
        points = f"{period * trial.axes.scale_U / spacing:.2g} points on a period of {period:.3g} nm"
        warnings.append(f"{points} are too few to recognise slips safely; measure {PER_PERIOD} or more")
    count = predicted.count(JUMP * trial.noise * min(1.0, _chi2(trial)) ** 0.5)  # noise may be overestimated
    if count > len(measured.slips):
        used = f"{len(measured.slips)} of {count} predicted slips are recognised in the data and used"
        warnings.append(f"{used}; compare the curves, or measure more densely")
    return warnings


def _of_parameters(model, trial, errors, correlations):
    """Warnings about parameters that the data do not determine."""
    free, x, (low, high), warnings = model.free, trial.x, model.bounds(), []
    size = np.linalg.norm(trial.jacobian, axis=0)
    for i, name in enumerate(free):
        if size[i] <= 1e-300 or (errors[i] > VAGUE * abs(x[i]) and name not in ("offset_U", "offset_F", "delta_bar")):
            warnings.append(f"the data do not determine {name}: {x[i]:.3g} +- {errors[i]:.2g}; fix it, or measure more")
        if min(x[i] - low[i], high[i] - x[i]) <= 1e-9 * max(1.0, abs(x[i])):  # scipy stays 1e-10 of it inside
            warnings.append(f"{name} = {x[i]:.4g} is at the end of its range; its error means nothing")
        for j in range(i):
            if abs(correlations[i, j]) > APART:
                pair = f"{free[j]} and {name} cannot be told apart: correlation {correlations[i, j]:.3f}"
                warnings.append(f"{pair}; fix one of them, their errors mean little")
    return warnings
