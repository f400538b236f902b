"""The page "Map": the first slip over two parameters, regimes outlined and named; a click loads that scene.

Each row of the map is one call for the workers, its points followed from their neighbours or run
(solver/analysis/maps); rows come from coarse to fine, and what one visitor has asked for is there for all (sweep.py).
"""

import holoviews as hv
import numpy as np
from bokeh.models import FixedTicker

from app.service import tasks
from app.service.sweep import Sweep
from app.session.controls import DEFAULT
from app.views.pages import Sheet
from app.views.plots import curve, dots, rendered
from solver import SceneError
from solver.analysis.maps import REGIMES, Axis

COLUMNS, ROWS = 17, 13
RANGES = {  # of what may be chosen: low, high, whether even in the logarithm
    "delta_bar": (-0.3, 1.0, False),
    "phi_ratio": (0.05, 2.0, True),
    "E": (15.0, 1000.0, True),
    "phi_n": (0.5, 5.0, True),
    "nu": (0.1, 0.45, False),
}
QUANTITIES = {  # of a Point: what the page calls it, and what it is times
    "F_s": ("Fₛ (N/m)", lambda scene: scene.width * scene.E),
    "U_s": ("Uₛ (nm)", lambda scene: 1.0),
    "A_s": ("Aₛ (nm)", lambda scene: scene.width),
    "asymmetry": ("peel asymmetry", lambda scene: 1.0),
    "sites": ("sites of a slip", lambda scene: 1.0),
    "reattached": ("share reattached", lambda scene: 1.0),
}
LABELS = 6  # ticks of an axis
COLUMN, ROW = hv.Dimension("i", label="x"), hv.Dimension("j", label="y")


def compose():
    """The map over numbers of columns and rows, for its axes may be logarithmic."""
    bounds = (-0.5, -0.5, COLUMNS - 0.5, ROWS - 0.5)
    image = hv.Image(np.zeros((2, 2), dtype=np.float32), [COLUMN, ROW], "value", bounds=bounds, label="map")
    image.opts(default_tools=[], cmap="cividis", tools=["hover"], hover_tooltips=[("", "@image{0.000}")])
    names = hv.Labels(([], [], []), [COLUMN, ROW], "name", label="names").opts(text_color="white")
    elements = [image, curve("outline", COLUMN, ROW, line_width=3), names]
    elements.append(dots("own", COLUMN, ROW, marker="diamond", size=14))
    figure = rendered(
        "regimes_map",
        elements,
        {"outline": "--cut", "own": "--cut"},
        x=(bounds[0], bounds[2]),
        y=(bounds[1], bounds[3]),
    )
    text = next(part for part in figure.renderers if part.name == "regimes_map.names").glyph
    text.update(background_fill_color="black", background_fill_alpha=0.6, text_font_size="13px")
    return [figure]


class Page(Sheet):
    """See pages.py."""

    def __init__(self, *given):
        super().__init__(*given)
        self.sweep = Sweep(self.session, self._take)
        self.names, self.of, self.points = ("delta_bar", "phi_ratio"), "F_s", {}
        self.base = self.axes = None

    def scene_changed(self):
        """Another map only where something else than its axes has changed."""
        try:
            scene = self._base(self.session.scene)
        except SceneError as error:
            self.sweep.cancel()
            return self.publish(texts={"regimes-said": f"Not drawn: {error}"}, busy=None)
        if scene == self.base:
            return self._draw()
        self._begin(scene)

    def order(self, values):
        """Other axes, another quantity, a click at {i, j}, or cancel."""
        what, names = values.get("what"), (values.get("x"), values.get("y"))
        if what == "cancel":
            self.sweep.cancel()
        elif what == "axes" and set(names) <= RANGES.keys() and names[0] != names[1]:
            self.names = names
            return self.scene_changed()
        elif what == "of" and values.get("of") in QUANTITIES:
            self.of = values["of"]
        elif what == "go" and self.axes and values.keys() >= {"i", "j"}:
            at = (round(float(np.clip(float(values[k]), 0, n - 1))) for k, n in (("i", COLUMNS), ("j", ROWS)))
            self.session.show(self._scene(*at), DEFAULT)
        self._draw()

    def close(self):
        """Ask for nothing any longer."""
        self.sweep.cancel()

    def _base(self, scene):
        """The scene with the map's own parameters where they do not matter."""
        return scene.changed(path="shear", **{name: RANGES[name][0] for name in self.names})

    def _scene(self, i, j):
        values = (float(f"{axis.values[k]:.4g}") for axis, k in zip(self.axes, (i, j), strict=True))
        return self.base.changed(**dict(zip(self.names, values, strict=True)))

    def _begin(self, scene):
        self.sweep.cancel()
        self.base, self.points = scene, {}
        counts = (COLUMNS, ROWS)
        self.axes = [
            Axis(name, low, high, n, log)
            for name, n in zip(self.names, counts, strict=True)
            for low, high, log in (RANGES[name],)
        ]
        rows = sorted(range(ROWS), key=lambda j: next(step for step in range(5) if j % (16 >> step) == 0))
        self._name_axes()
        self._draw()
        self.sweep.add([(tasks.map_row, scene, *self.axes, j) for j in rows])
        self._draw()

    def _take(self, call, result):
        """A row is back from the workers."""
        if isinstance(result, Exception):
            return self._draw(f"One row was not computed: {result}. ")
        self.points |= {(point.i, point.j): point for point in result}
        self._draw()

    # drawing

    def _name_axes(self):
        figure = self.views["map"].figure
        for axis, known, ruler in zip(self.axes, (COLUMNS, ROWS), (figure.xaxis[0], figure.yaxis[0]), strict=True):
            ticks = [round(k) for k in np.linspace(0, known - 1, LABELS)]
            labels = {k: f"{axis.values[k]:.2g}" for k in ticks}
            ruler.update(ticker=FixedTicker(ticks=ticks), major_label_overrides=labels, axis_label=axis.name)

    def _draw(self, before=""):
        if not self.axes:
            return
        image = np.full((ROWS, COLUMNS), np.nan, dtype=np.float32)
        codes = np.full((ROWS, COLUMNS), -1)
        for (i, j), point in self.points.items():
            codes[j, i], value = point.code, getattr(point, self.of)
            if value is not None:
                image[j, i] = value * QUANTITIES[self.of][1](self._scene(i, j))
        view = self.views["map"]
        source = view.parts["map"].data_source
        source.data = dict(source.data) | {"image": [image]}
        low, high = (float(f(image)) if np.isfinite(image).any() else 0.0 for f in (np.nanmin, np.nanmax))
        view.parts["map"].glyph.color_mapper.update(low=low, high=max(high, low + 1e-9))
        outline = outlines(codes)
        self.draw("map", "outline", i=outline[0], j=outline[1])
        named = [(code, *np.argwhere(codes == code).mean(axis=0)) for code in np.unique(codes[codes >= 0])]
        names = {"i": [i for _, _, i in named], "j": [j for _, j, _ in named]}
        self.draw("map", "names", **names, name=[REGIMES[code] for code, *_ in named])
        own = [np.interp(getattr(self.session.scene, a.name), a.values, np.arange(a.count)) for a in self.axes]
        self.draw("map", "own", i=own[:1], j=own[1:])
        self._describe(before, low, high)

    def _describe(self, before, low, high):
        followed = sum(point.followed for point in self.points.values())
        text = f"{before}{len(self.points)} of {COLUMNS * ROWS} points, {followed} of them followed, the others run. "
        limits = {"regimes-low": f"{low:.3g}", "regimes-high": f"{high:.3g} {QUANTITIES[self.of][0]}"}
        self.publish(texts={"regimes-said": text} | limits, busy=self.sweep.part)


def outlines(codes):
    """(i, j): lines between cells of codes (rows, columns) that differ and are known, with nan after each."""
    i, j = [], []
    for axis, corners in ((1, ((0.5, -0.5), (0.5, 0.5))), (0, ((-0.5, 0.5), (0.5, 0.5)))):
        one, other = (np.take(codes, range(k, codes.shape[axis] - 1 + k), axis) for k in (0, 1))
        for row, column in np.argwhere((one != other) & (one >= 0) & (other >= 0)):
            i += [column + di for di, _ in corners] + [np.nan]
            j += [row + dj for _, dj in corners] + [np.nan]
    return i, j
