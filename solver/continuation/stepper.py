"""What a run asks of a method: the contract of a stepper, on which tests/solver/test_contract.py tests every method.

`quasistatic.QuasiStatic`, `gfmd.Gfmd`, `replay.Replay` around a stepper, and the methods of `solver.validation` fulfil
it. A stepper is made of a problem, the damping of the transient over critical, and the stiffness of closed springs,
GPa/nm (see `motion.Motion`); Replay of a stepper and the lattice period, nm.
"""

from typing import Protocol

from .problem import Problem
from .state import Increment, State


class Stepper(Protocol):
    """Advances States of one problem along its load.

    1. The state that an increment returns has a residual within the problem's tolerance.
    2. Its load is the target. It is higher only after a slip, where no equilibrium is reached before.
    3. A jump to another equilibrium is a slip of the increment, at a load from the state's up to the target's.
    4. Slips come in the order of their loads; the branch of each begins in the state `after` the one before.
    5. Where no equilibrium is reached, NotConverged is raised.
    6. The given state stays valid: from it the increment can be made again.
    7. `problem` has the unknowns of the state returned last: a wider one takes its place where a state needs it.
    8. Between increments it keeps nothing but scratch: the state alone determines the next one.
    """

    @property
    def problem(self) -> Problem:
        """The problem that it advances now."""

    def increment(self, state: State, target: float) -> Increment:
        """The Increment from `state` to load `target`, nm, which is higher than the state's; raises NotConverged."""
