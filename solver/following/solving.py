"""Solves one problem for state after state, with secant pairs kept from each to the next; failures are NotFollowed."""

from contextlib import contextmanager

import numpy as np

from ..continuation.anderson import dot
from ..continuation.corrector import Corrector
from ..continuation.state import State
from .branch import TOLERANCE, Crowded, NotFollowed

STEPS = 60  # Anderson steps to a state, at most
COME_AND_GO = 3  # changes of the set of active nodes on an arc, at most


class Solving:
    """Of a problem as of `continuation.problem`."""

    def __init__(self, problem):
        self._least = problem.tolerance
        problem.tolerance = max(TOLERANCE, self._least)
        self.problem, self.corrector = problem, Corrector(problem)
        self.moving = int(np.count_nonzero(problem.direction))  # unknowns that move on with the load; they come first
        self.secants, self.begun = self.corrector.secants(), False

    def at(self, guess, active, load, what):
        """(v, active) of the state at fixed load next to a guess."""
        v, active = self._begin(guess, active, load)
        active = self.corrector.settle(v, active, load, self.secants, STEPS)
        if active is None:
            raise NotFollowed(f"{what} is not found", nearer=True)
        return self._checked(v, active, load, what)

    def on_arc(self, guess, active, load, chord, what):
        """(load, v, active) of the state with the same <chord, v> as a guess nearby."""
        v, active = self._begin(guess, active, load)
        arc = dot(chord, v)
        for _ in range(COME_AND_GO):
            load = self.corrector.solve_on_arc(v, active, load, self.secants, STEPS, chord, arc)
            if load is None:
                raise NotFollowed(f"{what} is not found", nearer=True)
            again = self.problem.admitted(v, active)
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
        kept = self.secants.copy()
        self.secants.forget()
        try:
            yield
        finally:
            self.begun = False
            self.secants.restore(kept)

    def _begin(self, guess, active, load):
        v = guess.copy()
        active = self.problem.admitted(v, active)
        if not self.begun:
            self.corrector.begin(State.at_rest(load, guess, active))
            self.begun = True
        return v, active

    def _checked(self, v, active, load, what):
        if self.problem.crowded(v, active, load):
            raise Crowded(f"{what} needs a wider patch")
        if self.problem.hides(v, active):
            raise NotFollowed(f"at {what} waves grow")
        return v, active
