"""A curve and its slips as the states of a run tell them, with derivatives, at measured places on measured branches.

`found` are the Sensitivities of the run. A branch that ends before a place goes on with its last value: what is
predicted is continuous in the parameters.
"""

from itertools import islice

import numpy as np

from ..following.branch import even_weights, place
from .sensitivities import passed

END = 1e-3  # of t from 0 and 1: nearer, dF/dU is 0/0, or infinite; F changes by its square there
BESIDE = 1e-5  # of t, over which dF/dt is told


def curve(found, U_x, branch, names):
    """(values (3, k), slopes by U_x (3, k), derivatives (names, 3, k)) at loads U_x (k,), nm.

    branch (k,): number, from 0, of the branch of the run on which each was measured.
    """
    skeleton, values, slopes = found.skeleton, np.empty((3, U_x.size)), np.empty((3, U_x.size))
    by = np.empty((len(names), 3, U_x.size))
    order = list(islice(passed(skeleton), branch.max(initial=0) + 1))
    for number in np.unique(branch):
        mine, (index, turns) = branch == number, order[min(number, len(order) - 1)]
        one = found.branches[index]
        if one.branch.periodic:
            turns = np.floor(U_x[mine] / skeleton.period)
        loads = U_x[mine] - turns * (skeleton.period or 0.0)
        read = _to_a_fold if one.branch.fold else _without_end
        values[:, mine], slopes[:, mine], by[:, :, mine] = read(one, loads, names)
        if "width" in names:  # the period moves what was moved on
            by[names.index("width")][:, mine] -= slopes[:, mine] * turns * skeleton.sites / skeleton.scene.nodes
    return values, slopes, by


def slips(found, count, names):
    """(U_x (n,), derivatives (names, n), branch (n,), moved (n,)) of the first slips, at most `count`.

    A slip of a branch that repeats itself lies `moved` nm after the first one of that branch.
    """
    skeleton, loads, by, branches, moved_on = found.skeleton, [], [], [], []
    for index, turns in islice(passed(skeleton), count):
        one = found.branches[index]
        if one.branch.fold is None:
            break
        sites = turns * skeleton.sites
        loads.append(one.values[0, -1] + sites * skeleton.scene.spacing)
        moved = {"width": sites / skeleton.scene.nodes}
        by.append([one.by[name][0, -1] + moved.get(name, 0.0) for name in names])
        branches.append(index)
        moved_on.append(sites * skeleton.scene.spacing)
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
