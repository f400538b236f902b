"""A held load given in N/m: the indentation at which the approach reaches it, and the run up to there."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ..continuation.corrector import Corrector
from ..continuation.state import Point, State
from ..continuation.trace import Trace
from ..mechanics.contact import patch
from ..mechanics.equilibrium import Equilibrium
from ..scene import LARGEST_RUN, LIMITS, Scene, SceneError
from ..schema import as_number
from .frame import Frame
from .load_steps import sideways
from .loadpath import Checkpoint, Run

OFF = 1e-6  # nm beyond the increment in which the load is reached: what the tolerance leaves


def held_at(
    scene: Scene, load: float, observe: Callable[..., None] | None = None
) -> tuple[Scene, list[Frame], Checkpoint]:
    """The Scene that holds a normal load (N/m) during the shear: hold 'load', at the indentation that reaches it.

    With the Frames of its run before that, and the Checkpoint after them. The load falls below zero as the surfaces
    attract each other, and rises as they are pressed together. The indentation is that of the first rise to `load`:
    from the states of the increment in which it lies, the height of the top is solved for under that load.
    observe: as of `Run.frames`. Raises SceneError where the approach does not reach it, NotConverged.
    """
    wanted = as_number(load)
    if not abs(wanted) < float("inf"):
        raise SceneError("load", load, "allowed: a finite number of N/m, negative for a pull", "give such a number")
    if scene.path not in ("shear", "loop"):
        allowed = f"allowed with path 'shear' or 'loop', not {scene.path!r}"
        raise SceneError("load", load, allowed, "choose one of these, or leave load out")
    scene = scene.changed(hold="load")  # raises for a drive_n before the approach is computed
    longest = LARGEST_RUN * scene.du_z * scene.delta_n / scene.delta_0 - 1.0
    most = min(LIMITS["delta_bar"].high, 0.999 * scene.height * scene.width / scene.delta_0, longest)
    run = Run(replace(scene, path="shear", hold="delta", u_x_max=0.0).changed(delta_bar=most))
    checkpoint, frames, least = Checkpoint(), list[Frame](), 0.0
    while True:
        frame, after = run.next_frame(checkpoint, observe)
        if frames and frames[-1].L < wanted <= frame.L:
            break
        if after.done or after.stage != "approach":
            allowed = f"allowed: {least:.4g} .. {frame.L:.4g} N/m, what the approach reaches"
            raise SceneError("load", load, allowed, "give a load in that range, or a thicker layer")
        frames.append(frame)
        checkpoint, least = after, min(least, frame.L)
    before = frames[-1]
    delta = _under(run, before, frame, wanted)
    if delta is None:
        place = f"delta_bar = {frame.delta / scene.delta_0:.4g}"
        jump = f"the approach jumps from {before.L:.4g} to {frame.L:.4g} N/m at {place}"
        raise SceneError("load", load, jump, "give a load outside that jump")
    held = scene.changed(delta_bar=delta / scene.delta_0)
    return held, *_passed(held, run.stepper.problem, frames, checkpoint)


def _passed(scene, problem, frames, checkpoint):
    """(the Frames, the Checkpoint after them) of an approach under another Scene, on the patch of that."""
    first, size = patch(scene)
    part = slice(first, first + size)

    def placed(field):
        whole = np.zeros((2, scene.nodes))
        whole[:, problem.contact.part] = field.reshape(2, -1)
        return whole[:, part].copy()

    def displaced(v, load):
        return problem.everywhere(v, load)[:, part].copy()

    def read_only(field):
        field.flags.writeable = False
        return field

    moved = [
        replace(f, scene=scene, first=first, u=read_only(displaced(f.u.ravel(), f.delta)), T=read_only(placed(f.T)))
        for f in frames
    ]
    past = [Point(load, displaced(v, load).ravel()) for load, v in checkpoint.state.past]
    state = State(checkpoint.state.load, past[0].v, past, undecided=checkpoint.state.undecided)
    jumps = tuple(
        end._replace(v=displaced(end.v, end.load).ravel(), phi=placed(end.phi).ravel(), psi=None)
        for end in checkpoint.trace.jumps
    )
    return moved, Checkpoint(increment=checkpoint.increment, state=state, trace=Trace.of(state, jumps), scene=scene)


def _under(run, before, frame, wanted):
    """The indentation, nm, between those of two Frames of the approach, at a load, N/m; None where it jumps over it."""
    problem = Equilibrium(run.stepper.problem.contact, sideways(1.0, 0.0), wanted / run.scene.width)
    part = (wanted - before.L) / (frame.L - before.L)
    # a slip in between may leave the load to the branch before it, or to the one after
    for share in (part,) if not frame.slips else (0.0, 1.0):
        u, delta = (a + share * (b - a) for a, b in ((before.u, frame.u), (before.delta, frame.delta)))
        corrector = Corrector(problem)
        solution = corrector.solve(np.append(u.ravel(), -delta), 0.0, corrector.secants())
        if solution is not None and before.delta - OFF <= -solution.v[-1] <= frame.delta + OFF:
            return float(-solution.v[-1])
    return None
