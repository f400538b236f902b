"""The meaning of an accuracy Report, in words, tables and plain data."""

from dataclasses import asdict
from typing import Any

from ..cautions import flutter
from ..scene import LIMITS
from ..text import changes
from .compare import CURVES, Point
from .measure import FULL, QUICK, SWEEPS, Report

VISIBLE = 1e-4  # of the largest value: an error that no plot shows, and no experiment on adhesion resolves
TIGHTER = {"tolerance": "tighter", "du_x": "finer"}  # the name of a smaller value


def choice(report: Report, sweep: str) -> str:
    """The cheapest value of a parameter at which fast has no visible error, as a sentence."""
    errors = {p: p.branch_error for p in report.of(sweep, "fast") if not p.failure}
    points = {p: error for p, error in errors.items() if error is not None}
    if not points:
        return f"No {sweep} tried was finished with fast."
    good = [p for p, error in points.items() if error <= VISIBLE]
    if not good:
        best = min(points, key=lambda p: points[p])
        return (
            f"No {sweep} tried brings F, L and A to {VISIBLE:g}; the best, {best.value:g}, leaves {points[best]:.0e}."
        )
    cheap = max(good, key=lambda p: p.value)
    slip = cheap.worst("position")
    place = "" if slip is None else f", slips to {slip:.0e} nm"
    rest = [p for p in points if p.value < cheap.value]
    worse = [f"{p.value:g} leaves {points[p]:.0e}" for p in rest if p not in good]
    more = f"{TIGHTER[sweep]} has no visible effect" if rest else f"{TIGHTER[sweep]} was not tried"
    more = f"yet {TIGHTER[sweep]} is not always better: {', '.join(worse)}" if worse else more
    return (
        f"{sweep} {cheap.value:g} gives F to {cheap.F:.0e}, L to {cheap.L:.0e}, A to {cheap.A:.0e}{place}"
        f" in {cheap.seconds:.2g} s; {more}."
    )


def _row(p: Point):
    return {
        "series": p.series,
        "value": f"{p.value:g}",
        "seconds": "-" if p.seconds is None else f"{p.seconds:.3g}",
        "evaluations": "-" if p.evaluations is None else str(p.evaluations),
        **{name: _short(getattr(p, name)) for name in CURVES},
        "slip, nm": _short(p.worst("position")),
        "F_s": _short(p.worst("force")),
    }


def _short(value):
    return "-" if value is None else f"{value:.1e}"


def notes(report: Report) -> list[str]:
    """The origin of the numbers, as lines of text."""
    fine, effort = report.reference, QUICK if report.quick else FULL
    return [
        f"Runs end at U_x = {fine.u_x_max:g} nm, just beyond slip {report.slips} in shear or at u_x_max;"
        f" each is stopped after {effort.longest:g} s. Seconds are those of one core.",
        f"Reference: fast, tolerance {fine.tolerance:g} nm, du_x = {fine.du_x:g}, du_z = {fine.du_z:g}; made in"
        f" {report.seconds:.2g} s.",
        *flutter(report.scene, report.safe_damping),
        "F, L, A: largest error before the first slip over the largest value. slip: largest distance of a slip in shear"
        " from its load in the reference, up to the first slip that is sensitive. F_s: error of F there over the"
        " largest F.",
        "gfmd notices a slip at the increment it happens in, and reports the load before it.",
    ]


def text(report: Report) -> str:
    """The whole report in lines, for a terminal."""
    from pandas import DataFrame  # takes longer to import than the solver

    scene, end = changes(report.scene) or "default scene", report.reference.u_x_max
    lines = [f"Error against run time: {scene}, up to U_x = {end:g} nm"]
    for sweep in filter(report.of, SWEEPS):
        table = DataFrame([_row(p) for p in report.of(sweep)]).to_string(index=False, justify="left")
        lines += ["", f"{sweep} [{LIMITS[sweep].unit}]", table, choice(report, sweep)]
    failures = (f"{p.series}, {p.sweep} {p.value:g}: {p.failure}" for p in report.points if p.failure)
    return "\n".join([*lines, "", *notes(report), *failures])


def data(report: Report) -> dict[str, Any]:
    """The report as plain data, for JSON."""
    fine = {name: getattr(report.reference, name) for name in ("tolerance", "du_x", "du_z")}
    slips = [
        {name: getattr(slip, name) for name in ("stage", "load", "F_bar", "sensitive")} for slip in report.known_slips
    ]
    return {
        "scene": asdict(report.scene),
        "quick": report.quick,
        "U_x_end": report.reference.u_x_max,
        "slips_wanted": report.slips,
        "reference": fine | {"seconds": report.seconds, "slips": slips},
        "points": [asdict(p) for p in report.points],
        "sentences": {sweep: choice(report, sweep) for sweep in SWEEPS if report.of(sweep)},
    }
