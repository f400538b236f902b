"""Between slips: the unstable branch that a slip jumps over, dashed behind the curves."""

from functools import partial
from typing import Any

from app import interface
from app.document import on_loop
from app.features.between import tasks
from app.session import orders
from app.session.orders import order
from solver import Scene
from solver.following.skeleton import Skeleton

PAUSE = 1000  # ms between two branches of a drag, whose predictions need the workers: without, a third fewer came


class Feature(interface.Feature):
    """The unstable branches of the run on screen, computed once a visitor asks for them."""

    ORDER = 30
    PARAMS = {
        "unstable": "asks for the unstable branches of the run, or for no more of them: shown",
        "branches": "unstable branches: list of {U_x, F, L, A}, why, exact (of a run, not of a prediction)",
    }

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.shown = False
        self.skeleton: Skeleton | None = None  # of the newest run or prediction
        self.exact = True  # whether it is that of a run
        self.drawn = self.pauses = False  # whether the browser has something; whether predictions have the workers

    def requested(self, scene: Scene) -> None:
        """Remove the branches: they belong to another scene. Those of predictions follow a held slider."""
        if self.exact or not self.session.pursuit.held:
            self._clear()
        self.skeleton = None

    def predicted(self, skeleton: Skeleton) -> None:
        """Compute the branch of a prediction, PAUSE after that of an earlier one."""
        self.skeleton, self.exact = skeleton, False
        if not self.pauses:
            self._ask()

    def ended(self, run: Any, skeleton: Skeleton | None) -> None:
        """Compute the branches of a run, if it can be followed."""
        self.skeleton, self.exact = skeleton, True
        self._clear() if skeleton is None else self._ask()

    @order("unstable", shown=orders.is_flag)
    def show(self, shown: bool) -> None:
        """Compute the branches from now on, or no longer."""
        self.shown = shown
        self._ask()

    def _clear(self):
        self.cancel()
        if self.shown and self.drawn:
            self._send([], "", True)

    def _send(self, branches, why, exact):
        self.drawn = bool(branches or why)
        self.session.send("branches", list=branches, why=why, exact=exact)

    def _ask(self):
        if not self.shown or self.skeleton is None:
            self.cancel()
        elif self.exact or not self.waiting:
            call = tasks.branches, self.skeleton, self.exact
            self.ask(call, partial(self._made, self.skeleton, self.exact), private=not self.exact)

    def _made(self, skeleton, exact, made):
        branches, why = made or ([], "The unstable branch could not be computed.")
        self._send(branches, why, exact)
        if not exact:
            self.pauses = True
            self.session.doc.add_timeout_callback(on_loop(self._go_on, skeleton), PAUSE)

    def _go_on(self, skeleton):
        self.pauses = False
        if not self.session.closed and not self.exact and self.skeleton is not skeleton:
            self._ask()
