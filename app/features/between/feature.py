"""Between slips: the unstable branch that a slip jumps over, dashed behind the curves."""

from typing import Any

from app import interface
from app.features.between import tasks
from app.session import orders
from app.session.orders import order
from solver import Scene
from solver.following.skeleton import Skeleton


class Feature(interface.Feature):
    """The unstable branches of the run on screen, computed once a visitor asks for them."""

    ORDER = 30
    PARAMS = {
        "unstable": "asks for the unstable branches of the run, or for no more of them: shown",
        "branches": "unstable branches: list of {U_x, F, L, A}, why; none where they are not known",
    }

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.shown = False
        self.skeleton: Skeleton | None = None

    def requested(self, scene: Scene) -> None:
        """Remove the branches: they belong to another scene."""
        self.cancel()
        if self.skeleton is not None and self.shown:
            self.session.send("branches", list=[], why="")
        self.skeleton = None

    def ended(self, run: Any, skeleton: Skeleton | None) -> None:
        """Compute the branches of a run."""
        self.skeleton = skeleton
        self._ask()

    @order("unstable", shown=orders.is_flag)
    def show(self, shown: bool) -> None:
        """Compute the branches from now on, or no longer."""
        self.shown = shown
        self._ask()

    def _ask(self):
        if not self.shown:
            self.cancel()
        elif self.skeleton is not None:
            self.ask((tasks.branches, self.skeleton), self._made)

    def _made(self, made):
        branches, why = made or ([], "The unstable branch could not be computed.")
        self.session.send("branches", list=branches, why=why)
