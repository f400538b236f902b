"""The experiment as a sequence of Frames: approach, then shear; in one go or in slices with checkpoints."""

from dataclasses import dataclass, replace
from functools import lru_cache
from time import perf_counter

import numpy as np

from .contact import Contact, patch, wider
from .fast import Fast
from .frame import Frame, contact_area, forces, slip_event
from .gfmd import Gfmd
from .layer import Convolution, Modes
from .left_out import ALL
from .record import Record
from .secants import Secants
from .state import Increment, NotConverged, State, approach, shear
from .uniform import Uniform

METHODS = {"fast": Fast, "gfmd": Gfmd}
BULGE = 3.0  # delta_n: gap beyond the window that the first patch includes, for surfaces drawn together


@dataclass(frozen=True)
class Checkpoint:
    """Where a run stands between two slices; picklable."""

    stage: str = "approach"
    index: int = 0  # of the next increment
    first: int = 0  # node of the patch
    state: State | None = None
    done: bool = False
    failure: str | None = None  # why the run ended early, with a remedy


def load_path(scene, method="fast", leave_out=ALL):
    """Yield the Frames of a scene in order; raises NotConverged where an increment has no equilibrium in reach.

    leave_out: the rules of `left_out` that the fast method may use.
    """
    checkpoint = Checkpoint()
    while not checkpoint.done:
        frame, checkpoint = next_frame(scene, checkpoint, method, leave_out)
        yield frame


def advance(scene, checkpoint=None, budget=0.04, method="fast", leave_out=ALL):
    """(frames, checkpoint): the Frames that follow `checkpoint` (None: the first ones), for about `budget` seconds.

    A pure function of picklable arguments, for use in a worker; at least one frame, unless the increment fails:
    then checkpoint.failure says where and what to do.
    """
    checkpoint = _own(checkpoint) if checkpoint else Checkpoint()
    frames, end = [], perf_counter() + budget
    while not checkpoint.done:
        try:
            frame, checkpoint = next_frame(scene, checkpoint, method, leave_out)
        except NotConverged as failure:
            return frames, replace(checkpoint, done=True, failure=str(failure))
        frames.append(frame)
        if perf_counter() > end:
            break
    return frames, checkpoint


def _own(checkpoint):
    """The checkpoint with secant pairs of its own, so that going on from it leaves the given one as it is."""
    state = checkpoint.state
    if state is None:
        return checkpoint
    own = replace(state, secants=state.secants and state.secants.copy(), record=state.record and state.record.copy())
    return replace(checkpoint, state=own)


def next_frame(scene, checkpoint, method="fast", leave_out=ALL):
    """(frame, checkpoint) of the increment that `checkpoint` stands before; may change the latter's arrays."""
    if method not in METHODS:
        raise ValueError(f"method = {method!r}; allowed: {', '.join(METHODS)}; choose one of them")
    approaching = checkpoint.stage == "approach"
    loading = approach(scene) if approaching else shear(scene)
    k = checkpoint.index
    load = scene.approach_at(k) if approaching else scene.shear_at(k)
    start, first = checkpoint.state, checkpoint.first
    if start is not None and not approaching and k == 0:
        start = _turned(start, "translation" in leave_out)
    if start is not None:
        size = start.active.size
    elif "window" in leave_out:
        first, size = patch(scene, BULGE)
    else:
        first, size = 0, scene.nodes
    evaluations = 0
    while True:
        solver = _solver(method, scene, first, size, leave_out)
        evaluations -= solver.contact.evaluations
        if approaching and "approach" in leave_out and solver.contact.lowest - load > solver.contact.window:
            rest = solver.undeformed(loading, load)
            done = Increment(rest, np.zeros_like(rest.u), 0.0)
        else:
            done = solver.increment(start or solver.undeformed(loading, load), loading, load)
        evaluations += solver.contact.evaluations
        if not solver.contact.crowded(done.state.active):
            break
        before, (first, size) = first, wider(scene, first, size)
        start = start and _widened(scene, loading, start, before, first, size)
    frame = _frame(scene, checkpoint.stage, k, load, first, done, evaluations)
    return frame, _after(scene, checkpoint, first, done.state)


def _widened(scene, loading, state, before, first, size):
    """The same state on a wider patch: outside the old one, the surface follows from the traction inside."""
    part = slice(before - first, before - first + state.active.size)
    narrow = Contact(scene, before, state.active.size)
    narrow.residual(state.u, state.active, loading.at(state.load), np.empty_like(state.u))
    wide = Convolution(Modes.of(scene).compliance, scene.nodes, size)
    wide.field[:, part] = narrow.traction()
    wide.apply()
    u = wide.product + np.array(loading.at(state.load))[:, None]
    active = np.zeros(size, bool)
    u[:, part], active[part] = state.u, state.active
    secants = state.secants and Secants(state.secants.memory, u.size)
    return State(state.load, u, active, [(state.load, u)], secants)


def _turned(start, recording):
    """The state at the end of the approach as the first of the shear: another load, no past along it."""
    return replace(start, load=0.0, past=[(0.0, start.u)], record=Record() if recording else None)


def _after(scene, checkpoint, first, reached):
    steps = scene.approach_increments if checkpoint.stage == "approach" else scene.shear_increments
    if checkpoint.index < steps:
        return Checkpoint(checkpoint.stage, checkpoint.index + 1, first, reached)
    if checkpoint.stage == "approach":
        return Checkpoint("shear", 0, first, reached)
    return Checkpoint("shear", steps, first, reached, done=True)


def _frame(scene, stage, k, load, first, done, evaluations):
    u, T = _spread(scene, done.state.u), _spread(scene, done.traction)
    first = first if u is done.state.u else 0
    u.flags.writeable = T.flags.writeable = False
    F_bar, L_bar = forces(scene, T)
    area, trailing, leading = contact_area(scene, T, first)
    return Frame(
        stage=stage,
        index=k,
        U_x=load if stage == "shear" else 0.0,
        delta=scene.delta if stage == "shear" else load,
        first=first,
        u=u,
        T=T,
        F_bar=F_bar,
        L_bar=L_bar,
        A_bar=area,
        trailing=trailing,
        leading=leading,
        residual=done.residual,
        evaluations=evaluations,
        slips=tuple(slip_event(scene, first, slip.load, _spread(scene, slip.traction)) for slip in done.slips),
        repeated=done.repeated,
    )


def _spread(scene, field):
    """A field of one node that stands for all, on every node; any other as it is."""
    if field.shape[1] == 1 < scene.nodes:
        return np.ndarray(
            (2, scene.nodes), float, field, 0, (field.strides[0], 0)
        )  # broadcast_to takes ten times longer
    return field


@lru_cache(maxsize=4)
def _solver(method, scene, first, size, leave_out):
    """Buffers, plans and Green's function of a scene: kept because they are dear, lost without harm."""
    if method == "fast" and scene.surface == "flat" and "uniform" in leave_out:
        return Uniform(scene, first, size, leave_out)
    return METHODS[method](scene, first, size, leave_out)


def whole_surface(scene, frame):
    """Displacement of every surface node of the layer, (2, nodes) nm, from the traction on the patch."""
    compliance = Convolution(Modes.of(scene).compliance, scene.nodes, scene.nodes)
    compliance.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    compliance.apply()
    return compliance.product + np.array([[frame.U_x], [-frame.delta]])


def summarize(scene, frames):
    """A run in a few numbers: A_0 at U_x = 0; U_s (nm), F_s and A_s at the first slip in shear (None without one)."""
    shear = [f for f in frames if f.stage == "shear"]
    events = [event for f in shear for event in f.slips]
    first = events[0] if events else None
    return {
        "converged": len(shear) == scene.shear_increments + 1 and all(f.residual <= scene.tolerance for f in frames),
        "evaluations": sum(f.evaluations for f in frames),
        "A_0": shear[0].A_bar if shear else None,
        "slips": len(events),
        "U_s": first.load if first else None,
        "F_s": first.F_bar if first else None,
        "A_s": first.A_bar if first else None,
    }
