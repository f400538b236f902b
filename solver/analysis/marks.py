"""Values of a parameter at which the behaviour changes: no load, the jump into contact, the end of slips."""

from dataclasses import replace

import numpy as np

from ..continuation.trace import STENCIL, Branch, Trace
from ..following.follow import follow
from ..following.moved import NotFollowed
from ..following.skeleton import Skeleton
from ..scene import Scene, SceneError
from .boundary import boundary
from .friction_laws import critical_modulus, softening

BEGINNING = 0.1  # shear, in delta_t, that the Skeleton keeps: it needs some
ENDS = {"E": (3000.0, 10.0), "phi_ratio": (0.002, 2.0)}  # ends of the range that is searched, the smoother first
LABELS = {"E": "slides smoothly", "phi_ratio": "slips above"}  # behaviour above the mark


def of_skeleton(skeleton: Skeleton, name: str) -> tuple[tuple[float, str], ...]:
    """Marks ((value, label), ...) of parameter `name`: delta_bar, phi_ratio or E, found from the Skeleton."""
    if name == "delta_bar":
        marks = (_no_load(skeleton), "no load"), (skeleton.jumps_in, "jumps in")
        return tuple((value, label) for value, label in marks if value is not None and -1.0 <= value <= 1.0)
    border = boundary(skeleton, name, (min(ENDS[name]), max(ENDS[name]))).value
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
