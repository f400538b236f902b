"""The load path as a sequence of load steps, each a straight line of the rigid top walked in even increments.

Along a load step the load only ever increases: retracting the punch is the step with direction (0, +1), sliding back
the one with direction (-1, 0). Every step begins with the state that the one before ended with, as its increment 0.
"""

from dataclasses import dataclass, replace
from math import copysign, hypot, inf

from ..mechanics.equilibrium import Equilibrium
from .frame import moving
from .loading import Loading, sideways, vertical

# delta_0 above first touch, where a retraction ends even if the punch still adheres: a punch on E = 0.5 GPa detaches at
# 3.7 (phi_n 1, 128 nodes), softer layers would be stretched far beyond their linear range
HIGHEST = 5.0


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
    until_free: bool = False  # goes on beyond its end while the surfaces still adhere, to HIGHEST at most

    def at(self, k) -> float:
        """Load of increment k, nm."""
        return min(self.end, k * self.increment + self.start)

    def problem(self, contact, pressure) -> Equilibrium:
        """The Contact driven along this step; pressure: the mean normal traction to hold, GPa, or None."""
        return Equilibrium(contact, self.loading, pressure if self.held else None)


def load_steps_of(scene) -> tuple[LoadStep, ...]:
    """The LoadSteps of a scene's path, in order."""
    if scene.legs:
        return tuple(_straight(number, leg) for number, leg in enumerate(scene.legs, 1))
    return _lowering(scene, "approach"), *_FOLLOWING[scene.path](scene)


def abscissa(scene) -> str:
    """What curves are drawn along: "U_x", "delta" where the top only moves up and down, or "path" for points."""
    return "path" if scene.legs else "delta" if lifts(scene) else "U_x"


def place(scene, frame) -> float:
    """Where a Frame is along the `abscissa`, nm."""
    return position(scene, frame) if scene.legs else getattr(frame, abscissa(scene))


def position(scene, frame, slip=None) -> float:
    """How far along its path a Frame is, or a SlipEvent in it, nm from the end of the approach."""
    far = 0.0
    for step in load_steps_of(scene):
        if step.stage == frame.stage:
            break
        far += step.end - step.start if step.stage != "approach" else 0.0
    far += step.loading.load_of(frame) - (step.start if step.stage != "approach" else step.end)
    if slip is None:
        return far
    name = moving(frame.stage)
    return far - abs((getattr(frame, name) - slip.load) / step.loading.direction[name == "delta"])


def lifts(scene) -> bool:
    """Whether after the approach the top moves up and down only, so that curves are drawn along delta, not U_x."""
    return not any(step.loading.direction[0] for step in load_steps_of(scene))


def _straight(number, leg):
    """The LoadStep of a Leg; the first one is the approach."""
    (x, delta), (x_end, delta_end), du_x, du_z = leg
    if not leg.across:
        sign = copysign(1.0, leg.down)
        stage, loading = ("reload" if sign > 0.0 else "unload"), vertical(sign, x)
        start, end, increment = sign * delta, sign * delta_end, du_z
    elif not leg.down:
        sign = copysign(1.0, leg.across)
        stage, loading = ("shear" if sign > 0.0 else "back"), sideways(sign, -delta)
        start, end, increment = sign * x, sign * x_end, du_x
    else:
        start, end = 0.0, hypot(leg.across, leg.down)
        stage, loading = "move", Loading("path", (x, -delta), (leg.across / end, -leg.down / end))
        increment = end / leg.increments
    return LoadStep("approach" if number == 1 else f"{number} {stage}", loading, start, increment, leg.increments, end)


def _lowering(scene, stage):
    """From delta_0 above first touch to the scene's indentation."""
    du_z = scene.du_z * scene.delta_n
    return LoadStep(stage, vertical(1.0), -scene.delta_0, du_z, scene.approach_increments, scene.delta)


def _shear(scene):
    return (_sliding(scene, "shear", 1.0, 0.0, scene.shear_increments),)


def _unload(scene):
    """Adhesion hysteresis: up to where the approach began, or until the punch is free, and down again."""
    du_z, n = scene.du_z * scene.delta_n, scene.approach_increments
    up = LoadStep("unload", vertical(-1.0), -scene.delta, du_z, n, scene.delta_0, until_free=True)
    return up, _lowering(scene, "reload")


def _loop(scene):
    """Friction loop: to the largest U_x, back to its negative and forth again."""
    n = scene.shear_increments
    far = scene.shear_at(n)
    return (
        _sliding(scene, "shear", 1.0, 0.0, n),
        _sliding(scene, "back", -1.0, -far, 2 * n),
        _sliding(scene, "forth", 1.0, -far, 2 * n),
    )


_FOLLOWING = {"shear": _shear, "unload": _unload, "loop": _loop}


def _sliding(scene, stage, sign, start, increments):
    """Along sign U_x from `start` (nm), at the scene's indentation or held load."""
    held = scene.hold == "load"
    loading = sideways(sign, 0.0 if held else -scene.delta)
    return LoadStep(stage, loading, start, scene.du_x * scene.delta_t, increments, held=held)


def stretched(load_steps, step) -> tuple[LoadStep, ...]:
    """The load steps with `step` one increment longer; the one after it begins where that ends."""
    place, more = load_steps.index(step), step.increment
    longer = replace(step, increments=step.increments + 1, end=step.end + more)
    back = load_steps[place + 1]
    back = replace(back, start=back.start - more, increments=back.increments + 1)
    return *load_steps[:place], longer, back, *load_steps[place + 2 :]
