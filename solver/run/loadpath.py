"""The experiment as a sequence of Frames along the load steps of its path; from Checkpoints in between."""

from dataclasses import dataclass, replace
from math import inf
from time import perf_counter, thread_time

import numpy as np

from ..continuation.gfmd import Gfmd
from ..continuation.quasistatic import QuasiStatic
from ..continuation.replay import Replay
from ..continuation.state import NotConverged, OutOfTime, PulledOff, State
from ..mechanics.contact import Contact, patch
from ..mechanics.equilibrium import Equilibrium, closed_stiffness
from .frame import Frame, contact_area, forces, slip_event
from .load_steps import HIGHEST, load_steps_of, stretched
from .shortcuts import ALL

METHODS = {"fast": QuasiStatic, "gfmd": Gfmd}
FREE = 0.1  # of delta_n: a layer deformed no more than that has been let go
BULGE = 3.0  # delta_n: gap beyond the window that the first patch includes, for surfaces drawn together
BUSY = 1.5  # s that an increment may take beyond its limit of processor time, where others use the processor


@dataclass(frozen=True)
class Checkpoint:
    """Where a run stands between two slices; picklable."""

    stage: str = "approach"
    index: int = 0  # of the next increment
    patch: tuple | None = None  # (first node, nodes) of the patch
    state: State | None = None
    done: bool = False
    failure: str | None = None  # why the run ended early, with a remedy
    late: bool = False  # whether that was for want of time only: see `in_time`
    load_steps: tuple | None = None  # the path, once begun
    pressure: float | None = None  # GPa: mean normal traction at the end of the last load step that did not hold it
    carried: bool = False  # whether the state was at rest under other parameters: the next increment may jump


def load_path(scene, method="fast", leave_out=ALL):
    """Yield the Frames of a scene in order; raises NotConverged where an increment has no equilibrium in reach.

    leave_out: the rules of `shortcuts` that the fast method may use.
    """
    checkpoint, run = Checkpoint(), Run(scene, method, leave_out)
    while not checkpoint.done:
        frame, checkpoint = run.next_frame(checkpoint)
        yield frame


class Run:
    """Computes increments of one scene; owns the buffers of its contact, and keeps nothing else between increments."""

    def __init__(self, scene, method="fast", leave_out=ALL):
        if isinstance(method, str) and method not in METHODS:
            raise ValueError(f"method = {method!r}; allowed: {', '.join(METHODS)}; choose one of them")
        self.scene, self.method, self.leave_out = scene, method, leave_out
        self.film = None  # a list that takes the states of motions (see `film.through`)
        self._fast = method == "fast"
        self._limit = self._end = self._latest = inf  # of an increment, s; what the clocks show when it must end
        self._stepper = self._place = None  # of the load step and patch that are computed at present

    def next_frame(self, checkpoint, limit=inf):
        """(frame, checkpoint) of the increment that `checkpoint` stands before; may change the latter's arrays.

        Raises OutOfTime where that takes more than `limit` seconds of processor time, or BUSY more on a busy machine.
        """
        scene = self.scene
        self._limit, self._end, self._latest = limit, thread_time() + limit, perf_counter() + limit + BUSY
        load_steps = checkpoint.load_steps or load_steps_of(scene)
        step = next(step for step in load_steps if step.stage == checkpoint.stage)
        if checkpoint.carried and not self._fast:  # it would start from the whole surface of another equilibrium
            raise ValueError(f"method = {self.method!r}; allowed where a run carries on: fast; or start it anew")
        stepper = self._stepper_of(step, checkpoint)
        index, load, slips, before = checkpoint.index, step.at(checkpoint.index), (), stepper.problem.evaluations
        state = checkpoint.state or stepper.start(load)
        try:
            done = stepper.increment(state, load)
            while done.state.load > load:  # the surface did not come to rest before: no frame there
                slips += done.slips
                if index == step.increments:  # nor before the end: then the last frame is where it does
                    load = done.state.load
                    done = replace(done, slips=())
                    break
                index += 1
                load = step.at(index)
                done = replace(done, slips=()) if done.state.load > load else stepper.increment(done.state, load)
        except NotConverged as failure:
            self._place = None  # the problem may have grown beyond the checkpoint's patch
            raise self._placed(failure, step, load) from None
        done = replace(done, slips=slips + done.slips)
        problem = stepper.problem
        contact = problem.contact
        frame = self._frame(step, index, load, problem, done, contact.evaluations - before)
        if checkpoint.carried:
            frame = replace(frame, slips=())
        here = replace(
            checkpoint, index=index, load_steps=load_steps, patch=(contact.first, contact.size), carried=False
        )
        self._place = step, here.patch, here.pressure
        return frame, self._after(here, step, problem, done)

    def _watch(self):
        if thread_time() > self._end or perf_counter() > self._latest:
            given = f"{self._limit:g} s of processor time, or {self._limit + BUSY:g} s"
            raise OutOfTime(f"no equilibrium within {given}")

    def _placed(self, failure, step, load):
        """The same failure with its place and a remedy."""
        if isinstance(failure, PulledOff):
            return failure
        remedy = "try fewer nodes, a larger tolerance, or a smaller du_x or du_z"
        if self.scene.damping < 1.0:  # the law has no potential, so that it may feed an oscillation
            remedy = f"try a damping larger than {self.scene.damping:g}: with so little it may never come to rest"
        elif not self._fast:
            remedy = "try a larger tolerance, a smaller du_x or du_z, or method fast"
        kind = OutOfTime if isinstance(failure, OutOfTime) else NotConverged
        return kind(f"Not converged at {step.loading.name} = {load:.6g} nm: {failure}; {remedy}")

    def _stepper_of(self, step, checkpoint):
        """The stepper of a step, on the patch of the checkpoint."""
        place = step, checkpoint.patch, checkpoint.pressure
        if self._place == place:
            return self._stepper
        scene, held = self.scene, checkpoint.pressure if step.held else None
        contact = self._contact_of(checkpoint.patch)
        problem = Equilibrium(contact, step.loading, held)
        kind = METHODS.get(self.method, self.method) if isinstance(self.method, str) else self.method
        stepper = kind(problem, scene.damping, closed_stiffness(scene))
        if self.film is not None:
            stepper.film = self.film
        if self._fast and "translation" in self.leave_out and step.loading.direction[0]:
            stepper = Replay(stepper, scene.spacing)
        self._stepper, self._place = stepper, place
        return stepper

    def _contact_of(self, where):
        """The Contact on a patch (first, nodes), None: the first one; the present one if it is that."""
        scene, leave_out = self.scene, self.leave_out
        if self._stepper is not None:
            contact = self._stepper.problem.contact
            if where == (contact.first, contact.size):
                return contact
        if where is None and self._fast and scene.surface == "flat" and "uniform" in leave_out:
            where = 0, 1
        elif where is None:
            where = patch(scene, BULGE) if "window" in leave_out else (0, scene.nodes)
        normal_only = self._fast and scene.phi_ratio == 0.0 and "friction" in leave_out
        contact = Contact(scene, *where, normal_only=normal_only)
        contact.watch = self._watch
        return contact

    def _after(self, checkpoint, step, problem, done):
        """The Checkpoint after an increment: one increment on, or at the beginning of the next step."""
        if step.until_free and checkpoint.index == step.increments and not self._free(step, problem, done.state):
            checkpoint = replace(checkpoint, load_steps=stretched(checkpoint.load_steps, step))
            return replace(checkpoint, index=checkpoint.index + 1, state=done.state)
        if checkpoint.index < step.increments:
            return replace(checkpoint, index=checkpoint.index + 1, state=done.state)
        following = checkpoint.load_steps[checkpoint.load_steps.index(step) + 1 :]
        if not following:
            return replace(checkpoint, state=done.state, done=True)
        state, pressure = done.state, checkpoint.pressure
        if not step.held:
            pressure = problem.contact.pressure(problem.traction(state.v, state.active))
        state = turned(problem, state, step.held, following[0])
        return replace(checkpoint, stage=following[0].stage, index=0, state=state, pressure=pressure)

    def _free(self, step, problem, state):
        """Whether the layer is not deformed, to FREE, or so high that the retraction ends all the same."""
        if step.end >= HIGHEST * self.scene.delta_0:
            return True
        top = np.array(problem.top(state.v, state.load))[:, None]
        return bool(np.abs(problem.surface(state.v) - top).max() <= FREE * self.scene.delta_n)

    def _frame(self, step, k, load, problem, done, evaluations):
        scene, state = self.scene, done.state
        U_x, U_z = problem.top(state.v, load)
        traction = problem.traction(state.v, state.active)
        u, T = _on_nodes(scene, problem.surface(state.v)), _on_nodes(scene, traction)
        first = 0 if u.shape[1] == scene.nodes else problem.contact.first
        u.flags.writeable = T.flags.writeable = False
        F_bar, L_bar = forces(scene, T)
        return Frame(
            stage=step.stage,
            index=k,
            U_x=U_x,
            delta=0.0 - U_z,
            first=first,
            u=u,
            T=T,
            F_bar=F_bar,
            L_bar=L_bar,
            A_bar=contact_area(scene, T, first),
            residual=done.residual,
            evaluations=evaluations,
            slips=tuple(self._event(step, slip) for slip in done.slips),
            repeated=done.repeated,
        )

    def _event(self, step, slip):
        """The SlipEvent of a Slip, in whatever problem it happened."""
        contact, m = self._stepper.problem.contact, slip.active.size
        if slip.place != (contact.first, contact.size):
            contact = Contact(self.scene, *slip.place)
        T = contact.traction(slip.v[: 2 * m].reshape(2, m), slip.active)
        event = slip_event(self.scene, contact.first, step.loading.coordinate(slip.load), _on_nodes(self.scene, T))
        return replace(event, stage=step.stage, kind=slip.kind, located=slip.located)


def turned(problem, state, was_held, following):
    """The State at the end of a step as the first of the next: another load, no past along it."""
    v = state.v
    if was_held != following.held:
        u, top = problem.surface(v), problem.top(v, state.load)[1]
        v = np.append(u.ravel(), top if following.held else ())
    load, same = following.at(0), was_held == following.held
    secants = state.secants if same else None
    begun = State(load, v, state.active, [(load, v)], secants, modes=state.modes if same else None)
    begun.unsure = following.held and not was_held
    return begun


def _on_nodes(scene, field):
    """A field of one node that stands for all on every node; any other as a copy."""
    if field.shape[1] == 1 < scene.nodes:
        field = field.copy()
        return np.ndarray(
            (2, scene.nodes), float, field, 0, (field.strides[0], 0)
        )  # broadcast_to takes ten times longer
    return field.copy()
