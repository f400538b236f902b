"""A curve and its slips as the states of a run tell them, with derivatives, at measured places on measured branches."""

from functools import cached_property

import numpy as np

from ..following.branch import even_weights, place
from .sensitivities import passed

END = 1e-3  # of t from 0 and 1: nearer, dF/dU is 0/0, or infinite; F changes by its square there
PART = 0.9  # of the largest drop: where all are as small as that, they may still grow to what was measured
BESIDE = 1e-5  # of t, over which dF/dt is told


class Predicted:
    """Of Sensitivities, for what was measured on branch number `branch` (k,) of the run, counted from 0 at slips seen.

    A slip is seen where F_bar drops by more than `seen`, or by about as much as at its largest drop. What was measured
    between two of them lies on the branch that the run is on at that U_x, but between these slips; a branch that ends
    before U_x goes on with its last value: what is predicted is continuous in the parameters. In a run without slips
    to be seen only U_x counts. reach: the largest U_x, nm.
    """

    def __init__(self, found, seen, reach):
        self.found, self.skeleton, self.seen, self.reach = found, found.skeleton, seen, reach

    def _drop(self, index):
        """What F_bar drops by where a branch ends; 0 where it ends in no slip."""
        branches, one = self.found.branches, self.found.branches[index]
        last = index + 1 == len(branches)
        if one.branch.fold is None or (last and not self.skeleton.sites):
            return 0.0
        return one.values[1, -1] - branches[self.skeleton.home if last else index + 1].values[1, 0]

    def _end(self, index, turns):
        """Where a branch ends that has moved on by so many periods, nm."""
        return self.found.branches[index].values[0, -1] + turns * (self.skeleton.period or 0.0)

    @cached_property
    def between(self):
        """[(index, turns)] of branches, as `passed`: up to the first slip seen, to the next ..., to twice reach."""
        drops, lists = [self._drop(index) for index in range(len(self.found.branches))], [[]]
        seen = min(self.seen, PART * max(drops))
        for index, turns in passed(self.skeleton):
            lists[-1].append((index, turns))
            if self._end(index, turns) > 2.0 * self.reach:
                break
            if drops[index] > seen:
                lists.append([])
        return lists

    def curve(self, U_x, branch, names):
        """(values (3, k), slopes by U_x (3, k), derivatives (names, 3, k)) at loads U_x (k,), nm."""
        values, slopes = np.empty((3, U_x.size)), np.empty((3, U_x.size))
        by = np.empty((len(names), 3, U_x.size))
        branch = np.minimum(branch, len(self.between) - 1)
        for k, some in enumerate(self.between):
            ends = [self._end(*one) for one in some[:-1]]
            here = np.where(branch == k, np.searchsorted(ends, U_x), -1)
            for j in np.unique(here[here >= 0]):
                mine, (index, turns) = here == j, some[j]
                one = self.found.branches[index]
                if one.branch.periodic:
                    turns = np.floor(U_x[mine] / self.skeleton.period)
                loads = U_x[mine] - turns * (self.skeleton.period or 0.0)
                read = _to_a_fold if one.branch.fold else _without_end
                values[:, mine], slopes[:, mine], by[:, :, mine] = read(one, loads, names)
                if "width" in names:  # the period moves what was moved on
                    moved = turns * self.skeleton.sites / self.skeleton.scene.nodes
                    by[names.index("width")][:, mine] -= slopes[:, mine] * moved
        return values, slopes, by

    def slips(self, count, names):
        """(U_x (n,), derivatives (names, n), branch (n,), moved (n,)) of the first slips seen, at most `count`.

        A slip of a branch that repeats itself lies `moved` nm after the first one of that branch.
        """
        loads, by, branches, moved_on = [], [], [], []
        for *_, (index, turns) in self.between[:-1][:count]:
            one = self.found.branches[index]
            sites = turns * self.skeleton.sites
            loads.append(one.values[0, -1] + sites * self.skeleton.scene.spacing)
            moved = {"width": sites / self.skeleton.scene.nodes}
            by.append([one.by[name][0, -1] + moved.get(name, 0.0) for name in names])
            branches.append(index)
            moved_on.append(sites * self.skeleton.scene.spacing)
        return np.array(loads), np.array(by).reshape(len(loads), len(names)).T, np.array(branches), np.array(moved_on)


def _without_end(one, loads, names):
    weights = one.branch.weights(loads).T
    fixed = [one.at_fixed_load(name) @ weights for name in names]
    return one.values[1:] @ weights, one.slope @ weights, np.array(fixed).reshape(len(names), 3, loads.size)


def _to_a_fold(one, loads, names):
    start, end, n = one.values[0, 0], one.values[0, -1], one.branch.intervals
    t = place(start, end, loads)
    weights = even_weights(t, n).T
    inside = np.clip(t, END, 1.0 - END)
    change = even_weights(inside + BESIDE, n) - even_weights(inside - BESIDE, n)
    speed = 0.5 * np.pi * (end - start) * np.sin(np.pi * inside)
    slopes = one.values[1:] @ change.T / (2.0 * BESIDE) / speed
    slopes[:, (loads < start) | (loads > end)] = 0.0
    moved = np.array([one.by[name] @ weights for name in names]).reshape(len(names), 4, loads.size)
    return one.values[1:] @ weights, slopes, moved[:, 1:] - slopes * moved[:, :1]
