"""A measured friction curve: read from a CSV, cut at its slips, its noise estimated."""

import re
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..continuation.state import TINY
from ..run.frame import Stage
from ..scene import Scene
from ..tables import LISTED, SHOWN, DataError, Source, listed, read_table
from ..text import UNITS
from .outputs import NAMES

FEWEST = 8  # points; third differences of fewer leave no estimate of the noise
JUMP = 5.0 * 2.0**0.5  # least drop of a slip over the noise of a point; noise alone makes one in 3 million points
# least drop of a slip over the median step, on a finely sampled curve. Where steps are noise alone, their median is
# 0.95 deviations, and this is about JUMP
SUDDEN = 8.0
# Least drop of a slip over the steps beside it and over the 90 % quantile of rises, on a sparse curve. 24 scenes at 5
# to 8 points a period with 1.2 % noise (tests/bench/fit.py, BASE): 1.7 took smooth sliding for slips, 2.5 missed 6 %.
ALONE = 2.0
DIFFERENCES = {3: 20.0, 2: 6.0}  # order: variance of such a difference over that of a point
UNIT_OF = {"U_x": "nm", "F_bar": "", "F": "N/m", "L_bar": "", "L": "N/m", "A_bar": "", "A": "nm"}  # of columns read
NEEDED = "U_x (nm) and F (N/m), or F_bar"
# What a heading may say in place of a name, in small letters without blanks and signs
NAMED = {
    "U_x": ("ux", "displacement", "tangentialdisplacement", "lateraldisplacement", "slidingdistance"),
    "F_bar": ("fbar",),
    "F": ("f", "force", "friction", "frictionforce", "tangentialforce", "lateralforce", "shearforce"),
    "L_bar": ("lbar",),
    "L": ("l", "load", "normalload", "normalforce"),
    "A_bar": ("abar",),
    "A": ("a", "area", "contactarea"),
    "stage": ("stage",),
}


@dataclass(frozen=True, eq=False)
class Measurement:
    """A curve measured along U_x (k,), nm, ascending.

    values: {"F_bar", "L_bar", "A_bar"} (k,) each, F_bar at least; noise: their standard deviations. slips: the first
    index after each slip. unit: w E (N/m) that forces in N/m were divided by; None for forces given as F_bar. notes:
    what the file has that was not used. width: w (nm) that areas in nm were divided by; None for areas given as A_bar.
    """

    U_x: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    noise: dict[str, float]
    slips: tuple[int, ...]
    unit: float | None = None
    notes: tuple[str, ...] = ()
    width: float | None = None

    @property
    def seen(self) -> float:
        """The least drop of F_bar that the data show as a slip; infinite where they show none."""
        if not self.slips:
            return np.inf
        steps = np.diff(self.values["F_bar"])
        return max(JUMP * self.noise["F_bar"], min(SUDDEN * float(np.median(np.abs(steps))), ALONE * _rise(steps)))

    @staticmethod
    def of(
        U_x: NDArray[np.float64],
        values: dict[str, NDArray[np.float64]],
        noise: dict[str, float] | None = None,
        unit: float | None = None,
        notes: tuple[str, ...] = (),
        width: float | None = None,
    ) -> "Measurement":
        """A Measurement from arrays; estimates the noise {name: standard deviation} of quantities not in `noise`.

        Raises DataError for fewer than FEWEST points and for a constant force.
        """
        F = values["F_bar"]
        if len(U_x) < FEWEST:
            raise DataError(f"points: {len(U_x)}; needed: {FEWEST} or more; measure more densely")
        if not np.ptp(F) > 0.0:
            raise DataError(f"F is {F[0]:g} at every point; needed: a force that changes; check the column F")
        drops = drops_of(F)
        noise = {name: noise_of(y, drops) for name, y in values.items()} | (noise or {})
        return Measurement(U_x, values, noise, slips_of(F, noise["F_bar"]), unit, notes, width)


def noise_of(y: NDArray[np.float64], drops: NDArray[np.int_] | tuple[int, ...] = ()) -> float:
    """Standard deviation of the noise of a curve y (k,), from differences of third order, of second where too few.

    Differences across `drops` (the index before each) and those beyond four deviations are left out as slips.
    """
    differences = np.zeros(0)
    for order, variance in DIFFERENCES.items():
        across = np.isin(np.arange(len(y) - 1), drops)
        usable = ~np.lib.stride_tricks.sliding_window_view(across, order).any(axis=1)
        differences = np.abs(np.diff(y, order)[usable]) / variance**0.5
        if differences.size >= FEWEST:
            break
    # a normal distribution has the median 0.6745 of |x| in deviations; noise exceeds four once in 16,000 differences
    most = 4.0 / 0.6745 * float(np.median(differences)) if differences.size else 0.0
    calm = differences[differences <= most] if differences.size else [0.0]
    # a curve interpolated between states is right to some 1e-4
    return max(float(np.mean(np.square(calm))) ** 0.5, 2e-4 * float(np.abs(y).max()), TINY)


def drops_of(F: NDArray[np.float64]) -> NDArray[np.int_]:
    """Indices before the drops of F (k,) that look like slips, whatever the noise.

    Either a drop is far larger than usual steps, or it stands alone: larger than the steps beside it and than rises.
    """
    steps = np.diff(F)
    size = np.abs(steps)
    beside = np.maximum(np.append(0.0, size[:-1]), np.append(size[1:], 0.0))
    steep = steps < -SUDDEN * float(np.median(size))
    return np.flatnonzero(steep | (steps < -ALONE * np.maximum(beside, _rise(steps))))


def slips_of(F: NDArray[np.float64], noise: float) -> tuple[int, ...]:
    """First indices after the slips: those of `drops_of` that exceed the noise (standard deviation of F)."""
    return tuple(int(i) + 1 for i in drops_of(F) if F[i] - F[i + 1] > JUMP * noise)


def _rise(steps):
    """The 90 % quantile of rising steps; 0 without any."""
    rises = steps[steps > 0.0]
    # the largest rises may be noise
    return float(np.quantile(rises, 0.9)) if rises.size else 0.0


def read_measurement(source: Source, scene: Scene) -> Measurement:
    """Reads a CSV with a heading: U_x (nm), F (N/m) or F_bar, and optionally L or L_bar, A (nm) or A_bar.

    NAMED lists other headings, UNITS the units that are converted, as in U_x (um). Other columns and incomplete rows
    are left out. A file with a column `stage`, as `run --csv` writes, must have one shear; only that counts. L counts
    beside F, and L_bar beside F_bar, because w E may be a free parameter.

    Parameters: source: a path, or the content of a file: text with line breaks, bytes, or an open file; scene: gives
    w E and w, over which forces in N/m and areas in nm are taken.
    Returns a Measurement, its noise estimated.
    Raises DataError, and TypeError for a scene that is none.

    Example: `read_measurement("measured.csv", Scene()).noise`
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene = {scene!r:.60}: allowed: a Scene; the order is read_measurement(source, scene)")
    table = read_table(source, NEEDED, lambda columns: _has_curve(_indices(columns)))
    of, notes = _indices(table.columns), []
    force, other, load = ("F_bar", "L", "L_bar") if "F_bar" in of else ("F", "L_bar", "L")
    unused = [column.name for k, column in enumerate(table.columns) if k not in of.values()]
    if other in of:
        del of[other]
        notes += [f"{other} is left out beside {force}; give {load}: w E may be free."] * (load not in of)
    stage = of.pop("stage", None)
    if not {"residual", "evaluations"} <= set(unused):  # in a file of a run they are
        notes += [f"not used: {listed(unused)}."] * bool(unused)
    names = [name for name in UNIT_OF if name in of]
    factors = {name: _factor(name, table.columns[of[name]]) for name in names}
    _, columns, left_out = _sheared(table, stage).numbers({name: of[name] for name in names})
    over = {"F": scene.width * scene.E, "L": scene.width * scene.E, "A": scene.width}
    values = {f"{name}_bar": columns[name] * factors[name] / over[name] for name in over if name in columns}
    values = {name: columns[name] for name in NAMES if name in columns} | values
    values = {name: values[name] for name in NAMES if name in values}
    unit, width = over["F"] if force == "F" else None, over["A"] if "A" in columns else None
    return Measurement.of(columns["U_x"] * factors["U_x"], values, None, unit, (*notes, *left_out), width)


def _indices(columns):
    """{name in UNIT_OF, or "stage": index} of the columns whose headings have a known meaning; the first of each."""
    of: dict[str, int] = {}
    for k, column in enumerate(columns):
        plain = re.sub(r"[\W_]", "", column.name.lower())
        name = next((name for name, words in NAMED.items() if plain in words), None)
        if name:
            of.setdefault(name, k)
    return of


def _has_curve(of):
    return "U_x" in of and bool({"F", "F_bar"} & of.keys())


def _sheared(table, stage):
    """The rows of the stage of shear, if a column `stage` names stages; raises DataError unless there is one."""
    if stage is None:
        return table
    texts = table.cells[stage]
    shears = [each for each in texts.unique() if Stage(each).kind == "shear"]
    if len(shears) == 1:
        return replace(table, cells=table.cells[texts == shears[0]])
    found = ", ".join(repr(each[:SHOWN]) for each in (shears or list(texts.unique()))[:LISTED])
    raise DataError(f"stage: {found}; needed: rows of one stage of shear; keep those, or run with path=shear")


def _factor(name, column):
    """What numbers of a column are multiplied by, from the unit of its heading to that of UNIT_OF."""
    factors = UNITS.get(UNIT_OF[name], {}) | {"": 1.0}
    if column.unit in factors:
        return factors[column.unit]
    allowed, remedy = ", ".join(filter(None, factors)) or "none", "correct the heading"
    if UNIT_OF[name] == "N/m" and re.fullmatch("[kmµun]?N", column.unit):
        remedy = f"divide it by the width of the contact across the pull, and write {name} (N/m) in the heading"
    message = f"heading: {column.name} in {column.unit[:SHOWN]!r}; allowed units: {allowed}; {remedy}"
    raise DataError(message)
