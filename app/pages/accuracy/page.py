"""The page "Accuracy": error over run time and force evaluations of each method, for the scene on screen.

A worker measures (service/bench.py), until the scene changes.
"""

import logging
from math import ceil, floor, log10
from typing import Any

from bokeh.models import FixedTicker
from bokeh.models.glyphs import Line, Scatter, Text

from app.pages import Sheet
from app.pages.notebook import laid_out, page_of
from app.service import bench
from app.service.pool import HEAVY
from app.views.plots import blank, draw
from solver import Scene

log = logging.getLogger("app")
TITLE, ORDER, FIGURES = "Accuracy", 8, ("seconds", "evaluations")
SERIES = {  # method: marker, colour; offset (px, right and down) and alignment of the tolerance beside its point
    "fast": ("circle", "--repulsive", 9, -6, "left"),
    "gfmd": ("square", "--adhering", 9, -6, "left"),
}
WHY = {
    "crash": "the worker ended unexpectedly. Measure again",
    "hang": f"it took longer than {bench.LONGEST:g} s. Choose a less expensive scene",
    "error": "it could not be measured; the server's log says why",
}
WORK = {"seconds": "time of one core (s)", "evaluations": "force evaluations"}


def compose() -> list[Any]:
    """Return both figures, on logarithmic axes."""
    return [_figure(name, label) for name, label in WORK.items()]


def _figure(work, label):
    axes = {"x_axis_type": "log", "y_axis_type": "log"}
    plot = blank(f"accuracy_{work}", label, "relative error", **axes)
    for series, (marker, colour, right, down, align) in SERIES.items():
        draw(plot, Line, f"way {series}", colour, work, "error", line_width=2)
        look = {"tooltips": [("", "@label")], "marker": marker, "size": 9}
        draw(plot, Scatter, f"mark {series}", colour, work, "error", "label", **look)
        look = {"x_offset": right, "y_offset": down, "text_align": align, "text_font_size": "12px"}
        draw(plot, Text, series, colour, work, "error", "text", **look)
    plot.xaxis.ticker = FixedTicker(ticks=[10.0**decade for decade in range(-5, 9)])
    return plot


def figure(scene: Scene) -> Any:
    """Measure error over run time and force evaluations of a Scene, for a notebook."""
    page = page_of(compose, Page, scene)
    for news in bench.reports(scene):
        page.report |= news
    page.start()
    return laid_out(page)


class Page(Sheet):
    """The page of one visitor; see app/pages. It stays: a measurement continues while the page is closed."""

    stays = True

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.report = {}  # what the last measurement has reported

    def start(self) -> None:
        """Show the last measurement."""
        self._show({})

    def scene_changed(self) -> None:
        """End the measurement of the previous scene. Its results stay."""
        self._stop("the scene has changed")

    def order(self, values: dict[str, Any]) -> None:
        """Start or cancel a measurement."""
        if values.get("what") == "measure":
            self.close()
            scene = self.session.scene
            self.report = {"state": "waiting", "progress": 0.0, "scene": scene}
            self._show({})
            log.info("a measurement begins")
            how = {"rank": HEAVY, "seconds": bench.LONGEST, "private": True, "streams": True}
            self.single.add_one((bench.work, scene), self._ended, hear=self._show, **how)
        elif values.get("what") == "cancel":
            self._stop()

    def _stop(self, why=""):
        if self.single.waiting:
            self.close()
            self.report |= {"state": "cancelled", "why": why}
            log.info("a measurement ends early")
        self._publish_texts()

    def _ended(self, result):
        log.info("a measurement has ended")
        if isinstance(result, Exception):
            why = WHY.get(getattr(result, "kind", ""), WHY["error"])
            self._show({"state": "failed", "why": why})

    def _show(self, news):
        self.report |= news
        self._draw(self.report.get("points", ()))
        self._publish_texts()

    def _publish_texts(self):
        report, now = self.report, _description(self.session.scene)
        state, why = report.get("state"), report.get("why", "")
        before = _description(report.get("scene", self.session.scene))
        busy = report["progress"] if state in ("waiting", "measuring") else None
        text = {
            None: "takes 10 s to 2 minutes",
            "waiting": "getting ready, or waiting for other visitors",
            "measuring": f"{busy or 0.0:.0%}",
        }.get(state, f"{state}: {why}" if why else state)
        text += f", with {before}" if busy is None and before != now else ""
        texts = {"scene": now, "state": text, "sentence": report.get("sentence", "")}
        texts |= {"others": " ".join(report.get("others", ()))}
        self.publish(busy=busy, texts={f"accuracy-{name}": text for name, text in texts.items()})

    def _draw(self, points):
        for work in WORK:
            for series in SERIES:
                of = [point for point in points if point["series"] == series]
                place = {name: [point[name] for point in of] for name in (work, "error")}
                self.draw(work, f"way {series}", **place)
                self.draw(work, f"mark {series}", **place, label=[_point(point) for point in of])
                self.draw(work, series, **place, text=[_power(point["tolerance"]) for point in of])
            figure = self.views[work].figure
            for axis, name, least in ((figure.x_range, work, 2), (figure.y_range, "error", 3)):
                low, high = _decades([point[name] for point in points], least)
                axis.update(start=low, end=high)


def _decades(values, least):
    """Return powers of ten around the values, at least `least` decades apart."""
    low, high = log10(min(values, default=1.0)) - 0.2, log10(max(values, default=1.0)) + 0.2
    return 10.0 ** min(floor(low), ceil(high) - least), 10.0 ** ceil(high)


def _description(scene):
    return f"δ/δ₀ = {scene.delta_bar:g}, φₜ/φₙ = {scene.phi_ratio:g}, E = {scene.E:g} GPa".replace("-", "−")


def _point(p):
    work = f"{p['seconds']:.2g} s, {p['evaluations']} evaluations"
    return f"{p['series']}, tolerance {_power(p['tolerance'])} nm: error {_power(p['error'])}, {work}"


def _power(value):
    """Format a value with one digit, as 1e−5."""
    return f"{value:.0e}".replace("e-0", "e-").replace("-", "−")
