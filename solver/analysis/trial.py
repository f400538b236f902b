"""The curve of trial parameters against a measured one: residuals over their noise, and their derivatives."""

import numpy as np

from ..continuation.state import NotConverged
from ..following.branch import NotFollowed
from ..following.follow import follow
from ..following.reading import skeleton_of
from ..scene import LIMITS, SceneError
from .outputs import NAMES
from .prediction import Predicted
from .sensitivities import sensitivities

AXES = {"scale_U": 1.0, "offset_U": 0.0, "scale_F": 1.0, "offset_F": 0.0}  # measured = scale * computed + offset
SCALES = (0.1, 10.0)
PERIOD = {"scale_U", "width"}  # what the distance of slips that repeat themselves depends on
PLACE = 12.0**-0.5  # of an interval, standard deviation of a slip that lies anywhere in it
APART_BY = 1.5  # factor, largest, between the first start and another one
WORSE = 10.0  # times the residual: what a run that is not had counts


class Model:
    """Residuals over their noise, and their derivatives, of parameters x; runs are followed from the last one."""

    def __init__(self, scene, measured, free):
        self.scene, self.measured, self.free, self.runs = scene, measured, free, 0
        self.physical = tuple(name for name in free if name not in AXES)
        k, cuts = measured.U_x.size, np.array(measured.slips, int)
        self.kept = np.ones(k, bool)
        self.kept[cuts - 1] = False  # it tells where the slip is, and so cannot tell F there as well
        self.branch = np.searchsorted(cuts, np.arange(k), side="right")
        self.ends = np.array([measured.U_x[cuts - 1], measured.U_x[cuts]])  # of the intervals in which it slips
        self.skeleton, self.known, self.at, self.last = None, None, None, None

    def start(self, rng):
        """x (n,): that of the scene, or one near it."""
        x = np.array([AXES.get(name, getattr(self.scene, name, 0.0)) for name in self.free])
        if rng is not None:
            factor = APART_BY ** rng.uniform(-1.0, 1.0, x.size)
            x = np.where(x != 0.0, x * factor, 0.1 * np.log(factor) * (np.array(self.free) == "delta_bar"))
        return np.clip(x, *self.bounds())

    def bounds(self):
        """(lowest (n,), highest (n,))."""
        free = {"scale_U": SCALES, "scale_F": SCALES, "offset_U": (-np.inf, np.inf), "offset_F": (-np.inf, np.inf)}
        return np.array([free.get(name) or (LIMITS[name].low, LIMITS[name].high) for name in self.free]).T

    def sizes(self):
        """Of what a step of each is measured in, (n,)."""
        F = float(np.ptp(self.measured.values["F_bar"]))
        own = {"delta_bar": 0.1, "offset_U": 1.0, "offset_F": 0.1 * F}
        return np.array(
            [own.get(name) or abs(AXES.get(name) or getattr(self.scene, name)) or 1.0 for name in self.free]
        )

    def residuals(self, x):
        """(k,) over their noise; WORSE than the last ones where x has no run."""
        try:
            found = self._found(x)
        except (NotFollowed, NotConverged, SceneError):
            if self.last is None:
                raise
            return WORSE * (np.abs(self.last) + 1.0)
        self.last = found[0]
        return found[0]

    def jacobian(self, x):
        """(k, n)."""
        return self._found(x)[1]

    def _found(self, x):
        if self.at is None or not np.array_equal(x, self.at):
            self.known = self._told(x)
            self.at = x.copy()
        return self.known

    def run(self, x):
        """The Skeleton of the parameters x, followed if possible."""
        values = {name: float(value) for name, value in zip(self.free, x, strict=True) if name not in AXES}
        scene = self.scene.changed(**values)
        self.runs += 1
        try:
            if self.skeleton is None:
                raise NotFollowed("nothing to follow yet")
            found = follow(self.skeleton, scene)
        except NotFollowed:
            found = skeleton_of(scene)
        self.skeleton = found
        return found

    def _unit(self):
        """What F_bar and L_bar are in those measured: their unit w E changes with the parameters, N/m does not."""
        scene = self.skeleton.scene
        return scene.width * scene.E / self.measured.unit if self.measured.unit else 1.0

    def _told(self, x):
        found = sensitivities(self.run(x), self.physical)
        axes = AXES | {name: float(value) for name, value in zip(self.free, x, strict=True) if name in AXES}
        scale, U_x = axes["scale_U"], (self.measured.U_x - axes["offset_U"]) / axes["scale_U"]
        predicted = Predicted(found, self.measured.seen / axes["scale_F"] / self._unit(), float(U_x[-1]))
        values, slopes, by = predicted.curve(U_x[self.kept], self.branch[self.kept], self.physical)
        loads, loads_by, branches, moved = predicted.slips(self.ends.shape[1], self.physical)
        residuals, rows = [], []
        for k, name in enumerate(NAMES):
            if name not in self.measured.values:
                continue
            gain = (axes["scale_F"] if name == "F_bar" else 1.0) * (self._unit() if name != "A_bar" else 1.0)
            off = axes["offset_F"] if name == "F_bar" else 0.0
            own = dict(zip(self.physical, gain * by[:, k], strict=True))
            for wide in {"E", "width"} & set(own) if self.measured.unit and name != "A_bar" else ():
                own[wide] = own[wide] + gain * values[k] / getattr(self.skeleton.scene, wide)
            own |= {"scale_U": -gain * slopes[k] * U_x[self.kept] / scale, "offset_U": -gain * slopes[k] / scale}
            if name == "F_bar":
                own |= {"scale_F": gain / axes["scale_F"] * values[k], "offset_F": np.ones(values[k].size)}
            noise = self.measured.noise[name]
            residuals.append((gain * values[k] + off - self.measured.values[name][self.kept]) / noise)
            rows.append(_columns(own, self.free, values[k].size) / noise)
        if len(predicted.between) == 1:  # not yet, or not quite: its points say how far off it is
            residuals.append(np.zeros(self.ends.shape[1]))
            rows.append(np.zeros((self.ends.shape[1], len(self.free))))
            return np.concatenate(residuals), np.vstack(rows)
        if loads.size < self.ends.shape[1]:
            raise NotFollowed(f"it slips {loads.size} times, what was measured {self.ends.shape[1]} times")
        own = dict(zip(self.physical, scale * loads_by, strict=True)) | {
            "scale_U": loads,
            "offset_U": np.ones(loads.size),
        }
        places, errors = self._places(branches, scale * moved)
        residuals.append((scale * loads + axes["offset_U"] - places) / errors)
        rows.append(_columns(own, self.free, loads.size) / errors[:, None])
        return np.concatenate(residuals), np.vstack(rows)

    def _places(self, branches, moved):
        """(where slips are (n,) nm, their errors (n,) nm), of the branches (n,) they end, moved on (n,) nm.

        Slips at a known distance of each other have one place, and all their intervals hold it.
        """
        places, errors = self.ends.mean(axis=0), PLACE * np.ptp(self.ends, axis=0)
        for branch in np.unique(branches) if not PERIOD & set(self.free) else ():
            mine = branches == branch
            low, high = (self.ends[0, mine] - moved[mine]).max(), (self.ends[1, mine] - moved[mine]).min()
            if low < high:
                places[mine] = 0.5 * (low + high) + moved[mine]
                errors[mine] = PLACE * (high - low) * mine.sum() ** 0.5
        return places, errors


def _columns(own, free, count):
    """(count, n) of {name: (count,)}; zero for what has no part in it."""
    return np.array([own.get(name, np.zeros(count)) for name in free]).reshape(len(free), count).T
