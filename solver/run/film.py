"""Slow motion through a slip: repeat one increment of a run and keep the states of its transient."""

from itertools import pairwise
from math import inf

import numpy as np

from ..continuation.state import State
from ..continuation.trace import SAME_STATE
from ..scene import Scene
from .frame import Frame, frame_of
from .loadpath import Checkpoint, Run, deadline


def through(scene: Scene, checkpoint: Checkpoint, most: int = 60, limit: float = inf) -> tuple[list[Frame], Frame]:
    """(Frames of the motion, the Frame in which the increment ends) of the increment that a Checkpoint stands before.

    Frames of a motion are no equilibria, and `residual` shows by how much. They lead from the end of the branch to the
    next equilibrium, at even distances of the node that moves most. There are none if the branch does not end.
    limit: s of processor time. Raises NotConverged.
    """
    run, camera, moving = Run(scene, replay=False), Camera(deadline(limit)), []
    end, _ = run.next_frame(checkpoint, camera)
    states = [state for slip in run.done.slips for state in camera.film(run.stepper.problem, slip)]
    for problem, v, load in _evenly(states, most):
        residual = problem.residual(v, load, np.empty(v.size))
        moving.append(frame_of(scene, problem, State.at_rest(load, v), end.stage, end.index, residual))
    return moving, end


class Camera:
    """Observes evaluations: keeps states (problem, v, load) of every motion, and calls `late`, unless None."""

    every_step = True  # of a motion

    def __init__(self, late):
        self.reels, self._late, self._y = [], late, None

    def __call__(self, surface=None, y=None, load=None):
        if self._late:
            self._late()
        if surface is None:
            return
        if y is not self._y:  # another motion
            self.reels.append([])
            self._y = y
        v, reel = surface.unknowns(y), self.reels[-1]
        if not reel or np.abs(v - reel[-1][1]).max() > SAME_STATE * surface.problem.unit:
            reel.append((surface.problem, v, load))

    def film(self, problem, slip) -> list[tuple]:
        """The states of a motion that led from the End of a branch to its rest, with both."""
        load, v = slip.after[:2]
        reels = [reel for reel in self.reels if reel[0][1].size == v.size]
        reel: list[tuple] = min(reels, key=lambda reel: np.abs(reel[-1][1] - v).max(), default=[])
        return [(problem, slip.v, slip.load), *reel, (problem, v, load)]


def _evenly(states, most):
    """At most so many of the states (problem, v, load), at even distances of the node that moves most."""
    if len(states) <= most:
        return states
    distance = [0.0]
    for (_, v, *_), (_, w, *_) in pairwise(states):
        distance.append(distance[-1] + (float(np.abs(w - v).max()) if v.size == w.size else 0.0))
    return [states[k] for k in np.unique(np.searchsorted(distance, np.linspace(0.0, distance[-1], most)))]
