"""Continue a run under changed parameters, from its present state in shear."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from math import ceil

import numpy as np

from ..continuation.state import State
from ..mechanics.contact import Contact
from ..scene import SURFACES, Scene, SceneError
from .frame import Frame
from .load_steps import LoadStep, load_steps_of
from .loading import vertical
from .loadpath import Checkpoint, Run

GEOMETRY = ("surface", "nodes", "width", *(name for kind in SURFACES.values() for name in kind.parameters))


def carry_on(checkpoint: Checkpoint, scene: Scene, changed: Scene) -> Checkpoint:
    """The Checkpoint from which a run of `scene`, now at `checkpoint`, continues as a run of the Scene `changed`.

    The top reaches a new indentation in steps of du_z at the same U_x (stage "press"). Other changes take effect at
    once, in an increment 0 at the same U_x. If the state is no equilibrium there, the transient leads to the next one,
    without a slip event: the parameters caused it. Then the load step continues to u_x_max. A held load keeps its value
    in N/m; after a new indentation it is the load there. For method fast only.
    Raises SceneError where `changed` has another surface or a path that ends before this load; ValueError where the run
    is not in shear.
    """
    if changed == scene:
        return checkpoint
    load_steps = checkpoint.load_steps or load_steps_of(scene)
    step = next(step for step in load_steps if step.stage == checkpoint.stage)
    if not step.loading.direction[0] or checkpoint.state is None or checkpoint.patch is None:
        raise ValueError(f"stage = {step.stage!r}: a run goes on with changed parameters in shear only; start it anew")
    _refuse(scene, changed)
    problem = step.problem(Contact(scene, *checkpoint.patch), checkpoint.pressure)
    state = checkpoint.state
    top = problem.top(state.v, state.load)
    rest = _rest(step.stage, changed, state.load)
    press = _press(scene, changed, top, step.held)
    pressure = checkpoint.pressure
    if not step.held:
        pressure = problem.contact.pressure(problem.traction(state.v, state.active)[1])
    ahead = rest if press is None else (press, *rest)
    u, load = problem.surface(state.v), ahead[0].at(0)
    v = np.append(u.ravel(), top[1] if ahead[0].held else ())
    begun = State(load, v, state.active, [(load, v)], unsure=True)
    return Checkpoint(ahead[0].stage, 0, checkpoint.patch, begun, load_steps=ahead, pressure=pressure, carried=True)


def carried_path(legs: Iterable[tuple[Scene, int | None]]) -> Iterator[Frame]:
    """Yield the Frames of a run with changing parameters: [(Scene, frames), ..., (Scene, None: up to its end)].

    Raises NotConverged as `load_path` does, the errors of `carry_on`, and ValueError where a leg ends too early.
    """
    checkpoint, before = Checkpoint(), None
    for scene, count in legs:
        if before is not None:
            checkpoint = carry_on(checkpoint, before, scene)
        run, given, before = Run(scene), 0, scene
        while given != count and not checkpoint.done:
            frame, checkpoint = run.next_frame(checkpoint)
            given += 1
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


def _rest(stage, changed, load):
    """The load steps of `changed` from that load (nm) of that stage on."""
    load_steps = load_steps_of(changed)
    position = next((i for i, step in enumerate(load_steps) if step.stage == stage), None)
    if position is None:
        raise SceneError("path", changed.path, f"allowed: one with stage {stage!r}, in which the run is", "start anew")
    step = load_steps[position]
    end = step.at(step.increments)
    ahead = (end - load) / step.increment
    if ahead < -1e-9:
        raise SceneError(
            "u_x_max", changed.u_x_max, f"allowed: {abs(load):g} nm or more, where the run is", "enlarge it"
        )
    return replace(step, start=load, increments=max(0, ceil(ahead - 1e-9)), end=end), *load_steps[position + 1 :]


def _press(scene, changed, top, held):
    """The LoadStep from the present indentation to that of `changed` at fixed U_x, or None where they are the same."""
    now = -top[1]
    wanted = changed.delta if not held or changed.hold == "delta" or changed.delta_bar != scene.delta_bar else now
    if abs(wanted - now) <= 1e-12 * changed.delta_0:
        return None
    du_z, sign = changed.du_z * changed.delta_n, 1.0 if wanted > now else -1.0
    increments = ceil(abs(wanted - now) / du_z - 1e-9)
    return LoadStep("press", vertical(sign, top[0]), sign * now, du_z, increments, sign * wanted)
