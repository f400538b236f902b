"""The page "Map of regimes": the first slip over two parameters, with named regimes. A click or a drag selects a scene.

A worker computes each point (solver/analysis/maps) in one call, from coarse to fine. All visitors share the results
(requests.py).
"""

import pickle
from dataclasses import replace
from math import dist, inf
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from app.features.pages.sheet import Sheet
from app.features.regimes import tasks
from app.features.regimes.grid import AXES, COLUMNS, FIRST, ROWS, grid_of
from app.features.regimes.store import stored
from app.service import metrics
from app.service.cache import Cache
from app.service.job import HEAVY
from solver import Scene, SceneError
from solver.analysis.maps import REGIMES, Point
from solver.following.skeleton import Skeleton
from solver.scene import PARAMETERS

TITLE, ORDER = "Map of regimes", 6
AT_ONCE = 8  # points that a visitor waits for: enough for all workers; later ones start from more known points
QUANTITIES = {  # of a Point: label and unit
    "F_s": ("friction Fₛ", "N/m"),
    "U_s": ("displacement Uₛ", "nm"),
    "A_s": ("contact area Aₛ", "nm"),
    "asymmetry": ("peel asymmetry", ""),
    "sites": ("sites of a slip", ""),
    "reattached": ("share reattached", ""),
    "L_min": ("largest pull, load L", "N/m"),
}
# Pickled Skeletons by Scene, for all visitors: 200 MB. Without one nearby, a point of a map needs a full run
skeletons = Cache(200e6)
metrics.gauge("skeletons_bytes", "bytes of the states of maps in the cache", lambda: skeletons.currsize)
MORE = 0.1  # of the points that are drawn, after which a map is drawn again
MARGIN = 2.0  # least distance of a regime's name from the edges, columns or rows
MOST = (2.0, 98.0)  # percentiles of the values at the limits of the colours
LETTER, LINE = 0.55, 2.5  # width of a letter in columns and height of a line in rows, on the narrowest map


class Page(Sheet):
    """The page of one visitor; see app/features/pages."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.names, self.of = FIRST, "F_s"
        self.grid, self.known = None, {}  # {(i, j): (Point, Scene of its cached Skeleton or None)}
        self.left = []  # (i, j) not requested yet, the next one last
        self.asking = False
        self.drawn = 0  # known points of the last picture

    def scene_changed(self) -> None:
        """Start another map only if a parameter that is not on its axes changed."""
        try:
            grid = self._around(self.session.scene)
        except SceneError as error:
            self.sweep.cancel()
            self.grid, self.known = None, {}
            return self.publish(texts={"regimes-text": f"Not drawn: {error}"}, busy=None, map=None)
        if grid != self.grid:
            self._begin(grid)
        self._draw()

    def order(self, values: dict[str, Any]) -> None:
        """Change the axes or the quantity, cancel, or resume."""
        what, names = values.get("what"), (str(values.get("x")), str(values.get("y")))
        if what in ("cancel", "resume") and self.grid is not None:
            self.sweep.cancel()
            if what == "resume":
                self._ask_anew()
            return self._draw()
        if what == "axes" and set(names) <= AXES.keys() and names[0] != names[1]:
            self.names = names
        elif what == "of" and values.get("of") in QUANTITIES:
            self.of = values["of"]
        self.scene_changed()

    def nearer(self, scene: Scene, origin: Scene | None) -> Skeleton | None:
        """See Sheet: a drag on the map continues from the nearest point of the map, even after a jump."""
        if not self._holds(scene):
            return None
        here = self._place_of(scene)
        known = [(dist(place, here), key) for place, (_, key) in self.known.items() if key in skeletons]
        off, nearest = min(known, key=lambda one: one[0], default=(inf, None))
        held = origin is not None and self._holds(origin)
        nearer = off < (dist(self._place_of(origin), here) if held else inf)
        return pickle.loads(skeletons[nearest]) if nearer else None

    def _around(self, scene):
        """Return the Map of a scene; raises SceneError."""
        path = "unload" if self.of == "L_min" else "shear"  # a separate map; all its points are runs
        return grid_of(scene, self.names, path)

    def _holds(self, scene):
        """Whether a scene is on the map."""
        others = self.grid and PARAMETERS.keys() - set(self.names)
        return bool(others) and all(getattr(scene, name) == getattr(self.grid.scene, name) for name in others)

    def _place_of(self, scene):
        """Return (i, j) of a scene."""
        return [_place(axis, getattr(scene, axis.name)) for axis in (self.grid.x, self.grid.y)]

    def _begin(self, grid):
        self.sweep.cancel()
        self.grid, self.drawn = grid, 0
        self.known = {(point.i, point.j): (point, None) for point in stored(grid)}
        self._ask_anew()

    def _ask_anew(self):
        """Request all unknown points."""
        self.left = [place for place in reversed(self.grid.places()) if place not in self.known]
        self._ask()

    def _ask(self):
        """Request the next points. Each one starts from the points known by then; cached ones arrive at once."""
        self.asking = True
        try:
            while self.left and len(self.sweep.waiting) < AT_ONCE:
                task = self.grid.task(self.left.pop(), self.known)
                start = task.start and skeletons.get(task.start)
                self.sweep.add([(tasks.map_point, replace(task, start=start))], rank=HEAVY)
        finally:
            self.asking = False

    def take(self, call: Any, result: Any) -> None:
        """Take the result of a point."""
        task = call[1]
        if isinstance(result, Exception):
            result = Point(i=task.i, j=task.j, reason=str(result)), None
        point, skeleton = result
        if skeleton:
            skeletons.put(task.scene_there(), skeleton)
        self.known[point.i, point.j] = point, skeleton and task.scene_there()
        if not self.asking:
            self._ask()
            if len(self.known) >= self.drawn + max(AT_ONCE, MORE * self.drawn) or not self.sweep.waiting:
                self._draw()

    # drawing

    def _draw(self):
        if self.grid is None:
            return
        points = [point for point, _ in self.known.values()]
        self.drawn = len(points)
        codes = self.grid.array(points, "regime")
        image = self.grid.array(points, self.of)
        if points:  # unknown points take the value of the nearest known one
            nearest = tuple(distance_transform_edt(codes < 0, return_distances=False, return_indices=True))
            image, codes = image[nearest].astype(np.float32), codes[nearest]
        regimes = codes if self.grid.scene.path == "shear" else np.full_like(codes, -1)
        self._describe(points, image, regimes)

    def _describe(self, points, image, codes):
        followed, without = (sum(bool(getattr(p, name)) for p in points) for name in ("followed", "reason"))
        text = f"{len(points)} of {self.grid.size} points, {followed} of them predicted, the others computed."
        if without:
            why = next(point.reason for point in points if point.reason)
            text += f" {without} without a result: {why}."
        label, unit = QUANTITIES[self.of]
        ends = limits(image)
        low, high = (f"{value + 0.0:.3g}".replace("-", "−") for value in ends)  # no -0
        beyond = np.any(image < ends[0]), np.any(image > ends[1])
        legend = {"low": "≤ " * bool(beyond[0]) + low, "high": "≥ " * bool(beyond[1]) + f"{high} {unit}", "text": text}
        legend["quantity"] = label if self.of == "L_min" else f"{label} of the first slip"
        legend["none"] = "no contact to pull off" if self.of == "L_min" else "no slip"
        if not points:
            legend |= {
                "low": "",
                "high": "",
                "none": "not computed yet",
                "text": "The first points are being computed.",
            }
        done = len(points) / self.grid.size if self.sweep.waiting else None
        stopped = len(points) < self.grid.size and done is None
        texts = {f"regimes-{name}": text for name, text in legend.items()}
        self.publish(texts=texts, busy=done, hidden={"regimes-resume": not stopped}, map=self._map(image, ends, codes))
        self.publish(own=self._place_of(self.session.scene))

    def _map(self, image, ends, codes):
        """Return what the browser draws, over numbers of columns and rows, as axes may be logarithmic.

        In bytes: float32 values and int8 codes, row by row, and lines as int16 half columns and rows.
        """
        return {
            "axes": [_axis(axis) for axis in (self.grid.x, self.grid.y)],
            "values": image.astype("<f4").tobytes(),
            "limits": (ends[0], max(ends[1], ends[0] + 1e-9)),
            "of": (self.of, *QUANTITIES[self.of]),
            "codes": codes.astype("i1").tobytes(),
            "kinds": REGIMES,  # by code; -1: none
            "outline": np.rint(2.0 * np.array(outlines(codes))).astype("<i2").tobytes(),
            "names": labels(codes),
        }


def _axis(axis):
    """Return what the browser draws of an Axis."""
    label, *_, ticks = AXES[axis.name]
    texts = [(_place(axis, value), f"{value:g}".replace("-", "−")) for value in ticks]
    return {"name": axis.name, "label": label, "values": axis.values.tolist(), "ticks": texts}


def _place(axis, value):
    """Return the position of a value on an Axis, in columns; values beyond an end are at the end."""
    along = np.log if axis.log else np.asarray
    return float(np.interp(along(value), along(axis.values), np.arange(axis.count)))


def _inside(region):
    """Return (i, j) of the point of a region (rows, columns) farthest from its edge, not too near the map's edge."""
    deep = distance_transform_edt(np.pad(region, 1))[1:-1, 1:-1]
    j, i = np.unravel_index(deep.argmax(), deep.shape)
    return float(np.clip(i, MARGIN, COLUMNS - 1 - MARGIN)), float(np.clip(j, MARGIN / 2, ROWS - 1 - MARGIN / 2))


def limits(image: NDArray[Any]) -> tuple[float, float]:
    """Return the limits (low, high) of most values of an image, so that outliers do not use up the colours."""
    values = image[np.isfinite(image)]
    low, high = np.percentile(values, MOST) if values.size else (0.0, 0.0)
    return float(low), float(high)


def labels(codes: NDArray[Any]) -> list[tuple[float, float, str]]:
    """Return [(i, j, name)] of regions of codes (rows, columns), the largest first, without overlap."""
    found = []
    regions, counts = np.unique(codes[codes >= 0], return_counts=True)
    for code in regions[np.argsort(-counts)]:
        i, j = _inside(codes == code)
        name = REGIMES[code]
        wide = [0.5 * LETTER * (len(name) + len(other)) for *_, other in found]
        if all(abs(i - x) > w or abs(j - y) > LINE for (x, y, _), w in zip(found, wide, strict=True)):
            found.append((i, j, name))
    return found


def outlines(codes: NDArray[Any]) -> list[tuple[float, float, float, float]]:
    """Return lines (i, j, i, j) between known, different cells of codes (rows, columns)."""
    found = []
    for axis, half in ((1, (0.0, 0.5)), (0, (0.5, 0.0))):
        one, other = (np.take(codes, range(k, codes.shape[axis] - 1 + k), axis) for k in (0, 1))
        for j, i in np.argwhere((one != other) & (one >= 0) & (other >= 0)):
            x, y = i + 0.5 - half[0], j + 0.5 - half[1]
            found.append((x - half[0], y - half[1], x + half[0], y + half[1]))
    return found
