"""Continue a run from one of its Frames: a Frame determines what follows, under the same or changed parameters."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import islice
from math import ceil
from typing import Any

import numpy as np

from ..continuation.state import State
from ..mechanics.contact import Contact
from ..scene import SURFACES, Scene, SceneError
from .frame import Frame, moving
from .load_steps import ROUND_OFF, LoadStep, load_steps_of, vertical
from .loadpath import Checkpoint, Run

GEOMETRY = ("surface", "nodes", "width", *(name for kind in SURFACES.values() for name in kind.parameters))


def checkpoint_at(frame: Frame, ahead: tuple[LoadStep, ...], **more: Any) -> Checkpoint:
    """The Checkpoint of a run in the state of a Frame, before the load steps `ahead`; more: of its State."""
    m = 1 if frame.u.strides[1] == 0 else frame.u.shape[1]  # one node may stand for all: see `frame.on_nodes`
    patch, u = (frame.first if m > 1 else 0, m), np.ascontiguousarray(frame.u[:, :m])
    v = np.append(u.ravel(), -frame.delta if ahead[0].held else ())
    state = State.at_rest(ahead[0].at(0), v, Contact(frame.scene, *patch).within_window(u), **more)
    pressure = frame.L_bar * frame.scene.E
    return Checkpoint(ahead[0].stage, 0, patch, state, load_steps=ahead, pressure=pressure)


def carry_on(frame: Frame, changed: Scene) -> Checkpoint:
    """Changes parameters in the middle of a run.

    Parameters: frame: where the run stands, in shear or at the end of the approach; changed: the Scene from there on.
    Returns the Checkpoint from which `advance` continues.
    Raises SceneError where `changed` has another surface or a path that ends before this load; ValueError where the run
    is not in shear.

    Example: `advance(Scene(E=60.0), carry_on(simulate(Scene()).frames[-100], Scene(E=60.0)))`

    The top reaches a new indentation in steps of du_z at the same U_x (stage "press"). Other changes take effect at
    once, in an increment 0 at the same U_x. If the state is no equilibrium there, the transient leads to the next one,
    without a slip event: the parameters caused it. Then the load step continues to u_x_max. A held load keeps its value
    in N/m; after a new indentation it is the load there. For method fast only.
    The last Frame of the approach counts as one of the shear at U_x = 0.
    """
    approach, following, *_ = load_steps_of(frame.scene)
    stage = following.stage if frame.stage == "approach" and frame.delta >= approach.end else frame.stage
    if frame.scene.legs or changed.legs or moving(stage) != "U_x":
        raise ValueError(f"stage = {stage!r}: a run goes on with changed parameters in shear only; start it anew")
    _refuse(frame.scene, changed)
    rest = _rest(stage, changed, frame)
    press = _press(frame, changed)
    ahead = rest if press is None else (press, *rest)
    return checkpoint_at(frame, ahead, unsure=True)._replace(carried=True)


def carried_path(legs: Iterable[tuple[Scene, int | None]]) -> Iterator[Frame]:
    """Computes a run during which parameters change.

    Parameters: legs: (Scene, number of frames) each; None for the number leads to the end of the path.
    Returns an iterator of Frames.
    Raises NotConverged as `load_path` does, the errors of `carry_on`, and ValueError where a leg ends too early.

    Example: `frames = list(carried_path([(Scene(), 300), (Scene(E=60.0), None)]))`
    """
    frame, checkpoint = None, Checkpoint()
    for scene, count in legs:
        if frame is not None and scene != frame.scene:
            checkpoint = carry_on(frame, scene)
        given = 0
        for frame, after in islice(Run(scene).frames(checkpoint), count):
            given, checkpoint = given + 1, after
            yield frame
        if count is not None and given < count:
            raise ValueError(f"legs: {count} increments; allowed: 1 .. {given}, where the run ends; give fewer")


def _refuse(scene, changed):
    """Raises SceneError where `changed` has another surface, so that no state of `scene` fits it."""
    given = "allowed: its value while a run goes on", "start the run anew"
    for name in GEOMETRY:
        same = name not in ("nodes", "width") and np.array_equal(changed.profile, scene.profile)
        if getattr(changed, name) != getattr(scene, name) and not same:
            raise SceneError(name, getattr(changed, name), *given)


def _rest(stage, changed, frame):
    """The load steps of `changed` from a Frame on, of that stage."""
    load_steps = load_steps_of(changed)
    position = next((i for i, step in enumerate(load_steps) if step.stage == stage), None)
    if position is None:
        raise SceneError("path", changed.path, f"allowed: one with stage {stage!r}, in which the run is", "start anew")
    step = load_steps[position]
    load = step.loading.load_of(frame)
    end = step.at(step.increments)
    ahead = (end - load) / step.increment
    if ahead < -ROUND_OFF:
        raise SceneError(
            "u_x_max", changed.u_x_max, f"allowed: {abs(load):g} nm or more, where the run is", "enlarge it"
        )
    return replace(step, start=load, increments=max(0, ceil(ahead - ROUND_OFF)), end=end), *load_steps[position + 1 :]


def _press(frame, changed):
    """The LoadStep from the indentation of a Frame to that of `changed` at fixed U_x; None where these are the same."""
    now, scene = frame.delta, frame.scene
    if scene.hold == "load" == changed.hold and changed.delta_bar == scene.delta_bar:
        return None
    way = changed.delta - now
    du_z, sign = changed.du_z * changed.delta_n, 1.0 if way > 0.0 else -1.0
    increments = ceil(abs(way) / du_z - ROUND_OFF)
    if increments < 1:
        return None
    return LoadStep("press", vertical(sign, frame.U_x), sign * now, du_z, increments, sign * changed.delta)
