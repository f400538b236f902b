"""The page "Accuracy": error of F, L and A over run time and force evaluations, by the solver and the paper's GFMD.

from app.lab.accuracy import view; view(Scene(E=140))
"""

import json
from pathlib import Path
from time import monotonic
from typing import Any

import holoviews as hv
import panel as pn
import param

from app.lab.base import WIDE, LabPage
from app.service.jobs import jobs
from app.service.pool import HEAVY
from solver import Scene
from solver.accuracy.compare import Point
from solver.accuracy.measure import measure
from solver.live_plots import WORKS, work_precision

TITLE = "Accuracy"
STORED = json.loads(Path(__file__).with_suffix(".json").read_text(encoding="utf-8"))  # by tests/bench/curves.py
LONGEST = 600.0  # s, time limit of a measurement
APART = 0.5  # s between two drawings: one takes the server 0.1 s


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
        self.points, drawn = [], 0.0
        how = {"rank": HEAVY, "seconds": LONGEST, "private": True, "streams": True}
        async for share, report in jobs.parts(measure, self.scene, True, owner=id(self), **how):
            self.share = share
            points = report.of("tolerance") if report else []
            if len(points) > len(self.points) and monotonic() > drawn + APART:
                self.points, drawn = points, monotonic()
        self.points = points
        self.text = cost(points)

    def content(self) -> list[Any]:
        before = [Point(**row) for row in STORED["points"]]
        draw = {work: lambda points, work=work: work_precision(points, work, before) for work in WORKS}
        plots = [hv.DynamicMap(pn.bind(draw[work], self.param.points)) for work in WORKS]
        return [pn.FlexBox(*(pn.pane.HoloViews(plot, styles=WIDE) for plot in plots))]


def cost(points: list[Any], tolerance: float = 1e-8) -> str:
    """Return a sentence on the cost and the accuracy of a tolerance, nm."""
    runs = {(p.series, p.value): p for p in points if p.branch_error is not None and not p.failure}
    fast = {value: p for (series, value), p in runs.items() if series == "fast"}
    if tolerance not in fast:
        return f"No run at tolerance {tolerance:g} nm was finished."
    own, cheapest = fast[tolerance], fast[max(fast)]
    times = own.evaluations / max(1, cheapest.evaluations)
    return (
        f"Tolerance {tolerance:g} nm gives F, L and A to {own.branch_error:.0e} for {own.evaluations} force evaluations"
        f" ({own.seconds:.2g} s), {times:.2g} times those at {cheapest.value:g} nm."
    )


def view(scene: Scene | None = None) -> pn.viewable.Viewable:
    """Return the page for a Scene (default: the default Scene)."""
    return Accuracy(scene).view()
