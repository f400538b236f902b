"""The experiment as a sequence of Frames along the load steps of its path; from Checkpoints in between."""

from collections.abc import Callable, Iterator, Mapping
from math import inf
from time import perf_counter, thread_time
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from ..continuation.gfmd import Gfmd
from ..continuation.quasistatic import QuasiStatic
from ..continuation.replay import advanced
from ..continuation.state import NotConverged, Outcome, OutOfTime, PulledOff, State
from ..continuation.trace import Trace
from ..mechanics.contact import Contact, patch
from ..mechanics.equilibrium import Equilibrium
from ..mechanics.surface import closed_stiffness, too_soft
from ..scene import Scene, SceneError, checked_scene, refuse_other
from ..schema import as_number
from ..threads import computation
from .frame import Frame, SlipEvent, Stage, forces_and_area, frame_of
from .load_steps import HIGHEST, LoadStep, load_steps_of, stretched

METHODS: Mapping[str, Callable[..., Any]] = MappingProxyType({"fast": QuasiStatic, "gfmd": Gfmd})
# s of processor time, below a minute. Some scenes with E below 1 GPa exceed it, phi_n of 10 to 20 N/m at E = 5, and
# phi_ratio 30 at E = 2.5, whose slips take thousands of force evaluations
SOFT_LIMIT = 50.0
FREE = 0.1  # delta_n: a layer that is deformed less is detached; adhesion deforms a layer in contact by some delta_n
# With a drive, or under the other law, every state is searched: modes began to
# grow up to seven increments before a search (tests/bench/rests.py --more)
DRIVEN = 0.0


class Checkpoint(NamedTuple):
    """Where a run stands between two slices; from a pickled one, frames are the same to the tolerance.

    Example: `frames, checkpoint = advance(Scene())`
    """

    stage: Stage = Stage("approach")
    increment: int = 0  # the next one, within its stage
    state: State | None = None
    trace: Trace | None = None  # branches that the stage has passed, and the ends of the stage before
    done: bool = False
    failure: str | None = None  # why the run ended early, with a remedy
    outcome: Outcome = Outcome.FINISHED  # of the run, once done
    load_steps: tuple[LoadStep, ...] | None = None  # the path, once begun
    scene: Scene | None = None  # of the run, once begun: no other one continues it
    pressure: float | None = None  # GPa; mean normal traction after the last step at given delta: the load to hold


def time_limit(scene: Scene, limit: float | None = None) -> float:
    """Processor time (s) after which a run ends: `limit`, or if that is None SOFT_LIMIT for a soft layer, else inf.

    A layer is soft where phi_n/E exceeds delta_n, or phi_t/E delta_t: so far adhesion and friction stretch it.
    Raises SceneError for a limit that is no number from 0 on.
    """
    if limit is not None:
        if not (seconds := as_number(limit)) >= 0.0:
            raise SceneError("limit", limit, "allowed: a number of seconds, 0 or more, or None", "give one of these")
        return seconds
    soft = scene.phi_n > scene.E * scene.delta_n or scene.phi_t > scene.E * scene.delta_t
    return SOFT_LIMIT if soft else inf


def load_path(
    scene: Scene, method: str | Callable[..., Any] = "fast", replay: bool = True, limit: float = inf
) -> Iterator[Frame]:
    """Computes the increments of a scene, one by one.

    Parameters: scene; method: a name in METHODS, "fast" or "gfmd"; replay: whether the fast method moves known states
    on by lattice periods where sliding repeats itself, and verifies them; limit: processor time of the run, s.
    Returns an iterator of Frames.
    Raises NotConverged where an increment has no equilibrium in reach, OutOfTime after the limit, ValueError for a name
    not in METHODS.

    Example: `next(load_path(Scene())).L`
    """
    yield from (frame for frame, _ in Run(scene, method, replay).frames(whole=limit))


def until(
    scene: Scene, stop: Callable[[Frame], bool] | None = None, limit: float = inf
) -> Iterator[tuple[Frame, Checkpoint]]:
    """Yield each Frame of `load_path` with the Checkpoint after it, up to the first for which `stop` holds.

    Raises OutOfTime after `limit` s of processor time.
    """
    for frame, checkpoint in Run(scene).frames(whole=limit):
        yield frame, checkpoint
        if stop is not None and stop(frame):
            return


def deadline(limit: float, busy: float = 10.0, run: float = 0.0) -> Callable[..., None] | None:
    """A function that raises OutOfTime after `limit` s of processor time, or `busy` more on the clock.

    Other processes may need the cores. run: the limit of a whole run, for the message, where that is meant; 0: of an
    increment.
    """
    if limit == inf:
        return None
    end, latest = thread_time() + limit, perf_counter() + limit + busy
    late = f"no equilibrium within {limit:g} s of processor time, or {limit + busy:g} s"
    if busy == inf:
        late = f"the run takes more than {run or limit:g} s of processor time"

    def observe(*moving):
        if thread_time() > end or perf_counter() > latest:
            raise OutOfTime(late)

    return observe


def far_of(scene: Scene) -> float | None:
    """How far states may move without a search, as `far` of `rest.Judge`; None: as usual."""
    return DRIVEN if any(scene.drive_compliance) or scene.law != "np1" else None


class Run:
    """Computes increments of one scene; owns the buffers of its contact, and needs nothing else between increments.

    Attributes: patch, (first node, nodes); stepper, the current one; done, the Increment of the last frame.
    """

    def __init__(self, scene, method="fast", replay=True):
        if isinstance(method, str) and method not in METHODS:
            raise ValueError(f"method = {method!r}; allowed: {', '.join(METHODS)}; choose one of them")
        self.scene, self.method, self.replay = checked_scene(scene), method, replay
        self._fast, self.patch = method == "fast", patch(scene)
        self.stepper = self.done = self._place = None  # _place: load step and pressure that the stepper is for

    def frames(self, checkpoint=None, limit=inf, observe=None, whole=inf) -> Iterator[tuple[Frame, Checkpoint]]:
        """Yield each Frame that follows a Checkpoint (None: the first ones) with the Checkpoint after it.

        limit, whole: s of processor time for an increment, and for all of them. observe: a function called after force
        evaluations, as of `mechanics.contact.Contact`, which may raise to end the run. Raises as `next_frame`,
        SceneError for the Checkpoint of another scene.
        """
        checkpoint = checkpoint or Checkpoint()
        refuse_other(self.scene, checkpoint.scene, "checkpoint")
        left = whole = time_limit(self.scene, whole)
        while not checkpoint.done:
            begun, last = thread_time(), deadline(limit) if whole == inf else deadline(left, inf, whole)
            frame, checkpoint = self.next_frame(checkpoint, observe or last)
            left -= thread_time() - begun
            yield frame, checkpoint

    @computation
    def next_frame(self, checkpoint, observe=None) -> tuple[Frame, Checkpoint]:
        """(frame, checkpoint) of the increment that `checkpoint` stands before.

        Raises NotConverged; SceneError for the Checkpoint of another scene; what `observe` raises.
        """
        refuse_other(self.scene, checkpoint.scene, "checkpoint")
        load_steps = checkpoint.load_steps or load_steps_of(self.scene)
        step = next(step for step in load_steps if step.stage == checkpoint.stage)
        stepper = self._stepper_of(step, checkpoint)
        stepper.problem.contact.observe = observe
        before = stepper.problem.evaluations
        load = step.at(checkpoint.increment)
        state = checkpoint.state or State.at_rest(load, stepper.problem.undeformed(load))
        index, done, trace = self._increment(step, checkpoint.increment, state, checkpoint.trace or Trace.of(state))
        self.done, problem = done, stepper.problem
        events = tuple(self._event(step, slip) for slip in done.slips)
        numbers = step.stage, index, done.state.residual, problem.evaluations - before
        frame = frame_of(self.scene, problem, done.state, *numbers, events, done.repeated)
        return frame, checkpoint._replace(**self._after(checkpoint, load_steps, step, index, done.state, trace))

    def _increment(self, step, index, state, trace):
        """(index, Increment, Trace) of the next increment of `step`, from `index` on, that has an equilibrium.

        After a slip, the surface may rest only at a higher load: increments before that have no frame. If that load is
        beyond the last increment, the last one takes the state.
        """
        repeats = self._fast and self.replay and not step.loading.direction[1]
        load, slips, spacing = step.at(index), (), self.scene.spacing if repeats else None
        try:
            done, trace = advanced(self.stepper, state, load, trace, spacing)
            while done.state.load > load and index < step.increments:
                slips += done.slips
                index += 1
                load, done = step.at(index), done._replace(slips=())
                if done.state.load <= load:
                    done, trace = advanced(self.stepper, done.state, load, trace, spacing)
        except NotConverged as failure:
            raise with_remedy(failure, self.scene, step, load, self._fast) from None
        return index, done._replace(slips=slips + done.slips), trace

    def _stepper_of(self, step, checkpoint):
        """The stepper of a step."""
        place = step, checkpoint.pressure
        if self._place == place:
            return self.stepper
        scene = self.scene
        pressure = checkpoint.pressure if step.held else None
        problem = Equilibrium(Contact(scene, *self.patch), step.loading, pressure)
        options = {"far": far_of(scene)} if self._fast else {}
        method = METHODS.get(self.method, self.method)
        self.stepper, self._place = method(problem, scene.damping, closed_stiffness(scene), **options), place
        return self.stepper

    def _after(self, checkpoint, load_steps, step, index, state, trace):
        """What is new of the Checkpoint after increment `index`: one on, or at the beginning of the next step."""
        problem, last = self.stepper.problem, index >= step.increments
        if last and step.until_free and not self._free(step, problem, state):
            load_steps, last = stretched(load_steps, step), False
        progress = {"increment": index + 1, "state": state, "trace": trace, "load_steps": load_steps}
        progress["scene"] = self.scene
        if not last:
            return progress
        following = load_steps[load_steps.index(step) + 1 :]
        if not following:
            return progress | {"increment": index, "done": True}
        pressure = checkpoint.pressure
        if not step.held:
            pressure = problem.contact.pressure(problem.traction(state.v)[1])
        state = _turned(problem, state, step.held, following[0])
        begun = {"stage": following[0].stage, "increment": 0, "state": state, "trace": Trace.of(state, trace.jumps)}
        return progress | begun | {"pressure": pressure}

    def _free(self, step, problem, state):
        """Whether a retraction ends: the layer is undeformed, to FREE, or the top at HIGHEST."""
        if step.end >= HIGHEST * self.scene.delta_0:
            return True
        top = np.array(problem.top(state.v, state.load))[:, None]
        return bool(np.abs(problem.surface(state.v) - top).max() <= FREE * self.scene.delta_n)

    def _event(self, step, slip):
        """The SlipEvent of a slip, an End."""
        scene, T = self.scene, self.stepper.problem.traction(slip.v)
        load = float(step.loading.coordinate(slip.load))
        return SlipEvent(load, *forces_and_area(scene, T), step.stage, slip.kind, slip.located, slip.sensitive)


def with_remedy(failure, scene, step, load, fast=True) -> NotConverged:
    """The same failure of a LoadStep, with the load and a remedy in its message."""
    if isinstance(failure, PulledOff):
        return failure
    if step.stage == "approach" and load == step.start and (stiffer := too_soft(scene)):
        why = "the attraction draws so soft a layer into contact where the approach begins"
        remedy = f"{why}: {stiffer}"
    else:
        remedy = _remedy(failure.outcome, scene, step, fast)
    kind = OutOfTime if isinstance(failure, OutOfTime) else NotConverged
    return kind(f"Not converged at {step.loading.name} = {load:.6g} nm: {failure}; {remedy}", failure.outcome)


def _remedy(outcome, scene, step, fast):
    """What to do about a run that ends so."""
    if outcome is Outcome.OUT_OF_TIME:
        return "allow more time by limit=, or try a larger E"
    if outcome is not Outcome.RESTLESS:
        steps = "or a smaller du_x or du_z" if fast else "a smaller du_x or du_z, or method fast"
        return f"try a larger tolerance, {steps}"
    if scene.damping < 1.0:  # the law has no potential, so that it may feed an oscillation
        return f"try a damping larger than {scene.damping:g}: with so little it may never come to rest"
    soft = any(scene.drive_compliance) or step.held
    overdamped = "damping=inf, " * (soft and scene.damping != inf)
    return f"try {overdamped}another indentation or a larger E{' or a smaller phi_ratio' * (scene.phi_ratio > 0.0)}"


def _turned(problem, state, was_held, following):
    """The State at the end of a step as the first of the following LoadStep: another load, no past along it."""
    v, load = state.v, following.at(0)
    if was_held == following.held:
        return State(load, v, [(load, v)], state.secants, mode=state.mode, undecided=state.undecided)
    v = np.append(problem.surface(v).ravel(), problem.top(v, state.load)[1] if following.held else ())
    return State(load, v, [(load, v)], unsure=following.held, undecided=state.undecided)
