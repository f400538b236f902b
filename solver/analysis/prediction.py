"""The curve and the slips that a run predicts, with derivatives, assigned to the segments of a measured curve."""

from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..run.frame import contact_area
from .sensitivities import Sensitivities

Floats = NDArray[np.float64]
BESIDE = 5e-4  # of t, for a derivative by it: the error is the square, and round-off 1e-12
# Slips are listed up to so many times the measured range, as offset_U and parameters move them into and out of it. A
# trial that needs more is rejected: it has too few slips.
AHEAD = 2.0


class Curve(NamedTuple):
    """values (3, k) of F_bar, L_bar, A_bar; slopes (3, k) by U_x, per nm; by (names, 3, k) per unit of parameters."""

    values: Floats
    slopes: Floats
    by: Floats


class Predicted:
    """The curve of a run from its Sensitivities, cut into segments at its visible slips.

    A slip is visible if F_bar drops by more than `seen`, or by more than 0.9 of its largest drop. The k-th measured
    segment is compared with the k-th predicted one, each point with the branch at its U_x. Beyond the end of a branch
    its last value counts, so that predictions are continuous in the parameters. start, reach: the measured range of
    U_x, nm.
    """

    def __init__(self, sensitivities: Sensitivities, seen: float, start: float, reach: float):
        self.branches, self.skeleton = sensitivities.branches, sensitivities.skeleton
        self.seen, self.start, self.reach = seen, start, reach

    @cached_property
    def drops(self) -> list[float]:
        """The drop of F_bar at the end of each branch; 0 without a slip there."""
        last = len(self.branches) - 1
        after = [*range(1, last + 1), self.skeleton.trace.home]
        slips = [branch.branch.slip is not None for branch in self.branches]
        slips[last] &= bool(self.skeleton.period)
        pairs = zip(self.branches, after, slips, strict=True)
        return [b.values[1, -1] - self.branches[k].values[1, 0] if slip else 0.0 for b, k, slip in pairs]

    @cached_property
    def segments(self) -> list[list[tuple[int, int]]]:
        """[(index of a branch, periods since its first pass), ...] of each segment, in order, to AHEAD of the reach."""
        # if no drop exceeds `seen`, the largest one counts as visible: it may grow in later trials
        seen = min(self.seen, 0.9 * max(self.drops)) if np.isfinite(self.seen) else np.inf
        segments: list[list[tuple[int, int]]] = [[]]
        for index, turns in self.skeleton.trace.passes():
            segments[-1].append((index, turns))
            if self._end(index, turns) > AHEAD * self.reach:
                break
            if self.drops[index] > seen:
                segments.append([])
        return segments

    @property
    def slipping(self) -> bool:
        """Whether any slip is visible."""
        return len(self.segments) > 1

    def count(self, drop: float) -> int:
        """The number of slips between start and reach with a drop of F_bar above `drop`."""
        ends = ((index, self._end(index, turns)) for index, turns in chain(*self.segments))
        return sum(self.start < end < self.reach and self.drops[index] > drop for index, end in ends)

    def _end(self, index, turns):
        """Load, nm, at which a branch ends, so many periods after its first pass."""
        return self.branches[index].values[0, -1] + turns * self.skeleton.period

    def curve(self, U_x: Floats, segment: NDArray[np.int_], names: tuple[str, ...]) -> Curve:
        """The Curve at loads U_x (k,), nm, of points in segments (k,), with derivatives by the parameters `names`."""
        shape = 3, U_x.size
        curve = Curve(np.empty(shape), np.empty(shape), np.empty((len(names), *shape)))
        segment = np.minimum(segment, len(self.segments) - 1)
        for k, passes in enumerate(self.segments):
            ends = [self._end(index, turns) for index, turns in passes[:-1]]
            position = np.where(segment == k, np.searchsorted(ends, U_x), -1)
            for j in np.unique(position[position >= 0]):
                mine = position == j
                index, turns = passes[j]
                part = self._pass(index, turns, U_x[mine], names)
                curve.values[:, mine], curve.slopes[:, mine], curve.by[:, :, mine] = part
        return curve

    def _pass(self, index, turns, U_x, names):
        """The Curve at loads on a branch, so many periods after its first pass."""
        branch, period = self.branches[index], self.skeleton.period
        if branch.branch.periodic:
            turns = np.floor(U_x / period)
        loads = U_x - turns * period
        curve = (_to_a_fold if branch.branch.slip else _without_end)(branch, loads, names)
        if branch.values[3].min() <= 0.0 < branch.values[3].max():
            self._set_area(curve, branch, loads, names)
        if "width" in names:  # it stretches the period
            stretched = turns * self.skeleton.sites / self.skeleton.scene.nodes
            curve.by[names.index("width")] -= curve.slopes * stretched
        return curve

    def _set_area(self, curve, branch, loads, names):
        """A_bar of a Curve on a branch where contact ends: it has a kink there, which no polynomial follows.

        It is that of interpolated states; derivatives are interpolated linearly, and zero without contact.
        """
        states, start, end = branch.branch, branch.branch.start, branch.branch.end
        before, after = (np.clip(loads + way * BESIDE * (end - start), start, end) for way in (-1.0, 1.0))
        area = self._area(states, loads)
        curve.values[2] = area
        change = self._area(states, after) - self._area(states, before)
        curve.slopes[2] = np.divide(change, after - before, out=np.zeros(loads.size), where=after > before)
        t, at = states.position(states.loads), states.position(loads)
        for i, name in enumerate(names):
            by = np.interp(at, t, branch.by[name][3]) - curve.slopes[2] * np.interp(at, t, branch.by[name][0])
            curve.by[i, 2] = np.where(area > 0.0, by, 0.0)

    def _area(self, states, loads):
        """A_bar (k,) at loads (k,) on a branch."""
        T = self.skeleton.tractions(states.unknowns(loads))
        return np.array([contact_area(self.skeleton.scene, T_at) for T_at in T])

    def slips(self, most: int, names: tuple[str, ...]) -> tuple[Floats, Floats, NDArray[np.int_], Floats]:
        """(loads (k,) nm, by (names, k) per unit, branch (k,), moved (k,) nm) of the first `most` visible slips.

        by: derivatives of the loads by the parameters `names`; branch: the one that ends there; moved: its shift by
        whole periods.
        """
        scene, ends = self.skeleton.scene, [passes[-1] for passes in self.segments[:-1][:most]]
        branch, turns = np.array(ends, int).reshape(-1, 2).T
        sites = turns * self.skeleton.sites
        loads = np.array([self.branches[k].values[0, -1] for k in branch]) + sites * scene.spacing
        by = np.array([[self.branches[k].by[name][0, -1] for k in branch] for name in names])
        by = by.reshape(len(names), loads.size)
        if "width" in names:
            by[names.index("width")] += sites / scene.nodes
        return loads, by, branch, sites * scene.spacing


def _without_end(branch, loads, names):
    """The Curve on a branch that ends in no fold."""
    weights = branch.branch.weights(loads).T
    by = [branch.at_fixed_load(name) @ weights for name in names]
    return Curve(branch.values[1:] @ weights, branch.slope @ weights, np.array(by).reshape(len(names), 3, loads.size))


def _to_a_fold(branch, loads, names):
    """The Curve on a branch to a fold, interpolated in t, in which it is smooth."""
    states = branch.branch
    weights, inside = states.weights(loads).T, np.clip(states.position(loads), BESIDE, 1.0 - 2.0 * BESIDE)
    before, after = (states.load_at(inside + way) for way in (-BESIDE, BESIDE))
    slopes = branch.values[1:] @ ((states.weights(after) - states.weights(before)).T / (after - before))
    slopes[:, (loads < states.start) | (loads > states.end)] = 0.0
    moved = np.array([branch.by[name] @ weights for name in names]).reshape(len(names), 4, loads.size)
    return Curve(branch.values[1:] @ weights, slopes, moved[:, 1:] - slopes * moved[:, :1])
