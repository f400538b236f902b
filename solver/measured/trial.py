"""A trial of a fit: residuals of the predicted curve over the noise of the data, with their derivatives."""

from math import inf
from time import thread_time
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..analysis.partial import NAMES
from ..analysis.prediction import Predicted
from ..analysis.sensitivities import sensitivities
from ..continuation.state import NotConverged, OutOfTime
from ..following.follow import follow
from ..following.from_run import skeleton_of
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton
from ..scene import LIMITS, Scene, SceneError
from ..text import counted
from .measurement import Measurement

Floats = NDArray[np.float64]
EXACT = 1e-4  # of the node spacing: a slip cannot be measured more exactly
UNIFORM = 12.0**-0.5  # standard deviation of a slip that lies anywhere in an interval, over its length
RUN_LIMIT = 20.0  # s of processor time, of one exact run: 30 times that of the default scene
NO_RUN = NotFollowed, NotConverged, SceneError
# measured U_x = U_x + offset_U (nm); measured F = scale_F F + offset_F, offset_F in units of F_bar
AXES = {"offset_U": 0.0, "scale_F": 1.0, "offset_F": 0.0}
OFF = 0.1  # typical sizes from the end of a range at which a search starts; from the end itself it never leaves it
# of parameters that may be 0: an indentation of delta_n, a part of a lattice period in nm; offset_F: of the range of F
SIZES = {"delta_bar": 0.1, "offset_U": 1.0, "offset_F": 0.1}


class Trial(NamedTuple):
    """Parameters x (n,), residuals (k,), their derivatives (k, n), and the run they come from.

    noise: that of the measured F, in F_bar.
    """

    x: Floats
    residuals: Floats
    jacobian: Floats
    predicted: Predicted
    noise: float

    @property
    def cost(self) -> float:
        """Half the sum of squares."""
        return 0.5 * float(self.residuals @ self.residuals)


def inside(x: Floats, bounds: Floats, sizes: Floats) -> Floats:
    """x (n,) within bounds (2, n), OFF typical sizes (n,) from an end at which it lies: there steps have no room."""
    low, high = bounds
    off = np.minimum(OFF * sizes, 0.5 * (high - low))
    close = 1e-3 * off
    return np.where(x <= low + close, low + off, np.where(x >= high - close, high - off, x))


class Model:
    """Residuals and derivatives as functions of the free parameters; each run is continued from the last one.

    scene: values of the other parameters. end: processor time of this thread (`thread_time`) after which TimeoutError
    is raised. best: the Trial of least cost since `restart`; runs: trials computed so far.
    """

    def __init__(self, scene: Scene, measured: Measurement, free: tuple[str, ...], end: float = inf):
        self.scene, self.measured, self.free, self.end = scene, measured, free, end
        self.physical = tuple(name for name in free if name not in AXES)
        k, cuts = measured.U_x.size, np.array(measured.slips, int)
        self.kept = np.ones(k, bool)
        self.kept[cuts - 1] = False  # the last point before a slip locates it, and does not count as a force as well
        self.segment = np.searchsorted(cuts, np.arange(k), side="right")
        self.intervals = np.array([measured.U_x[cuts - 1], measured.U_x[cuts]])  # (2, slips) nm, each holds a slip
        self.runs = 0
        self.restart()

    def restart(self, skeleton: Skeleton | None = None) -> None:
        """Forget the trials so far; the next one is continued from `skeleton`, or run from its start."""
        self.best: Trial | None = None
        self.last: Trial | None = None
        self.skeleton = skeleton

    def start(self) -> Floats:
        """Parameters x (n,) of the scene, off the ends of their ranges."""
        return inside(np.array([self._first(name) for name in self.free]), self.bounds(), self.sizes())

    def _first(self, name):
        return AXES[name] if name in AXES else getattr(self.scene, name)

    def bounds(self) -> Floats:
        """(lowest (n,), highest (n,))."""
        # a factor beyond is a wrong unit
        free = {"scale_F": (0.1, 10.0), "offset_U": (-np.inf, np.inf), "offset_F": (-np.inf, np.inf)}
        return np.array([free.get(name) or (LIMITS[name].low, LIMITS[name].high) for name in self.free]).T

    def sizes(self) -> Floats:
        """Typical sizes (n,) of the parameters, in which steps are measured."""
        own = SIZES | {"offset_F": SIZES["offset_F"] * float(np.ptp(self.measured.values["F_bar"]))}
        return np.array([own.get(name) or abs(self._first(name)) or 1.0 for name in self.free])

    def residuals(self, x: Floats) -> Floats:
        """Residuals (k,) over the noise. Where x has no run: far larger ones; raises if x is the first."""
        try:
            return self._trial(x).residuals
        except NO_RUN:
            if self.last is None:
                raise
            # where residuals grow, the optimiser goes back, and a quarter as far
            return 10.0 * (np.abs(self.last.residuals) + 1.0)

    def jacobian(self, x: Floats) -> Floats:
        """Derivatives (k, n) of the residuals by x."""
        return self._trial(x).jacobian

    def _trial(self, x):
        """The Trial of x, and remember it."""
        if self.last is None or not np.array_equal(x, self.last.x):
            if thread_time() > self.end:
                raise TimeoutError
            self.skeleton = self._run(self.scene_of(x))
            self.last = self.trial(x, self.skeleton)
            if self.best is None or self.last.cost < self.best.cost:
                self.best = self.last
        return self.last

    def scene_of(self, x: Floats) -> Scene:
        """The Scene with the free parameters x; raises SceneError."""
        values = zip(self.free, map(float, x), strict=True)
        return self.scene.changed(**{name: value for name, value in values if name not in AXES})

    def _run(self, scene):
        """The Skeleton of a scene, continued from the last one if possible."""
        self.runs += 1
        try:
            if self.skeleton is not None:
                return follow(self.skeleton, scene)
        except NotFollowed:
            pass
        return self.exact(scene)

    def exact(self, scene: Scene) -> Skeleton:
        """The Skeleton of a scene from a run within the time left; raises as `skeleton_of`, and TimeoutError."""
        left = self.end - thread_time()
        try:
            return skeleton_of(scene, max(0.0, min(RUN_LIMIT, left)))
        except OutOfTime:
            if left < RUN_LIMIT:
                raise TimeoutError from None
            raise

    def trial(self, x: Floats, skeleton: Skeleton) -> Trial:
        """The Trial of parameters x whose run is `skeleton`; raises NotFollowed where it slips too few times."""
        axes = AXES | dict(zip(self.free, map(float, x), strict=True))
        U_x = self.measured.U_x - axes["offset_U"]
        unit = axes["scale_F"] * self._unit(skeleton, "F_bar")
        start, reach = float(U_x[0]), float(U_x[-1])
        predicted = Predicted(sensitivities(skeleton, self.physical), self.measured.seen / unit, start, reach)
        curve = predicted.curve(U_x[self.kept], self.segment[self.kept], self.physical)
        parts = [self._quantity(k, curve, skeleton, axes) for k, name in enumerate(NAMES) if name in self.names]
        parts.append(self._slips(predicted, axes["offset_U"]))
        residuals, rows = zip(*parts, strict=True)
        noise = self.measured.noise["F_bar"] / unit
        return Trial(x.copy(), np.concatenate(residuals), np.vstack(rows), predicted, noise)

    @property
    def names(self) -> tuple[str, ...]:
        """Measured quantities, in the order of their residuals."""
        return tuple(name for name in NAMES if name in self.measured.values)

    def _unit(self, skeleton, name):
        """Measured units per F_bar, L_bar or A_bar: 1, or w E or w of the trial over that of a measurement."""
        scene, measured = skeleton.scene, self.measured
        if name == "A_bar":
            return scene.width / measured.width if measured.width else 1.0
        return scene.width * scene.E / measured.unit if measured.unit else 1.0

    def _quantity(self, k, curve, skeleton, axes):
        """(residuals (points,), derivatives (points, n)) of F_bar, L_bar or A_bar, number k."""
        name, values, slopes = NAMES[k], curve.values[k], curve.slopes[k]
        scaled = axes["scale_F"] if name == "F_bar" else 1.0
        gain = scaled * self._unit(skeleton, name)
        by = dict(zip(self.physical, gain * curve.by[:, k], strict=True))
        if self.measured.width if name == "A_bar" else self.measured.unit:  # N/m and nm grow with these
            grow = {"width"} if name == "A_bar" else {"E", "width"}
            by |= {own: by[own] + gain * values / getattr(skeleton.scene, own) for own in grow & by.keys()}
        by["offset_U"] = -gain * slopes
        if name == "F_bar":
            by |= {"scale_F": gain / axes["scale_F"] * values, "offset_F": np.ones(values.size)}
        noise, offset = self.measured.noise[name], axes["offset_F"] if name == "F_bar" else 0.0
        residuals = gain * values + offset - self.measured.values[name][self.kept]
        return residuals / noise, self._columns(by, values.size) / noise

    def _slips(self, predicted, offset):
        """(residuals (slips,), derivatives (slips, n)) of the loads of slips; zero while no slip is visible."""
        count = self.intervals.shape[1]
        if not predicted.slipping:  # the points of the curve lead on
            return np.zeros(count), np.zeros((count, len(self.free)))
        loads, slopes, *where = predicted.slips(count, self.physical)
        if loads.size < count:
            predicted = f"{counted(loads.size, 'predicted slip')}, {count} measured"
            raise NotFollowed(f"{predicted}; start from a scene that slips as often: vary E, phi_ratio or delta_bar")
        by = dict(zip(self.physical, slopes, strict=True)) | {"offset_U": np.ones(count)}
        measured, errors = self._located(*where)
        return (loads + offset - measured) / errors, self._columns(by, count) / errors[:, None]

    def _located(self, branch, moved):
        """(measured loads of slips (n,) nm, their standard deviations (n,) nm).

        A slip lies anywhere in its interval. Slips at a known distance from each other, `moved` (n,) nm on the same
        `branch` (n,), have one load modulo that, inside all their intervals.
        """
        loads, errors = self.intervals.mean(axis=0), UNIFORM * np.ptp(self.intervals, axis=0)
        errors = np.maximum(errors, EXACT * self.scene.spacing)  # two points may have the U_x of the slip
        for k in np.unique(branch) if "width" not in self.free else ():
            mine = branch == k
            low, high = (self.intervals[0, mine] - moved[mine]).max(), (self.intervals[1, mine] - moved[mine]).min()
            if low < high:
                loads[mine] = 0.5 * (low + high) + moved[mine]
                errors[mine] = UNIFORM * (high - low) * mine.sum() ** 0.5
        return loads, errors

    def _columns(self, by, count):
        """(count, n) of {name: (count,)}; zero for a parameter that is not in it."""
        return np.array([by.get(name, np.zeros(count)) for name in self.free]).reshape(len(self.free), count).T
