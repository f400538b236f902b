"""Parameters from a measured loop: runs through its turning points, compared after a running mean.

A slip is a step of F, and a curve with steps has no derivative by a parameter that moves them. Its running mean has
one, so both curves are averaged: over a period of the lattice first, then over ever fewer points.
"""

from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, field
from functools import partial
from time import thread_time
from types import SimpleNamespace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..continuation.state import OutOfTime
from ..run.loadpath import load_path
from ..scene import LIMITS, Scene, SceneError
from ..surfaces import DataError
from ..text import counted
from .comparison import Comparison, compared
from .measurement import Measurement, Recording
from .stroke_fit import Fit, alike, check_plausible, fit_of_stroke, uncertainty
from .trial import NO_RUN, inside

Floats = NDArray[np.float64]
POINTS = (25, 13, 5)  # of the running means, in turn; odd
STEP = 6e-4  # of a parameter, times the points of the mean: a slip then moves by less than these
TRIALS = 12  # of the search with one mean
CALM = 0.9  # of the points: so many must lie within five deviations; the others are beside slips
NO_LOOP = "the best loop does not fit; check units and noise, free other parameters, or vary the start"
MOST = 17  # segments: a path has 20 points, three of which are the approach and the first pull


@dataclass(eq=False)
class LoopModel:
    """Residuals of a loop by the free parameters. best: (cost, x, Comparison) of one mean; done: all runs."""

    scene: Scene
    measured: Recording
    free: tuple[str, ...]
    left: float  # s of processor time, wherever it is spent
    executor: Executor | None = None  # computes the runs of a derivative at once
    best: tuple[float, Floats, Comparison] | None = None
    done: dict[tuple[float, ...], Comparison] = field(default_factory=dict)

    def residuals(self, x: Floats, points: int) -> Floats:
        """(k,) over the noise, averaged over so many points; raises TimeoutError at the end of the time."""
        key = tuple(map(float, x))
        if key not in self.done:
            self._run([key], map)
        found, off = self.done[key], off_of(self.done[key])
        ends = np.cumsum([segment.x.size for segment in self.measured.segments if segment.name != "hold"])[:-1]
        averaged = np.concatenate([_mean(part, points) for part in np.split(off, ends)])
        cost = float(averaged @ averaged)
        if self.best is None or cost < self.best[0]:
            self.best = cost, np.array(key), found
        return averaged

    def _run(self, keys, mapped):
        """Compute the runs of these keys by a `map`; raises TimeoutError at the end of the time."""
        if self.left <= 0.0:
            raise TimeoutError
        call = partial(comparison_at, self.scene, self.measured, self.free, limit=self.left)
        for key, (found, spent) in zip(keys, mapped(call, keys), strict=True):
            self.left -= spent
            if found is None:
                raise TimeoutError
            self.done[key] = found

    def jacobian(self, x: Floats, points: int) -> Floats:
        """(k, n) derivatives of the residuals, by differences; raises as `residuals`."""
        step = STEP * points * np.maximum(np.abs(x), 0.1)
        step *= np.where(x + step > [LIMITS[name].high for name in self.free], -1.0, 1.0)
        beside = x + np.diag(step)
        if self.executor is not None:
            self._run([key for key in map(tuple, beside.tolist()) if key not in self.done], self.executor.map)
        here = self.residuals(x, points)
        return np.array([self.residuals(each, points) - here for each in beside]).T / step

    def search(self, x: Floats, means: tuple[int, ...], limit: float) -> tuple[Floats | None, str]:
        """(derivatives (k, n) at the least squares from a start x by these means, what limits the values or "").

        Without derivatives where the `limit` (s) stopped it. Raises OutOfTime.
        """
        bounds = np.array([(LIMITS[name].low, LIMITS[name].high) for name in self.free]).T
        try:
            for points in means:
                self.best, size = None, np.maximum(np.abs(x), 0.1)
                found = least_squares(
                    self.residuals, inside(x, bounds, size), self.jacobian, bounds=bounds, loss="soft_l1",
                    x_scale=size, xtol=1e-4, ftol=1e-4, max_nfev=TRIALS, args=(points,),
                )  # fmt: skip
                x = found.x
            return self.jacobian(x, means[-1]), ""  # that of `least_squares` is scaled by the loss
        except TimeoutError:
            if self.best is None:
                reason = f"no run of the loop was computed within {limit:g} s; allow more, or raise E"
                raise OutOfTime(reason) from None
            return None, f"stopped after {limit:g} s: the values are the best so far"


def comparison_at(
    scene: Scene, measured: Recording, free: tuple[str, ...], x: tuple[float, ...], limit: float
) -> tuple[Comparison | None, float]:
    """(the Comparison with the run at values x of the free parameters, processor time, s); None beyond the limit, s.

    Raises NotConverged, SceneError.
    """
    begun, found = thread_time(), None
    scene = looped(scene.changed(**dict(zip(free, x, strict=True))), measured)
    with suppress(OutOfTime):
        frames = list(load_path(scene, limit=limit))
        # forces in N/m are compared; those over F_s would need the first slip
        found = compared(measured, SimpleNamespace(scene=scene, frames=frames, first_slip=None))
    return found, thread_time() - begun


def off_of(found: Comparison) -> Floats:
    """(k,) computed less measured, over the noise."""
    return np.array([(computed - seen) / found.noise[name] for _, _, name, seen, computed in found.rows])


def _mean(y, points):
    """The running mean of y (k,), ends repeated."""
    return np.convolve(np.pad(y, points // 2, mode="edge"), np.ones(points) / points, "valid")


def looped(scene: Scene, measured: Recording) -> Scene:
    """The scene on the path of a loop: pressed to delta_bar, then through the turning points. Raises DataError."""
    slides = [segment for segment in measured.segments if segment.name != "hold"]
    if len(slides) > MOST:
        raise DataError(f"{counted(len(slides), 'segment')}; a fit takes up to {MOST}; keep a part of the loop")
    ends = [float(segment.x[-1]) for segment in slides]
    if not measured.virgin:  # it begins where it closes
        ends = [float(slides[0].x[0]), *ends]
    places = [(0.0, -1.0), (0.0, scene.delta_bar), *((end, scene.delta_bar) for end in ends)]
    return scene.changed(path="points", points="; ".join(f"{U_x:.9g},{depth:.9g}" for U_x, depth in places))


def fit_of_loop(
    scene: Scene, measured: Recording, free: tuple[str, ...], limit: float, executor: Executor | None = None
) -> Fit:
    """The Fit of a Recording of a loop: of its first pull, if it has that, then of all of it."""
    if measured.unfit:
        raise DataError(measured.unfit)
    if scene.hold == "load":  # its runs go through points, which hold no load
        raise SceneError(
            "hold", "load", "allowed in a fit of a loop: delta", "use hold=delta, or fit its first pull only"
        )
    begun = thread_time()
    # near: whether the start is that of a fit of the first pull, so that the finest mean suffices
    start, near = np.array([getattr(scene, name) for name in free]), False
    first, unit = measured.segments[0], scene.width * scene.E
    if measured.virgin and first.name == "forth":
        order = np.argsort(first.x, kind="stable")
        in_force = [name for name in first.values if measured.units[name] == "N/m"]
        values = {f"{name}_bar": first.values[name][order] / unit for name in in_force}
        stroke = Measurement.of(first.x[order], values, unit=unit)
        check_plausible(scene, stroke)
        try:
            start, near = np.array(list(fit_of_stroke(scene, stroke, free, 0.5 * limit).values.values())), True
        except (*NO_RUN, TimeoutError):  # then the search begins where the scene is
            pass
    model = LoopModel(scene, measured, free, limit - (thread_time() - begun), executor)
    jacobian, caution = model.search(start, POINTS[-1:] if near else POINTS, limit)
    assert model.best  # a search computes one run at least, or raises
    _, x, found = model.best
    off = off_of(found)
    calm = np.abs(off) < 5.0  # a point beside a slip counts by the running mean
    freedom = max(1, int(calm.sum()) - x.size)
    chi2 = float((off[calm] ** 2).sum()) / freedom
    reached = chi2 < 1.0 + 5.0 * (2.0 / freedom) ** 0.5 and calm.mean() > CALM
    if not reached:  # by the points that do not fit, too
        chi2 = float(off @ off) / max(1, off.size - x.size)
    deviation, correlations = uncertainty(jacobian if jacobian is not None else np.zeros((1, x.size)))
    deviation *= max(1.0, chi2) ** 0.5
    warnings = [*[caution] * bool(caution), *[NO_LOOP] * (not reached), *alike(free, correlations)]
    found_at, errors = (dict(zip(free, map(float, numbers), strict=True)) for numbers in (x, deviation))
    over = {"N/m": unit, "nm": scene.width}
    units = {name: over.get(found.units[name], 1.0) for name in found.units}
    rows = [
        (U_x, f"{name}_bar", seen / units[name], computed / units[name]) for _, U_x, name, seen, computed in found.rows
    ]
    return Fit(found_at, errors, correlations, chi2, reached, len(model.done), tuple(warnings), (), rows, off)
