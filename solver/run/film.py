"""Slow motion through a slip: repeat one increment of a run and keep the states of its transient."""

from dataclasses import replace
from itertools import pairwise
from math import inf

import numpy as np

from ..continuation.state import State
from ..scene import Scene
from .carry import checkpoint_at
from .frame import Frame, frame_of
from .load_steps import LoadStep, load_steps_of, vertical
from .loadpath import Run, deadline

ALIKE = 1e-3  # delta_t between nodes of a flat that are alike: where waves have grown they differ by a good part of it
APART = 0.01  # units between states of a motion that are kept: a hundred to a site


def through(
    scene: Scene, before: Frame, stage: str, load: float, most: int = 60, limit: float = inf
) -> tuple[list[Frame], Frame]:
    """(Frames of the motion, the Frame in which the increment ends) of the increment of `stage` to `load`, nm.

    before: the Frame before it, with u right to 1e-2 nm. Frames of a motion are no equilibria, and `residual`
    shows by how much. They lead from the end of the branch to the next equilibrium, at even distances of the node that
    moves most. There are none if the branch does not end. limit: s of processor time.
    Raises NotConverged, and ValueError where a flat's nodes are not alike.
    """
    if scene.surface == "flat":
        if np.ptp(before.u, axis=1).max() > ALIKE * scene.delta_t:
            raise ValueError("not all nodes of this flat are alike, and only some of them are at hand")
        before = replace(before, u=before.u[:, :1])
    step = _step(scene, before, stage)
    start = step.loading.load_of(before)
    step = replace(step, start=start, increment=load - start, increments=1, end=load, until_free=False)
    run, camera, states, moving = Run(scene), Camera(deadline(limit)), [], []
    for end, _ in run.frames(checkpoint_at(before, (step,)), observe=camera):  # noqa: B007  the last one counts
        states += [state for slip in run.done.slips for state in camera.film(run.stepper.problem, slip)]
    for problem, v, active, load in _evenly(states, most):
        residual = problem.residual(v, active, load, np.empty(v.size))
        moving.append(frame_of(scene, problem, State.at_rest(load, v, active), stage, 1, residual))
    return moving, end


class Camera:
    """Observes evaluations: keeps states (problem, v, active, load) of every motion, and calls `late`, unless None."""

    def __init__(self, late):
        self.reels, self._late, self._y = [], late, None

    def __call__(self, surface=None, y=None, active=None, load=None):
        if self._late:
            self._late()
        if surface is None:
            return
        if y is not self._y:  # another motion
            self.reels.append([])
            self._y = y
        v, reel = surface.unknowns(y), self.reels[-1]
        if not reel or np.abs(v - reel[-1][1]).max() > APART * surface.problem.unit:
            reel.append((surface.problem, v, active, load))

    def film(self, problem, slip) -> list[tuple]:
        """The states of a motion that led from the End of a branch to its rest, with both."""
        load, v, active = slip.after[:3]
        reels = [reel for reel in self.reels if reel[0][1].size == v.size]
        reel = min(reels, key=lambda reel: np.abs(reel[-1][1] - v).max(), default=[])
        return [(problem, slip.v, slip.active, slip.load), *reel, (problem, v, active, load)]


def _step(scene, before, stage):
    """The LoadStep of a stage, at the indentation that `before` has."""
    if stage == "press":
        sign = 1.0 if scene.delta > before.delta else -1.0
        return LoadStep(stage, vertical(sign, before.U_x), 0.0, 1.0, 1)
    return next(step for step in load_steps_of(scene) if step.stage == stage)


def _evenly(states, most):
    """At most so many of the states (problem, v, active, load), at even distances of the node that moves most."""
    if len(states) <= most:
        return states
    distance = [0.0]
    for (_, v, *_), (_, w, *_) in pairwise(states):
        distance.append(distance[-1] + (float(np.abs(w - v).max()) if v.size == w.size else 0.0))
    return [states[k] for k in np.unique(np.searchsorted(distance, np.linspace(0.0, distance[-1], most)))]
