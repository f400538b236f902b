"""A measured curve as the page draws it and compares it with a run, for workers."""

from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np

from solver import DataError
from solver.measured.comparison import NoStage, compared, unit_in
from solver.measured.measurement import Measurement, Recording
from solver.run.frame import Stage

LAID, COMPARED = 150, 5000  # points of a curve that the page draws: more hide the run; that are compared
FARTHEST = 1e9  # nm, N, N/m: numbers of a measured curve beyond have another unit
MISSING = {"unload": "retraction", "loop": "way back", "shear": "shear"}  # of a run, by the path that has it
IN_LETTERS = {"F_s": "Fₛ", "A_0": "A₀"}
COLUMNS = "stage", "U_x", "delta", "F", "L", "A", "slip", "slip_at", "F_slip"  # of a run, as the page sends them


@dataclass(frozen=True, eq=False)
class Curve(Recording):
    """A measured curve to be compared. options: the arguments that read it from its file."""

    options: dict[str, Any] = field(default_factory=dict)

    @property
    def main(self) -> str:
        """The quantity over x: it is drawn and compared."""
        return next(iter(self.segments[0].values))


def rounded(value: float, digits: int = 3) -> str:
    """A number as text, with separators of thousands."""
    return f"{float(f'{value:.{digits}g}'):,.10g}"


def curve_of(read: Measurement | Recording, options: dict[str, Any]) -> Curve:
    """The Curve of what was read by these options, thinned out to what is compared, without holds."""
    moving = [each for each in read.segments if each.name != "hold"]
    largest = max(float(np.abs(y).max()) for each in moving for y in (each.x, *each.values.values()))
    if largest > FARTHEST:
        raise DataError(f"a number of {largest:.3g}; allowed: {FARTHEST:g} nm, N or N/m at most; check the units")
    every = 1 + sum(each.x.size for each in moving) // COMPARED
    segments = tuple(
        each._replace(x=each.x[::every], values={name: y[::every] for name, y in each.values.items()})
        for each in moving
    )
    units = {name: read.units[name] for name in (read.over, *segments[0].values)}
    return Curve(read.kind, segments, units, read.free, notes=read.notes, options=options)


def shown(curve: Curve) -> dict[str, Any]:
    """Return a Curve as the page draws it."""
    every = 1 + sum(each.x.size for each in curve.segments) // LAID
    segments = [
        {name: y[::every].tolist() for name, y in ({"x": each.x} | each.values).items()} for each in curve.segments
    ]
    made = {name: getattr(curve, name) for name in ("kind", "over", "main", "units")}
    return made | {"segments": segments, "columns": COLUMNS, "notes": " ".join(curve.notes)}


def _run(content, stages, force, width):
    """What a Curve is compared with, from the curves of a run; raises ValueError, LookupError or ArithmeticError."""
    rows = np.frombuffer(content, "<f4").reshape(len(COLUMNS), -1).astype(float).tolist()
    names, (slips, at, F_slip) = [Stage(stages[int(k)].split(" ")[-1]) for k in rows[0]], rows[6:]
    frames = [
        SimpleNamespace(stage=stage, U_x=U_x, delta=delta, F=F, L=L, A=A)
        for stage, U_x, delta, F, L, A in zip(names, *rows[1:6], strict=True)
    ]
    first = next((k for k, stage in enumerate(names) if stage.moves == "U_x" and slips[k]), None)
    slip = None if first is None else SimpleNamespace(U_s=at[first], F_s=F_slip[first])
    return SimpleNamespace(scene=SimpleNamespace(width=width, E=force / width), frames=frames, first_slip=slip)


def _own_range(curve, run, error):
    """Why a Curve and a run cannot be compared: one is longer; else the reason of the error."""
    here = float(np.ptp(np.concatenate([each.x for each in curve.segments])))
    there = float(np.ptp([getattr(frame, curve.over) for frame in run.frames]))
    if curve.over in "FL" or here <= there:
        return f"{error}".partition(";")[0]
    return f"{rounded(here)} nm here, {rounded(there)} nm in the run"


def compare(curve: Curve, content: bytes, stages: tuple[str, ...], force: float, width: float) -> dict[str, Any]:
    """Return how far a Curve and a run are apart, and {quantity: (factor, zero)} that bring it into the run's units.

    content: COLUMNS of a run, float32; stages: their names; force: w E, N/m; width: w, nm. `why`: what keeps them from
    being compared, and `path`: a kind of path whose runs can be. `near`, `says`: the difference in words.
    """
    try:
        run = _run(content, stages, force, width)
    except (ValueError, LookupError, ArithmeticError):
        return {"why": "the run did not arrive whole; load the page again"}
    points = sum(each.x.size for each in curve.segments)
    try:
        found = compared(curve, run)
    except NoStage as error:
        return {"path": error.path, "why": f"this run has no {MISSING[error.path]}"}
    except ValueError as error:
        return {"why": f"{_own_range(curve, run, error)}, so it is drawn in its own range"}
    set_to = {name: (unit_in(unit, run), 0.0) for name, unit in curve.units.items()}
    set_to |= {name: (found.scale, found.zero) for name, unit in curve.units.items() if unit == "N"}
    set_to |= {curve.over: (1.0, found.shift)} if found.shift else {}
    made = {"set": set_to, "outside": found.outside, "points": points, "rms": found.rms, "noise": found.noise}
    return made | _said(curve, found, points)


def _said(curve, found, points):
    """{"near": how far a Curve and a run are apart, "says": where, and how the points are drawn}, in words."""
    main, at = curve.main, [row[1] for row in found.rows]
    rms, unit = found.rms[main], IN_LETTERS.get(found.units[main], found.units[main])
    where = "" if curve.over in "FL" else f" ({min(at):.1f} to {max(at):.1f} nm)"
    beyond = f"; {found.outside} of {points} points lie beyond the run" if found.outside else ""
    says = f"{where}, {rounded(rms / found.noise[main], 2)} times the noise{beyond}."
    if curve.units[main] == "N":
        says += f" Drawn: {main} × {rounded(found.scale)} N/m per N + {rounded(found.zero)} N/m."
    says += f" Drawn: δ + {found.shift:.1f} nm." if found.shift else ""
    return {"near": f"rms difference {rounded(rms, 2)} {unit}", "says": says.replace("-", "−")}
