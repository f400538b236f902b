"""Values of a parameter at which the behaviour changes: no load, the jump into contact, the end of slips."""

from dataclasses import replace

import numpy as np

from ..continuation.trace import STENCIL, Branch, Trace
from ..following.follow import follow
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton
from ..scene import Scene, SceneError
from .friction_laws import critical_modulus, softening

BEGINNING = 0.1  # shear, in delta_t, that the Skeleton keeps: it needs some
ENDS = {"E": (3000.0, 10.0), "phi_ratio": (0.002, 2.0)}  # ends of the range that is searched, the smoother first
LABELS = {"E": "slides smoothly", "phi_ratio": "slips above"}  # behaviour above the mark
CLOSE = 0.1  # relative distance: the prediction is accepted if it repeats this near, or following stops
ENOUGH = 8000  # force evaluations of one search for the end of slips


def of_skeleton(skeleton: Skeleton, name: str) -> tuple[tuple[float, str], ...]:
    """Marks ((value, label), ...) of parameter `name`: delta_bar, phi_ratio or E. Follows the Skeleton to them."""
    if name == "delta_bar":
        marks = (_no_load(skeleton), "no load"), (skeleton.jumps_in, "jumps in")
        return tuple((value, label) for value, label in marks if value is not None and -1.0 <= value <= 1.0)
    border = _border(skeleton, name)
    return () if border is None else ((border, LABELS[name]),)


def of_flat(scene: Scene, name: str) -> tuple[tuple[float, str], ...]:
    """Marks of a flat, exactly: stick-slip ends where the interface softens by less than k."""
    if scene.phi_ratio == 0.0:  # nothing resists shear
        return ()
    value = critical_modulus(scene)
    if name == "phi_ratio":
        value = scene.phi_ratio / (softening(scene) * scene.shear_compliance)
    return ((value, LABELS[name]),) if min(ENDS[name]) <= value <= max(ENDS[name]) else ()


def _no_load(skeleton):
    """delta_bar at which the contact carries no load before shear; None if following ends before it."""
    here, loads = _at_rest(skeleton), []
    for _ in range(20):
        loads.append((here.scene.delta_bar, float(here.curve([0.0])[1][0])))
        at, L = loads[-1]
        if abs(L) <= 1e-3 * max(abs(load) for _, load in loads):
            return at
        following = at - 0.2 * np.sign(L)  # so far, following works
        drawn, pressed = ([x for x, load in loads if load * sign > 0.0] for sign in (-1.0, 1.0))
        if drawn and pressed:
            (x0, y0), low, high = loads[-2], max(drawn), min(pressed)
            following = at - L * (at - x0) / (L - y0) if y0 != L else low
            following = following if low < following < high else 0.5 * (low + high)
        try:
            here = follow(here, here.scene.changed(delta_bar=float(following)))
        except (NotFollowed, SceneError):
            return None
    return None


def _at_rest(skeleton):
    """Return the Skeleton of the same scene with little shear: enough to compute the load."""
    reach = BEGINNING * skeleton.scene.delta_t
    scene = skeleton.scene.changed(u_x_max=reach, du_x=BEGINNING)
    loads = np.linspace(0.0, reach, STENCIL + 1)
    v = skeleton.unknowns(loads)
    trace = Trace((Branch.of(loads, v),), jumps=skeleton.trace.jumps)
    return replace(skeleton, scene=scene, trace=trace)


def _border(skeleton, name):
    """Value of a slider at which the slips of a Skeleton end; None where following ends before it.

    Smooth sliding gives no value: its states are solved at given loads, and change to states beyond a slip.
    """
    if not _slips(skeleton):
        return None
    end, way = np.log(ENDS[name][0]), 1.0 if ENDS[name][0] > ENDS[name][1] else -1.0
    here, at, left = skeleton, np.log(getattr(skeleton.scene, name)), _slip_squared(skeleton)
    ahead, stride, spent = np.inf, np.log(1.25), 0  # predicted distance and step, of the logarithm
    # from steps beyond 0.6 of the way to the predicted end slips get lost; steps below 3 % take too long
    while spent < ENOUGH and (step := min(stride, 0.6 * ahead, way * (end - at))) > 0.03:
        try:
            there = follow(here, here.scene.changed(**{name: float(np.exp(at + way * step))}))
        except (NotFollowed, SceneError):
            there = None
        if there is None or not _slips(there):
            if ahead < CLOSE:
                break
            stride = 0.5 * step
            continue
        here = there
        spent, at = spent + here.evaluations, at + way * step
        before, left, expected = left, _slip_squared(here), ahead - step
        ahead = left * step / (before - left) if left < before else np.inf
        if ahead < CLOSE and abs(ahead - expected) < CLOSE:
            break
    return float(np.exp(at + way * ahead)) if ahead < min(CLOSE, way * (end - at)) else None


def _slips(skeleton):
    """Whether the Skeleton has slips, and ends at the fold of one."""
    return bool(skeleton.period) and skeleton.branches[-1].slip is not None


def _slip_squared(skeleton):
    """Square of the largest displacement of a node in a slip, nm^2.

    Where slips end, fold and landing meet, as for load = p x - x^3: the square vanishes in proportion to p.
    """
    ends = np.array([branch.end for branch in skeleton.branches if branch.slip])
    return float(np.abs(skeleton.unknowns(np.nextafter(ends, np.inf)) - skeleton.unknowns(ends)).max() ** 2)
