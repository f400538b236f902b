"""A curve and its slips as the states of a run tell them, with derivatives, at measured places on measured branches."""

from functools import cached_property

import numpy as np

from ..following.branch import even_weights, place

END = 1e-3  # of t from 0 and 1: nearer, dF/dU is 0/0, or infinite; F changes by its square there
PART = 0.9  # of the largest drop: where all are as small as that, they may still grow to what was measured
BESIDE = 1e-5  # of t, over which dF/dt is told


class Predicted:
    """Of Sensitivities, for what was measured on branch number `branch` (k,) of the run, counted from 0 at slips seen.

    A slip is seen where F_bar drops by more than `seen`, or by some part of the largest drop of a run on the way. What was measured between two of them lies on the branch that
    the run is on at that U_x, but between these slips; a branch that ends before U_x goes on with its last value: what
    is predicted is continuous in the parameters. In a run without slips to be seen only U_x counts. reach: the largest
    U_x, nm.
    """

    def __init__(self, found, seen=0.0, reach=0.0):
        self.found, self.skeleton, self.seen, self.reach = found, found.skeleton, seen, reach

    def branch_of(self, number):
        """(index of the BranchSensitivity, periods it has moved on by) of the branch number `number` of the run."""
        home, count = self.skeleton.home, len(self.found.branches)
        if number < count or not self.skeleton.sites:
            return min(number, count - 1), 0
        return home + (number - home) % (count - home), (number - home) // (count - home)

    def drop(self, number):
        """What F_bar drops by at the end of the branch number `number`; 0 where it ends in no slip."""
        (index, turns), (after, later) = self.branch_of(number), self.branch_of(number + 1)
        one = self.found.branches[index]
        if one.branch.fold is None or (index, turns) == (after, later):
            return 0.0
        return one.values[1, -1] - self.found.branches[after].values[1, 0]

    def end(self, number):
        """Where the branch number `number` ends, nm."""
        index, turns = self.branch_of(number)
        return self.found.branches[index].values[0, -1] + turns * (self.skeleton.period or 0.0)

    @cached_property
    def between(self):
        """[numbers of branches] up to the first slip seen, from there to the next, ..., to twice the reach."""
        largest = max(self.drop(number) for number in range(len(self.found.branches) + 1))
        seen, lists, number = min(self.seen, PART * largest), [[]], 0
        while True:
            lists[-1].append(number)
            if self.end(number) > 2.0 * self.reach or self.branch_of(number) == self.branch_of(number + 1):
                return lists
            if self.drop(number) > seen:
                lists.append([])
            number += 1

    def curve(self, U_x, branch, names):
        """(values (3, k), slopes by U_x (3, k), derivatives (names, 3, k)) at loads U_x (k,), nm."""
        values, slopes = np.empty((3, U_x.size)), np.empty((3, U_x.size))
        by, number_of = np.empty((len(names), 3, U_x.size)), np.empty(U_x.size, int)
        branch = np.minimum(branch, len(self.between) - 1)
        for k in np.unique(branch):
            numbers = np.array(self.between[k])
            ends = [self.end(number) for number in numbers[:-1]]
            number_of[branch == k] = numbers[np.searchsorted(ends, U_x[branch == k])]
        for number in np.unique(number_of):
            mine, (index, turns) = number_of == number, self.branch_of(int(number))
            one = self.found.branches[index]
            if one.branch.periodic:
                turns = np.floor(U_x[mine] / self.skeleton.period)
            loads = U_x[mine] - turns * (self.skeleton.period or 0.0)
            read = _to_a_fold if one.branch.fold else _without_end
            values[:, mine], slopes[:, mine], by[:, :, mine] = read(one, loads, names)
            if "width" in names:  # the period moves what was moved on
                k = names.index("width")
                by[k][:, mine] -= slopes[:, mine] * turns * self.skeleton.sites / self.skeleton.scene.nodes
        return values, slopes, by

    def slips(self, count, names):
        """(U_x (n,), derivatives (names, n), branch (n,), moved (n,)) of the first slips seen, at most `count`.

        A slip of a branch that repeats itself lies `moved` nm after the first one of that branch.
        """
        loads, by, branches, moved_on = [], [], [], []
        for numbers in self.between[:-1][:count]:
            index, turns = self.branch_of(numbers[-1])
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
