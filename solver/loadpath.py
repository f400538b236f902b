"""The experiment as a sequence of Frames along the legs of its path; in one go or in slices with checkpoints."""

from dataclasses import dataclass, replace
from functools import lru_cache
from time import perf_counter

import numpy as np

from .contact import Contact, patch, wider
from .fast import Fast
from .frame import Frame, contact_area, forces, slip_event
from .gfmd import Gfmd
from .held import joined, parted
from .inertia import Inertial
from .layer import Convolution, Modes
from .left_out import ALL
from .legs import HIGHEST, legs_of, stretched
from .record import Record
from .secants import Secants
from .state import Increment, NotConverged, State
from .uniform import Uniform

METHODS = {"fast": Fast, "gfmd": Gfmd}
FREE = 0.1  # of delta_n: a layer deformed no more than that has been let go
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
    legs: tuple | None = None  # the path, once begun
    pressure: float | None = None  # GPa: mean normal traction at the end of the last leg that did not hold it
    carried: bool = False  # whether the state was at rest under other parameters: the next increment may jump


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
    checkpoint = owned(checkpoint) if checkpoint else Checkpoint()
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


def owned(checkpoint):
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
    legs = checkpoint.legs or legs_of(scene)
    leg = next(leg for leg in legs if leg.stage == checkpoint.stage)
    if checkpoint.carried and method != "fast":  # it would start from the whole surface of another equilibrium
        raise ValueError(f"method = {method!r}; allowed where a run carries on: fast; or start it anew")
    loading, load = leg.loading, leg.at(checkpoint.index)
    pressure = checkpoint.pressure if leg.held else None
    start, first = checkpoint.state, checkpoint.first
    if start is not None:
        size = start.active.size - leg.held
    elif "window" in leave_out:
        first, size = patch(scene, BULGE)
    else:
        first, size = 0, scene.nodes
    evaluations = 0
    while True:
        solver = _solver(method, scene, first, size, leave_out, pressure)
        evaluations -= solver.contact.evaluations
        if "approach" in leave_out and _apart(solver.contact, start, loading, load):
            rest = solver.undeformed(loading, load)
            done = Increment(rest, np.zeros_like(rest.u), 0.0)
        else:
            done = solver.increment(start or solver.undeformed(loading, load), loading, load)
        evaluations += solver.contact.evaluations
        height = top_of(leg, done.state)[1]
        if not (solver.contact.crowded(done.state.active) or solver.contact.overlooked(done.traction, height)):
            break
        before, (first, size) = first, wider(scene, first, size)
        start = start and _widened(scene, leg, start, before, first, size)
    frame = _frame(scene, leg, checkpoint.index, load, first, done, evaluations)
    if checkpoint.carried:
        frame = replace(frame, slips=())
    here = replace(checkpoint, legs=legs, first=first, carried=False)
    return frame, _after(scene, here, leg, done, "translation" in leave_out)


def _apart(contact, start, loading, load):
    """Whether no spring acted and none can act at U_x = 0: then there is nothing to solve."""
    if not loading.upright or (start is not None and start.active.any()):
        return False
    return contact.lowest + loading.at(load)[1] > contact.window


def top_of(leg, state):
    """(U_x, U_z) of the top in a State reached along a Leg, nm."""
    return tuple(state.u[:, -1].tolist()) if leg.held else leg.loading.at(state.load)


def _widened(scene, leg, state, before, first, size):
    """The same state on a wider patch: outside the old one, the surface follows from the traction inside."""
    top = top_of(leg, state)
    if leg.held:
        return joined(_surface_widened(scene, top, parted(state), before, first, size), top)
    return _surface_widened(scene, top, state, before, first, size)


def _surface_widened(scene, top, state, before, first, size):
    part = slice(before - first, before - first + state.active.size)
    narrow = Contact(scene, before, state.active.size)
    narrow.residual(state.u, state.active, top, np.empty_like(state.u))
    wide = Convolution(Modes.of(scene).compliance, scene.nodes, size)
    wide.field[:, part] = narrow.traction()
    wide.apply()
    u = wide.product + np.array(top)[:, None]
    active = np.zeros(size, bool)
    u[:, part], active[part] = state.u, state.active
    secants = state.secants and Secants(state.secants.memory, u.size)
    return State(state.load, u, active, [(state.load, u)], secants, doubtful=state.doubtful)


def _after(scene, checkpoint, leg, done, recording):
    """The Checkpoint after an increment: one increment on, or at the beginning of the next leg."""
    if leg.until_free and checkpoint.index == leg.increments and not _free(scene, leg, done.state):
        checkpoint = replace(checkpoint, legs=stretched(checkpoint.legs, leg))
        return replace(checkpoint, index=checkpoint.index + 1, state=done.state)
    if checkpoint.index < leg.increments:
        return replace(checkpoint, index=checkpoint.index + 1, state=done.state)
    following = checkpoint.legs[checkpoint.legs.index(leg) + 1 :]
    if not following:
        return replace(checkpoint, state=done.state, done=True)
    pressure = checkpoint.pressure if leg.held else float(done.traction[1].sum()) / _cell(scene, done.traction)
    state = _turned(leg, following[0], done.state, recording)
    return replace(checkpoint, stage=following[0].stage, index=0, state=state, pressure=pressure)


def _free(scene, leg, state):
    """Whether the layer is not deformed, to FREE, or so high that the retraction ends all the same."""
    if leg.end >= HIGHEST * scene.delta_0:
        return True
    return bool(np.abs(state.u - np.array(top_of(leg, state))[:, None]).max() <= FREE * scene.delta_n)


def _cell(scene, traction):
    """Nodes that the columns of a traction stand for, less those without any."""
    return 1 if traction.shape[1] == 1 else scene.nodes


def _turned(leg, following, state, recording):
    """The state at the end of a leg as the first of the next: another load, no past along it."""
    if following.held and not leg.held:
        state = replace(joined(state, top_of(leg, state)), doubtful=True)
    elif leg.held and not following.held:
        state = parted(state)
    load = following.at(0)
    sideways = following.loading.direction[0]
    record = Record(direction=sideways) if recording and sideways else None
    return replace(state, load=load, past=[(load, state.u)], record=record)


def _frame(scene, leg, k, load, first, done, evaluations):
    U_x, U_z = top_of(leg, done.state)
    u, T = _on_nodes(scene, leg, done.state.u), _on_nodes(scene, leg, done.traction)
    first = 0 if u.shape[1] == scene.nodes else first
    u.flags.writeable = T.flags.writeable = False
    F_bar, L_bar = forces(scene, T)
    area, trailing, leading, patches = contact_area(scene, T, first)
    return Frame(
        stage=leg.stage,
        index=k,
        U_x=U_x,
        delta=0.0 - U_z,
        first=first,
        u=u,
        T=T,
        F_bar=F_bar,
        L_bar=L_bar,
        A_bar=area,
        trailing=trailing,
        leading=leading,
        patches=patches,
        residual=done.residual,
        evaluations=evaluations,
        slips=tuple(_slip_event(scene, leg, first, slip) for slip in done.slips),
        repeated=done.repeated,
    )


def _slip_event(scene, leg, first, slip):
    return slip_event(scene, first, leg.loading.coordinate(slip.load), _on_nodes(scene, leg, slip.traction))


def _on_nodes(scene, leg, field):
    """A field without the column of a held top; that of one node that stands for all, on every node."""
    if leg.held:
        field = field[:, :-1].copy()
    if field.shape[1] == 1 < scene.nodes:
        return np.ndarray(
            (2, scene.nodes), float, field, 0, (field.strides[0], 0)
        )  # broadcast_to takes ten times longer
    return field


@lru_cache(maxsize=4)
def _solver(method, scene, first, size, leave_out, pressure):
    """Buffers, plans and Green's function of a scene: kept because they are dear, lost without harm."""
    if method == "fast" and scene.damping < 1.0:
        return Inertial(scene, first, size, leave_out - {"uniform"}, pressure)
    if method == "fast" and scene.surface == "flat" and "uniform" in leave_out and pressure is None:
        return Uniform(scene, first, size, leave_out)
    return METHODS[method](scene, first, size, leave_out, pressure)


def whole_surface(scene, frame):
    """Displacement of every surface node of the layer, (2, nodes) nm, from the traction on the patch."""
    compliance = Convolution(Modes.of(scene).compliance, scene.nodes, scene.nodes)
    compliance.field[:, frame.first : frame.first + frame.T.shape[1]] = frame.T
    compliance.apply()
    return compliance.product + np.array([[frame.U_x], [-frame.delta]])


def summarize(scene, frames):
    """A run in a few numbers: A_0 and slips after the approach; U_s (nm), F_s and A_s at the first slip in shear.

    None where there is none; L_min, the least load during retraction, in a run with unloading only.
    """
    after = [f for f in frames if f.stage != "approach"]
    first = next((event for f in after if f.stage == "shear" for event in f.slips), None)
    whole = sum(leg.increments + 1 for leg in legs_of(scene)[1:])
    pull_off = [f.L_bar for f in after if f.stage == "unload"]
    return {
        "converged": len(after) >= whole and all(f.residual <= scene.tolerance for f in frames),
        "evaluations": sum(f.evaluations for f in frames),
        "A_0": after[0].A_bar if after else None,
        "slips": sum(len(f.slips) for f in after),
        "U_s": first.load if first else None,
        "F_s": first.F_bar if first else None,
        "A_s": first.A_bar if first else None,
    } | ({"L_min": min(pull_off)} if pull_off else {})
