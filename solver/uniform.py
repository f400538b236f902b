"""Flat on flat: all nodes move alike, so two numbers u = (u_x, u_z) are the whole state (Prandtl-Tomlinson).

Branches are followed by Newton steps, halving the step of the load down to round-off where a branch ends; from there
the overdamped flow u' = U + C T(u) - u leads to the next. A branch ends at a fold, det(I - C dT/du) = 0, or, as NP1
has no potential and dT/du no symmetry, in flutter: under compression a pair of complex modes starts to grow (Hopf).
"""

import numpy as np
from numba import njit

from . import np1
from .contact import Contact
from .state import Increment, NotConverged, Slip, State

LONGEST = 0.1  # of min(delta_n, delta_t), beyond the step of the load: largest change of u in one step
FINEST = 1e-14  # of the increment: step of the load at which a branch has ended
NUDGE = 0.01  # of min(delta_n, delta_t): how far beyond the end of the branch the flow starts
STUCK = 1e-9  # of min(delta_n, delta_t): least advance of the load from one slip to the next
TURN = 0.1  # radians: longest explicit step of the flow where it turns about a focus
FORWARD = 0.3  # step times growth rate of an unstable mode; from 1 on, the step runs backwards
SLOW = 0.01  # of the peak speed: below it, Newton steps finish a slip
FLOW_ERROR = 1e-2  # of min(delta_n, delta_t), in one step of the flow
BUDGET = 100_000  # force evaluations of one slip


class Uniform:
    """Advances States of a flat scene, (2, 1) in size, under the contract of `fast.Fast`."""

    def __init__(self, scene, first, size, leave_out):
        self.scene, self.contact = scene, Contact(scene, 0, 1, uniform=True)
        unit = min(scene.delta_n, scene.delta_t)
        self._numbers = np.array([*self.contact.compliance.modes, unit, scene.tolerance])
        self._r = np.empty((2, 1))

    def undeformed(self, loading, load):
        """The State of a layer that nothing acts on."""
        u = self.contact.undeformed(loading.at(load))
        return State(load, u, self.contact.within_window(u))

    def increment(self, state, loading, target):
        """The equilibrium at load `target` that is reached from `state`; raises NotConverged."""
        u, slips, load = state.u.copy(), [], state.load
        path = np.array([*loading.base, *loading.direction])

        def solve(active):
            nonlocal load
            ended = False
            while not ended:
                load, ended = self._until_fold(u, active, path, load, target, slips, loading.name)
            return True

        active = self.contact.settle(solve, u, state.active)
        residual = self.contact.residual(u, active, loading.at(target), self._r)
        return Increment(State(target, u, active), self.contact.traction(), residual, tuple(slips))

    def _until_fold(self, u, active, path, load, target, slips, name):
        """(load, whether it is the target): follow the branch and, if it ends before, the slip at its end."""
        contact = self.contact
        law = contact.profile, active, contact.law, contact.work
        load, folded, count = _follow(u, load, target, path, *law, self._numbers)
        contact.evaluations += count
        if folded:
            self._check_advance(load, slips, name)
            traction = np.empty((2, 1))
            np1.tractions(u, *law, traction, 1)
            slips.append(Slip(load, u.copy(), traction))
            rests, count = _slip(u, load, path, *law, self._numbers)
            contact.evaluations += count
            if not rests:
                raise NotConverged(
                    f"Not converged at {name} = {load:.6g} nm: still moving after {BUDGET} force evaluations of the"
                    " slip; try a smaller du_x or du_z, or a larger tolerance, or, if it flutters, a smaller delta_bar"
                )
        return load, not folded

    def _check_advance(self, load, slips, name):
        """Raises NotConverged where the branch ends at the load of the slip that led to it."""
        if slips and load - slips[-1].load <= STUCK * self._numbers[2]:
            raise NotConverged(
                f"Not converged at {name} = {load:.6g} nm: the branch that a slip led to ends at once; try another"
                " du_x or du_z, or a larger tolerance"
            )


@njit(cache=True, nogil=True)
def _evaluate(u, load, path, profile, active, law, work, numbers, r, a):
    """r = U + C T(u) - u and a = I - C dT/du, row by row; returns the largest |r|."""
    t = np.empty((4, 1))
    np1.tangents(u, profile, active, law, work, t)
    a[0], a[1] = 1.0 - numbers[0] * t[0, 0], -numbers[0] * t[1, 0]
    a[2], a[3] = -numbers[1] * t[2, 0], 1.0 - numbers[1] * t[3, 0]
    t_x, t_z = np1.traction_from_sums(work, 0, active[0], law)
    r[0] = path[0] + load * path[2] + numbers[0] * t_x - u[0, 0]
    r[1] = path[1] + load * path[3] + numbers[1] * t_z - u[1, 0]
    return max(abs(r[0]), abs(r[1]))


@njit(cache=True, nogil=True)
def _solved(a, x, z):
    det = a[0] * a[3] - a[1] * a[2]
    return (a[3] * x - a[1] * z) / det, (a[0] * z - a[2] * x) / det


@njit(cache=True, nogil=True)
def _newton(u, load, path, profile, active, law, work, numbers, longest):
    """(whether u, in place, came to a stable rest at most `longest` away, evaluations)."""
    r, a = np.empty(2), np.empty(4)
    x, z = u[0, 0], u[1, 0]
    worst = np.inf
    for k in range(20):
        now = _evaluate(u, load, path, profile, active, law, work, numbers, r, a)
        stable = a[0] * a[3] - a[1] * a[2] > 0.0 and a[0] + a[3] > 0.0
        if not stable or max(abs(u[0, 0] - x), abs(u[1, 0] - z)) > longest:
            return False, k + 1
        if now <= numbers[3] and (now >= 0.5 * worst or now < 1e-14):  # as far down as round-off allows
            return True, k + 1
        worst = now
        dx, dz = _solved(a, r[0], r[1])
        u[0, 0] += dx
        u[1, 0] += dz
    return False, 20


@njit(cache=True, nogil=True)
def _follow(u, load, target, path, profile, active, law, work, numbers):
    """Follow the branch from u, in place, towards `target`: (load reached, whether it ended there, evaluations)."""
    step, count = target - load, 0
    finest = FINEST * max(abs(step), numbers[2])
    r, a, trial = np.empty(2), np.empty(4), u.copy()
    while True:
        _evaluate(u, load, path, profile, active, law, work, numbers, r, a)
        dx, dz = _solved(a, path[2] * step, path[3] * step)
        trial[0, 0], trial[1, 0] = u[0, 0] + dx, u[1, 0] + dz
        ahead = target if load + step >= target else load + step
        longest = LONGEST * numbers[2] + 2.0 * abs(step)
        near = max(abs(dx), abs(dz)) <= longest
        good, tried = False, 0
        if near:
            good, tried = _newton(trial, ahead, path, profile, active, law, work, numbers, longest)
        count += tried + 1
        if good:
            u[:], load = trial, ahead
            if load >= target:
                return load, False, count
            step *= 2.0
        else:
            step *= 0.5
            if step < finest or load + step <= load:
                return load, True, count


@njit(cache=True, nogil=True)
def _slip(u, load, path, profile, active, law, work, numbers):
    """The overdamped flow from the end u of a branch, in place, to the next rest: (whether it rests, evaluations).

    Linearly implicit Euler steps, (1/h + a) du = r, which stiff modes do not limit; an unstable one does, as the step
    would run backwards. Explicit ones where the flow spirals. It starts along the direction in which the branch was
    moving: at a fold, the null vector of a that leads away. Out of flutter, the site reached may depend on that start.
    """
    unit, end, r, a, r1, a1 = numbers[2], u.copy(), np.empty(2), np.empty(4), np.empty(2), np.empty(4)
    _evaluate(u, load, path, profile, active, law, work, numbers, r, a)
    dx, dz = _solved(a, path[2], path[3])
    size = max(abs(dx), abs(dz))
    u[0, 0] += NUDGE * unit * dx / size
    u[1, 0] += NUDGE * unit * dz / size
    trial = u.copy()
    speed = _evaluate(u, load, path, profile, active, law, work, numbers, r, a)
    peak, h, count = speed, 1e-3, 2
    while count < BUDGET:
        turn = _turn(a)
        if turn > 0.0:
            h = min(h, TURN / turn, LONGEST * unit / max(speed, 1e-300))
            now, error = _explicit(u, h, load, path, profile, active, law, work, numbers, r, trial, r1, a1), 0.0
            count += 4
        else:
            h = min(h, FORWARD / max(_growth(a), 1e-300))
            now, error = _implicit(u, h, load, path, profile, active, law, work, numbers, r, a, trial, r1, a1)
            count += 1
        if error <= FLOW_ERROR * unit:
            u[:], r[:], a[:] = trial, r1, a1
            speed, peak = now, max(peak, now)
            if speed < SLOW * peak or speed < numbers[3]:
                good, tried = _newton(trial, load, path, profile, active, law, work, numbers, LONGEST * unit)
                count += tried
                if good and np.abs(trial - end).max() > NUDGE * unit:
                    u[:] = trial
                    return True, count
        h *= min(2.0, max(0.2, 0.8 * np.sqrt(FLOW_ERROR * unit / max(error, 1e-300))))
    return False, count


@njit(cache=True, nogil=True)
def _implicit(u, h, load, path, profile, active, law, work, numbers, r, a, trial, r1, a1):
    """trial, r1, a1: a linearly implicit Euler step h of the flow from u, r, a; returns (largest |r1|, error)."""
    m = np.array([a[0] + 1.0 / h, a[1], a[2], a[3] + 1.0 / h])
    dx, dz = _solved(m, r[0], r[1])
    trial[0, 0], trial[1, 0] = u[0, 0] + dx, u[1, 0] + dz
    now = _evaluate(trial, load, path, profile, active, law, work, numbers, r1, a1)
    ex, ez = _solved(m, r1[0] - dx / h, r1[1] - dz / h)  # what the tangent did not foresee
    return now, max(abs(ex), abs(ez))


@njit(cache=True, nogil=True)
def _explicit(u, h, load, path, profile, active, law, work, numbers, r, trial, r1, a1):
    """trial, r1, a1: a classical Runge-Kutta step h of the flow from u, r; returns the largest |r1|."""
    sum_x, sum_z = r[0], r[1]
    r1[:] = r
    for part, weight in ((0.5, 2.0), (0.5, 2.0), (1.0, 1.0)):
        trial[0, 0], trial[1, 0] = u[0, 0] + part * h * r1[0], u[1, 0] + part * h * r1[1]
        _evaluate(trial, load, path, profile, active, law, work, numbers, r1, a1)
        sum_x += weight * r1[0]
        sum_z += weight * r1[1]
    trial[0, 0], trial[1, 0] = u[0, 0] + h / 6.0 * sum_x, u[1, 0] + h / 6.0 * sum_z
    return _evaluate(trial, load, path, profile, active, law, work, numbers, r1, a1)


@njit(cache=True, nogil=True)
def _turn(a):
    """|eigenvalue| of u' = -a u where it turns faster than it grows or decays, else 0: implicit steps would damp it."""
    half, det = 0.5 * (a[0] + a[3]), a[0] * a[3] - a[1] * a[2]
    return np.sqrt(det) if det > 2.0 * half * half else 0.0


@njit(cache=True, nogil=True)
def _growth(a):
    """Growth rate of the fastest growing mode of u' = -a u, or 0 if none grows."""
    half, det = 0.5 * (a[0] + a[3]), a[0] * a[3] - a[1] * a[2]
    root = half * half - det
    return max(0.0, -half + np.sqrt(root)) if root > 0.0 else max(0.0, -half)
