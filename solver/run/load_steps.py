"""The path of the rigid top as a sequence of load steps, each a straight line that it walks in even increments.

Along a load step the load only ever increases: retracting the punch is the step with direction (0, +1), sliding back
the one with direction (-1, 0). Every step begins with the state that the one before ended with, as its increment 0.
"""

from dataclasses import dataclass, replace
from itertools import pairwise
from math import hypot, inf

from ..scene import Leg
from .frame import STAGES, Stage

# delta_0 above first touch, where a retraction ends even if the punch still adheres: a punch on E = 0.5 GPa detaches at
# 3.7 (phi_n 1, 128 nodes), softer layers would be stretched far beyond their linear range
HIGHEST = 5.0


@dataclass(frozen=True)
class Loading:
    """A straight path of the rigid top: (U_x, U_z) = base + load * direction, nm; the load only ever increases."""

    name: str  # of the load parameter, for messages: "delta" or "U_x", with a minus where these decrease
    base: tuple[float, float]
    direction: tuple[float, float]

    def at(self, load) -> tuple[float, float]:
        """(U_x, U_z) at that load, nm."""
        return self.base[0] + load * self.direction[0], self.base[1] + load * self.direction[1]

    def load_of(self, frame) -> float:
        """The load of a Frame on this path, nm."""
        (x, z), (along_x, along_z) = self.base, self.direction
        return along_x * (frame.U_x - x) + along_z * (-frame.delta - z)

    def coordinate(self, load) -> float:
        """U_x or delta, whichever changes along the path, at that load, nm."""
        U_x, U_z = self.at(load)
        return U_x if self.direction[0] else -U_z


def vertical(sign, U_x=0.0) -> Loading:
    """Lowering (sign 1) or raising (-1) the top at fixed U_x, nm: the load is sign delta."""
    return Loading("delta" if sign > 0.0 else "-delta", (U_x, 0.0), (0.0, -sign))


def sideways(sign, U_z) -> Loading:
    """Pulling the top along x (sign 1) or back (-1) at fixed U_z, nm: the load is sign U_x."""
    return Loading("U_x" if sign > 0.0 else "-U_x", (0.0, U_z), (sign, 0.0))


@dataclass(frozen=True)
class LoadStep:
    """One stage: increment k of 0 .. increments is at load min(end, start + k increment), nm."""

    stage: Stage
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


def load_steps_of(scene) -> tuple[LoadStep, ...]:
    """The LoadSteps of a scene's path, in order."""
    kinds, legs = [*map(_kind, scene.legs[1:]), *_STAGES.get(scene.path, ())], scene.legs or _legs(scene)
    stages = [Stage(kind, number if scene.legs else 0) for number, kind in enumerate(kinds, 2)]
    return tuple(_straight(scene, *each) for each in zip((Stage("approach"), *stages), legs, strict=True))


def abscissa(scene) -> str:
    """What curves are drawn along: "U_x", "delta" where the top only moves up and down, or "path" for points."""
    return "path" if scene.legs else "delta" if lifts(scene) else "U_x"


def place(frame) -> float:
    """Where a Frame is along the `abscissa`, nm."""
    return position(frame) if frame.scene.legs else getattr(frame, abscissa(frame.scene))


def position(frame, slip=None) -> float:
    """How far along its path a Frame is, or a SlipEvent in it, nm from the end of the approach."""
    far = 0.0
    for step in load_steps_of(frame.scene):
        if step.stage == frame.stage:
            break
        far += step.end - step.start if step.stage != "approach" else 0.0
    far += step.loading.load_of(frame) - (step.start if step.stage != "approach" else step.end)
    if slip is None:
        return far
    name = frame.stage.moves
    return far - abs((getattr(frame, name) - slip.load) / step.loading.direction[name == "delta"])


def slip_at(frame, slip) -> tuple[float, float]:
    """(U_x, delta) of the stage, nm, at a SlipEvent of a Frame; under a held load delta is that of the Frame."""
    step = next(step for step in load_steps_of(frame.scene) if step.stage == slip.stage)
    x, z = step.loading.direction
    if not x:
        return frame.U_x, slip.load
    return slip.load, frame.delta + (frame.U_x - slip.load) * z / x


def lifts(scene) -> bool:
    """Whether after the approach the top moves up and down only, so that curves are drawn along delta, not U_x."""
    return not any(step.loading.direction[0] for step in load_steps_of(scene))


# Stages after the approach. 'unload' ends where the approach began, or later, when the punch has come free
_STAGES = {"shear": ("shear",), "unload": ("unload", "reload"), "loop": ("shear", "back", "forth")}


def _legs(scene):
    """The Legs of a path that has a name."""
    begin, pressed, far = (0.0, -scene.delta_0), (0.0, scene.delta), scene.shear_at(scene.shear_increments)
    there, back = (far, scene.delta), (-far, scene.delta)
    ends = {"shear": (there,), "unload": (begin, pressed), "loop": (there, back, there)}[scene.path]
    return [Leg(*ends, *scene.steps) for ends in pairwise((begin, pressed, *ends))]


def _kind(leg):
    """The kind of the stage of a Leg between points."""
    if leg.across and leg.down:
        return "move"
    return ("shear" if leg.across > 0.0 else "back") if leg.across else "reload" if leg.down > 0.0 else "unload"


def _straight(scene, stage, leg):
    """The LoadStep of a Leg."""
    (x, delta), (x_end, delta_end), du_x, du_z = leg
    (name, sign), held = STAGES[stage.kind], False
    if stage.kind == "move":
        start, end = 0.0, hypot(leg.across, leg.down)
        loading = Loading("path", (x, -delta), (leg.across / end, -leg.down / end))
        increment = end / leg.increments
    elif name == "delta":
        start, end, increment, loading = sign * delta, sign * delta_end, du_z, vertical(sign, x)
    else:
        start, end, increment, held = sign * x, sign * x_end, du_x, scene.hold == "load"
        loading = sideways(sign, 0.0 if held else -delta)
    return LoadStep(stage, loading, start, increment, leg.increments, end, held, until_free=stage == "unload")


def stretched(load_steps, step) -> tuple[LoadStep, ...]:
    """The load steps with `step` one increment longer; the one after it begins where that ends."""
    place, more = load_steps.index(step), step.increment
    longer = replace(step, increments=step.increments + 1, end=step.end + more)
    back = load_steps[place + 1]
    back = replace(back, start=back.start - more, increments=back.increments + 1)
    return *load_steps[:place], longer, back, *load_steps[place + 2 :]
