"""The load path as a sequence of load steps, each a straight line of the rigid top walked in even increments.

Along a load step the load only ever increases: retracting the punch is the step with direction (0, +1), sliding back
the one with direction (-1, 0). Every step begins with the state that the one before ended with, as its increment 0.
"""

from dataclasses import dataclass, replace
from math import inf

from .loading import Loading, approach, shear

HIGHEST = 5.0  # delta_0 above first touch: a punch that still adheres there is not retracted farther


@dataclass(frozen=True)
class LoadStep:
    """One stage: increment k of 0 .. increments is at load min(end, start + k increment), nm."""

    stage: str
    loading: Loading
    start: float
    increment: float  # nm
    increments: int
    end: float = inf
    held: bool = False  # the normal load is held: delta follows, and the loading's U_z means nothing
    until_free: bool = False  # goes on beyond its end, to HIGHEST at most, while the surfaces still hold together

    def at(self, k):
        """Load of increment k, nm."""
        return min(self.end, k * self.increment + self.start)


def load_steps_of(scene):
    """The LoadSteps of a scene's path, in order."""
    first = LoadStep(
        "approach", approach(), -scene.delta_0, scene.du_z * scene.delta_n, scene.approach_increments, scene.delta
    )
    return first, *_FOLLOWING[scene.path](scene)


def _shear(scene):
    return (sideways(scene, "shear", 1.0, 0.0, scene.shear_increments),)


def _unload(scene):
    """Adhesion hysteresis: up to where the approach began, or until the punch is free, and down again."""
    up = LoadStep("unload", Loading("-delta", (0.0, 0.0), (0.0, 1.0)), -scene.delta, scene.du_z * scene.delta_n,
             scene.approach_increments, scene.delta_0, until_free=True)  # fmt: skip
    down = LoadStep(
        "reload", approach(), -scene.delta_0, scene.du_z * scene.delta_n, scene.approach_increments, scene.delta
    )
    return up, down


def _loop(scene):
    """Friction loop: to the largest U_x, back to its negative and forth again."""
    n = scene.shear_increments
    far = scene.shear_at(n)
    return (
        sideways(scene, "shear", 1.0, 0.0, n),
        sideways(scene, "back", -1.0, -far, 2 * n),
        sideways(scene, "forth", 1.0, -far, 2 * n),
    )


_FOLLOWING = {"shear": _shear, "unload": _unload, "loop": _loop}


def sideways(scene, stage, sign, start, increments):
    """The LoadStep at the scene's indentation, or load, along sign U_x from `start` (nm)."""
    held = scene.hold == "load"
    if held:
        loading = Loading("U_x" if sign > 0.0 else "-U_x", (0.0, 0.0), (sign, 0.0))
    else:
        loading = shear(scene) if sign > 0.0 else Loading("-U_x", (0.0, -scene.delta), (sign, 0.0))
    return LoadStep(stage, loading, start, scene.du_x * scene.delta_t, increments, held=held)


def stretched(load_steps, step):
    """The same load steps, `step` an increment longer, and the one after it from there on."""
    place, more = load_steps.index(step), step.increment
    longer = replace(step, increments=step.increments + 1, end=step.end + more)
    back = load_steps[place + 1]
    back = replace(back, start=back.start - more, increments=back.increments + 1)
    return *load_steps[:place], longer, back, *load_steps[place + 2 :]
