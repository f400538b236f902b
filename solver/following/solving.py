"""Solves one problem for state after state, with secant pairs kept from each to the next; failures are NotFollowed."""

from contextlib import contextmanager

import numpy as np

from ..continuation.anderson import dot
from ..continuation.corrector import Corrector
from ..continuation.rest import Judge
from ..continuation.state import State
from .branch import TOLERANCE, Crowded, NotFollowed

FEW = 3  # unknowns: one node stands for all, which does not show waves
COME_AND_GO = 3  # changes of the set of active nodes on an arc, at most


class Solving:
    """Of a problem as of `continuation.problem`."""

    def __init__(self, problem, damping=1.0):
        """damping: of the motion, over critical."""
        self._least = problem.tolerance
        problem.tolerance = max(TOLERANCE, self._least)
        self.problem, self.corrector = problem, Corrector(problem)
        self.moving = int(np.count_nonzero(problem.direction))  # unknowns that move on with the load; they come first
        self.secants, self.begun, self.damping = self.corrector.secants(), False, damping

    def at(self, guess, active, load, what):
        """(v, active) of the state at fixed load next to a guess."""
        v, active = self._begin(guess, active, load)
        active = self.corrector.settle(v, active, load, self.secants)
        if active is None:
            raise NotFollowed(f"{what} is not found", nearer=True)
        return self._checked(v, active, load, what)

    def on_arc(self, guess, active, load, chord, what):
        """(load, v, active) of the state with the same <chord, v> as a guess nearby."""
        v, active = self._begin(guess, active, load)
        arc = dot(chord, v)
        for _ in range(COME_AND_GO):
            load = self.corrector.solve_on_arc(v, active, load, self.secants, chord, arc)
            if load is None:
                raise NotFollowed(f"{what} is not found", nearer=True)
            again = self.problem.active(v, load, active)
            if again is active:
                break
            active = again
        return load, *self._checked(v, active, load, what)

    @contextmanager
    def within(self, tolerance):
        """Solve to another tolerance, nm."""
        problem, usual = self.problem, self.problem.tolerance
        problem.tolerance = max(tolerance, self._least)
        try:
            yield
        finally:
            problem.tolerance = usual

    @contextmanager
    def apart(self):
        """Solve apart from the other states: nothing learnt there is kept."""
        kept, self.secants = self.secants, self.corrector.secants()
        try:
            yield
        finally:
            self.secants, self.begun = kept, False

    def _begin(self, guess, active, load):
        v = guess.copy()
        active = self.problem.active(v, load, active)
        if not self.begun:
            self.corrector.begin(State.at_rest(load, guess, active))
            self.begun = True
        return v, active

    def _checked(self, v, active, load, what):
        problem = self.problem
        if problem.grown(v, active, load) is not None:
            raise Crowded(f"{what} needs a wider patch")
        if problem.size <= FEW and Judge(self.damping).rightmost(problem, v, active).hidden:
            raise NotFollowed(f"at {what} waves grow")
        return v, active
