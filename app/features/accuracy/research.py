"""The page "Accuracy": error of F, L and A over run time and force evaluations, by the solver and the paper's GFMD.

from app.features.accuracy.research import view; view(Scene(E=140))
"""

import json
from functools import partial
from pathlib import Path
from typing import Any

import panel as pn
import param

from app.document import on_loop
from app.features.accuracy.feature import TITLE
from app.features.lab.base import LabPage, side_by_side
from app.service.job import HEAVY
from app.service.jobs import jobs
from solver.accuracy.compare import Point
from solver.accuracy.measure import measure
from solver.live_plots import PALE, WORKS, Curve, work_precision

STORED = json.loads(Path(__file__).with_name("accuracy.json").read_text(encoding="utf-8"))  # by tests/bench/curves.py
BEFORE = [Point(**row) for row in STORED["points"]]
SWEPT = "tolerance"
LONGEST = 600.0  # s, time limit of a measurement


class Accuracy(LabPage):
    """Error over work of a scene, and of the default scene as measured before."""

    TITLE = TITLE
    STATEMENT = (
        "Both methods solve the scene at several tolerances, up to just beyond its first slip. Numbers in the plots:"
        " tolerance (nm). Error: largest relative difference of F, L or A before the first slip from a run with a tenth"
        " of the steps. "
        f"Pale: the default scene, commit {STORED['commit']}, {STORED['date']}, {STORED['processor']}."
    )
    points = param.List(doc="the Points measured so far")

    async def compute(self) -> None:
        """Clear the points of another scene: a measurement takes a worker for a minute, so a button starts it."""
        self.points = []

    async def measure(self) -> None:
        """Measure the scene; what takes less goes first."""
        self.points = []
        how = {"rank": HEAVY, "seconds": LONGEST, "private": True, "streams": True}
        async for share, report in jobs.parts(measure, self.scene, True, None, (SWEPT,), owner=id(self), **how):
            self.param.update(share=share, points=report.of(SWEPT) if report else [])
        self.text = cost(self.points)

    def content(self) -> list[Any]:
        look: dict[str, Any] = {"beside": True, "x_axis_type": "log", "y_axis_type": "log"}
        error = "largest relative error"
        charts = (self.chart(partial(self.curves, work), label, error, **look) for work, label in WORKS.items())
        begin = on_loop(lambda event: self.start(self.measure))
        return [pn.widgets.Button(label="Measure this scene", on_click=begin), side_by_side(*charts)]

    def curves(self, work: str) -> list[Curve]:
        """Return error over work of the scene, and of the default scene."""
        return [*work_precision(self.points, work), *work_precision(BEFORE, work, alpha=PALE)]


def cost(points: list[Any], tolerance: float = 1e-8) -> str:
    """Return a sentence on the cost and the accuracy of a tolerance, nm."""
    fast = {p.value: p for p in points if p.series == "fast" and p.branch_error is not None and not p.failure}
    if tolerance not in fast:
        return f"No run at tolerance {tolerance:g} nm was finished."
    own, cheapest = fast[tolerance], fast[max(fast)]
    times = own.evaluations / max(1, cheapest.evaluations)
    return (
        f"Tolerance {tolerance:g} nm gives F, L and A to {own.branch_error:.0e} for {own.evaluations} force evaluations"
        f" ({own.seconds:.2g} s), {times:.2g} times those at {cheapest.value:g} nm."
    )


view = Accuracy.view
