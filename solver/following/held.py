"""The equilibrium at the end of the approach, at the scene's indentation: its load is held in shear."""

import numpy as np

from ..continuation.inverse import Solves
from ..mechanics.contact import Contact
from ..mechanics.equilibrium import Equilibrium
from ..run.loading import sideways
from .branch import NotFollowed
from .skeleton import Held
from .solver import Solver

FINE = 1e-8  # nm, of the residual: derivatives of the pressure are asked for to 1e-5
FARTHEST = 1.5  # units that it may move beside the change of the indentation: farther off, it is on another branch
ACCURACY = 1e-3  # of a linear solve, of which only a sign is used
WHAT = "the state whose load is held"


def followed_held(contact: Contact, old: Held, moved: float = 0.0) -> Held:
    """The Held of a Contact's scene, from that of a scene nearby of an indentation smaller by `moved`, nm.

    Raises NotFollowed where one of them is stable under its load and the other is not.
    """
    problem = Equilibrium(contact, sideways(1.0, -contact.scene.delta))
    solver = Solver(problem, tolerance=FINE)
    v, active = solver.state(old.v, old.active, 0.0, WHAT, FARTHEST + abs(moved) / problem.unit)
    kind = "" if _stiffens(problem, v, active) else "control"
    if old.kind is not None and bool(kind) != bool(old.kind):
        raise NotFollowed(f"{WHAT} is {'un' if kind else ''}stable under it, unlike before")
    return Held(v, active, old.kind or kind)


def _stiffens(problem, v, active):
    """Whether the pressure rises with the indentation; else the state is unstable under a held load."""
    linearised, lower = problem.linearised(v, active), np.repeat([0.0, 1.0], problem.nodes)
    lowered = Solves(linearised)(lower, accuracy=ACCURACY)  # by a unit of indentation
    return problem.contact.pressure(linearised.pull(lowered)[1]) > 0.0
