"""A measured friction curve: read from a CSV, cut at its slips, its noise estimated."""

import csv
from dataclasses import dataclass
from io import TextIOBase
from os import PathLike
from pathlib import Path
from typing import TextIO

import numpy as np
from numpy.typing import NDArray

from ..scene import Scene
from .outputs import NAMES

FEWEST = 8  # points
JUMP = 5.0  # times the noise of a difference, beyond which a drop of F counts as a slip; by chance one in 3 million
STEEP = 8.0  # the same times the median step of the curve
FLOOR = 2e-4  # of the largest value: noise below what a curve between the states of a run is right to
NORMAL = 0.6745  # median of |x| of a normal distribution of unit deviation
CALM = 4.0  # deviations of a third difference, beyond which it is a slip's: of noise, one in 16,000 is


class MeasurementError(ValueError):
    """A file of no use; the message names the line, if there is one, the reason and the remedy."""


@dataclass(frozen=True)
class Measurement:
    """A curve measured along U_x (k,), nm, ascending.

    values: {"F_bar", "L_bar", "A_bar"} (k,) each, F_bar at least; noise: their standard deviations. slips: the first
    index after each slip. unit: N/m that forces were divided by if they were measured in N/m, whatever E and width are.
    """

    U_x: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    noise: dict[str, float]
    slips: tuple[int, ...]
    unit: float | None = None

    @property
    def seen(self) -> float:
        """The least drop of F_bar that counts as a slip."""
        return _seen(self.values["F_bar"], self.noise["F_bar"])

    @staticmethod
    def of(U_x, values, noise=None, unit=None) -> "Measurement":
        """From arrays; noise is estimated where it is not given: {name: standard deviation}."""
        found = {name: noise_of(y) for name, y in values.items()} | (noise or {})
        return Measurement(U_x, values, found, slips_of(values["F_bar"], found["F_bar"]), unit)


def noise_of(y):
    """Standard deviation of the noise of a smooth curve with jumps, from its third differences without the jumps."""
    third = np.abs(np.diff(y, 3))
    calm = third[third <= CALM * float(np.median(third)) / NORMAL]
    return max((float(np.mean(calm**2)) / 20.0) ** 0.5, FLOOR * float(np.abs(y).max()), 1e-300)


def slips_of(F, noise):
    """Indices after which F has dropped at once: by far more than noise, and than its usual steps."""
    return tuple(int(i) + 1 for i in np.flatnonzero(np.diff(F) < -_seen(F, noise)))


def _seen(F, noise):
    return max(JUMP * 2.0**0.5 * noise, STEEP * float(np.median(np.abs(np.diff(F)))))


def read_measurement(source: str | PathLike[str] | TextIO, scene: Scene) -> Measurement:
    """The Measurement in a CSV with a heading: U_x (nm), F_bar or F (N/m), and, if measured, L_bar or L, A_bar.

    Other columns are left alone; of a file with a column `stage`, as `run --csv` writes, rows of the shear count.
    Raises MeasurementError.
    """
    try:
        text = source.read() if isinstance(source, TextIOBase) else Path(source).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise MeasurementError(f"{str(source)!r}: {reason}; name a CSV of U_x and F_bar") from None
    numbered = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    rows = list(csv.reader(line for _, line in numbered))
    names = [name.strip() for name in rows[0]] if rows else []
    if "U_x" not in names or not {"F", "F_bar"} & set(names):
        raise MeasurementError(f"line 1: columns {', '.join(names) or 'none'}; needed: U_x (nm) and F_bar, or F (N/m)")
    asked = [name for name in ("U_x", "F_bar", "F", "L_bar", "L", "A_bar") if name in names]
    points = []
    for (line, _), row in zip(numbered[1:], rows[1:], strict=True):
        if "stage" in names and len(row) == len(names) and row[names.index("stage")] != "shear":
            continue
        points.append(_point(line, row, names, asked, points[-1][0] if points else -np.inf))
    if len(points) < FEWEST:
        raise MeasurementError(f"{len(points)} points; needed: {FEWEST} or more; measure more densely")
    columns = dict(zip(asked, np.array(points).T, strict=True))
    unit = scene.width * scene.E if "F_bar" not in columns else None
    for name in ("F", "L"):
        if unit and name in columns:
            columns[f"{name}_bar"] = columns[name] / unit
    return Measurement.of(columns["U_x"], {n: columns[n] for n in NAMES if n in columns}, unit=unit)


def _point(line, row, names, asked, before):
    """The numbers of a line; U_x must lie beyond the one before."""
    if len(row) != len(names):
        raise MeasurementError(f"line {line}: {len(row)} columns, the heading has {len(names)}; use decimal points")
    found = []
    for name in asked:
        text = row[names.index(name)]
        try:
            found.append(float(text))
        except ValueError:
            raise MeasurementError(f"line {line}: {name} = {text[:40]!r} is not a number; leave the line out") from None
        if not np.isfinite(found[-1]):
            raise MeasurementError(f"line {line}: {name} = {text}; allowed: finite numbers; leave the line out")
    if found[0] <= before:
        raise MeasurementError(f"line {line}: U_x = {found[0]:g} after {before:g}; sort the lines by U_x")
    return found
