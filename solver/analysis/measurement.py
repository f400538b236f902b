"""A measured friction curve: read from a CSV, cut at its slips, its noise estimated."""

import re
from csv import QUOTE_NONE
from dataclasses import dataclass
from io import StringIO, TextIOBase
from os import PathLike
from pathlib import Path
from typing import TextIO

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ..scene import Scene
from ..text import UNITS
from .outputs import NAMES

FEWEST = 8  # points; third differences of fewer leave no estimate of the noise
JUMP = 5.0 * 2.0**0.5  # least drop of a slip over the noise of a point; noise alone makes one in 3 million points
STEEP = 8.0  # least drop of a slip over the median step, on a finely sampled curve
# Least drop of a slip over the steps beside it and over the 90 % quantile of rises, on a sparse curve. 24 scenes at 5
# to 8 points a period with 1.2 % noise (tests/bench/fit.py, BASE): 1.7 took smooth sliding for slips, 2.5 missed 6 %.
ALONE = 2.0
RISING = 0.9
FLOOR = 2e-4  # least noise over the largest value: a curve interpolated between states is right to some 1e-4
NORMAL = 0.6745  # median of |x| of a normal distribution of unit deviation
CALM = 4.0  # deviations; noise alone exceeds it once in 16,000 differences
DIFFERENCES = {3: 20.0, 2: 6.0}  # order: variance of such a difference over that of a point
UNIT_OF = {"U_x": "nm", "F_bar": "", "F": "N/m", "L_bar": "", "L": "N/m", "A_bar": ""}  # of the columns that are read
HEADING = re.compile(r"(\w+)\s*(?:[\[(/]\s*([^\])]*?)\s*[\])]?)?")  # F, F (N/m), F [N/m], U_x/nm
NEEDED = "needed: U_x (nm) and F_bar, or F (N/m)"
SHOWN = 80  # characters of a heading in a message


class MeasurementError(ValueError):
    """An unusable measurement; the message gives the line, if there is one, the reason and the remedy."""


@dataclass(frozen=True, eq=False)
class Measurement:
    """A curve measured along U_x (k,), nm, ascending.

    values: {"F_bar", "L_bar", "A_bar"} (k,) each, F_bar at least; noise: their standard deviations. slips: the first
    index after each slip. unit: w E (N/m) that forces in N/m were divided by; None for forces given as F_bar.
    """

    U_x: NDArray[np.float64]
    values: dict[str, NDArray[np.float64]]
    noise: dict[str, float]
    slips: tuple[int, ...]
    unit: float | None = None

    @property
    def seen(self) -> float:
        """The least drop of F_bar that the data show as a slip; infinite where they show none."""
        if not self.slips:
            return np.inf
        steps = np.diff(self.values["F_bar"])
        return max(JUMP * self.noise["F_bar"], min(STEEP * float(np.median(np.abs(steps))), ALONE * _rise(steps)))

    @staticmethod
    def of(
        U_x: NDArray[np.float64],
        values: dict[str, NDArray[np.float64]],
        noise: dict[str, float] | None = None,
        unit: float | None = None,
    ) -> "Measurement":
        """A Measurement from arrays; estimates the noise {name: standard deviation} of quantities not in `noise`.

        Raises MeasurementError for fewer than FEWEST points and for a constant force.
        """
        F = values["F_bar"]
        if len(U_x) < FEWEST:
            raise MeasurementError(f"points: {len(U_x)}; needed: {FEWEST} or more; measure more densely")
        if not np.ptp(F) > 0.0:
            raise MeasurementError(f"F is {F[0]:g} at every point; needed: a force that changes; check the column F")
        drops = drops_of(F)
        noise = {name: noise_of(y, drops) for name, y in values.items()} | (noise or {})
        return Measurement(U_x, values, noise, slips_of(F, noise["F_bar"]), unit)


def noise_of(y: NDArray[np.float64], drops: NDArray[np.int_] | tuple[int, ...] = ()) -> float:
    """Standard deviation of the noise of a curve y (k,), from differences of third order, of second where too few.

    Differences across `drops` (the index before each) and those beyond CALM are left out: they contain slips.
    """
    differences = np.zeros(0)
    for order, variance in DIFFERENCES.items():
        across = np.isin(np.arange(len(y) - 1), drops)
        usable = ~np.lib.stride_tricks.sliding_window_view(across, order).any(axis=1)
        differences = np.abs(np.diff(y, order)[usable]) / variance**0.5
        if differences.size >= FEWEST:
            break
    calm = differences[differences <= CALM * float(np.median(differences)) / NORMAL] if differences.size else [0.0]
    return max(float(np.mean(np.square(calm))) ** 0.5, FLOOR * float(np.abs(y).max()), 1e-300)


def drops_of(F: NDArray[np.float64]) -> NDArray[np.int_]:
    """Indices before the drops of F (k,) that look like slips, whatever the noise.

    Either a drop is far larger than usual steps, or it stands alone: larger than the steps beside it and than rises.
    """
    steps = np.diff(F)
    size = np.abs(steps)
    beside = np.maximum(np.append(0.0, size[:-1]), np.append(size[1:], 0.0))
    steep = steps < -STEEP * float(np.median(size))
    return np.flatnonzero(steep | (steps < -ALONE * np.maximum(beside, _rise(steps))))


def slips_of(F: NDArray[np.float64], noise: float) -> tuple[int, ...]:
    """First indices after the slips: those of `drops_of` that exceed the noise (standard deviation of F)."""
    return tuple(int(i) + 1 for i in drops_of(F) if F[i] - F[i + 1] > JUMP * noise)


def _rise(steps):
    """The 90 % quantile of rising steps; 0 without any."""
    rises = steps[steps > 0.0]
    return float(np.quantile(rises, RISING)) if rises.size else 0.0


def read_measurement(source: str | PathLike[str] | TextIO, scene: Scene) -> Measurement:
    """The Measurement in a CSV with a heading: U_x (nm), F_bar or F (N/m), and optionally L_bar or L, A_bar.

    Separators are commas, semicolons or tabs; the latter two allow decimal commas. Units of the heading are converted,
    as in U_x (um). Lines with missing or infinite numbers and other columns are left out; of a file with a column
    `stage`, as `run --csv` writes, only the shear counts. Raises MeasurementError.
    """
    cells, units = _cells(_text(source))
    if "stage" in cells:
        cells = cells[cells["stage"] == "shear"]
    table = pd.DataFrame({name: _numbers(cells[name], units[name]) for name in UNIT_OF if name in cells})
    table = table[np.isfinite(table).all(axis=1)]
    falls = table.index[table["U_x"].diff() <= 0.0]
    if falls.size:
        before, value = table["U_x"].shift()[falls[0]], table["U_x"][falls[0]]
        raise MeasurementError(f"line {falls[0]}: U_x = {value:g} after {before:g}; sort the lines by U_x")
    unit = None if "F_bar" in table else scene.width * scene.E
    if unit:
        table = table.assign(**{f"{name}_bar": table[name] / unit for name in ("F", "L") if name in table})
    values = {name: table[name].to_numpy() for name in NAMES if name in table}
    return Measurement.of(table["U_x"].to_numpy(), values, unit=unit)


def _text(source):
    """The content of a file or stream."""
    try:
        text = source.read() if isinstance(source, TextIOBase) else Path(source).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "not UTF-8 text"
        raise MeasurementError(f"{str(source)!r}: {reason}; name a CSV of U_x and F_bar") from None
    if "\0" in text or "\ufffd" in text:
        raise MeasurementError("not a text file; save the measurement as CSV in UTF-8")
    return text.removeprefix("\ufeff")


def _cells(text):
    """(DataFrame of texts, a column per heading, indexed by line number; {heading: its unit, or ""})."""
    lines = [(k, line) for k, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    heading = lines[0][1] if lines else ""
    separator = next((mark for mark in ";\t" if mark in heading), ",")
    headings = [HEADING.fullmatch(cell.strip(' "')) for cell in heading.split(separator)]
    units = {match[1]: match[2] or "" for match in headings if match}
    if "U_x" not in units or not {"F", "F_bar"} & units.keys():
        shown = heading[:SHOWN] if heading.isprintable() else "not readable"
        raise MeasurementError(f"line {lines[0][0] if lines else 1}: heading {shown or 'missing'}; {NEEDED}")
    if len(lines) == 1:
        raise MeasurementError(f"points: 0; needed: {FEWEST} or more; add lines below the heading")
    widest = 1 + max(line.count(separator) for _, line in lines)
    cells = pd.read_csv(
        StringIO("\n".join(line for _, line in lines[1:])),
        **{"sep": separator, "header": None, "names": range(widest), "dtype": str, "quoting": QUOTE_NONE},
    ).set_axis([number for number, _ in lines[1:]])
    wide = cells.iloc[:, len(headings) :].notna().any(axis=1)
    if wide.any():
        number = wide.idxmax()
        remedy = "use decimal points, or semicolons between columns"
        count = int(cells.loc[number].notna().sum())
        raise MeasurementError(f"line {number}: {count} columns, the heading has {len(headings)}; {remedy}")
    cells = cells.apply(lambda column: column.str.strip(' "').str.replace("\N{MINUS SIGN}", "-"))
    if separator != ",":
        cells = cells.apply(lambda column: column.str.replace(",", "."))
    return pd.DataFrame({match[1]: cells[k] for k, match in enumerate(headings) if match}), units


def _numbers(texts, unit):
    """Numbers (Series) of a column of texts in the unit of its heading, converted to that of UNIT_OF; NaN for none."""
    numbers = pd.to_numeric(texts, errors="coerce")
    wrong = texts.index[texts.notna() & numbers.isna() & (texts != "")]
    if wrong.size:
        shown = texts[wrong[0]][:SHOWN]
        shown = repr(shown) if shown.isprintable() else "an unreadable cell"
        raise MeasurementError(f"line {wrong[0]}: {texts.name} = {shown} is not a number; correct or delete the line")
    factors = UNITS.get(UNIT_OF[texts.name], {}) | {"": 1.0}
    unit = unit.replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}")
    if unit not in factors:
        allowed = ", ".join(name for name in factors if name) or "none"
        raise MeasurementError(f"heading: {texts.name} in {unit[:SHOWN]!r}; allowed units: {allowed}")
    return numbers * factors[unit]
