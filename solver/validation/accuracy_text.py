"""The meaning of an accuracy Report, in words, tables and plain data."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..cautions import flutter
from ..scene import LIMITS
from ..text import changes
from .accuracy import FULL, QUICK, SWEEPS, Report
from .compare import QUANTITIES, SAME_BRANCH, Point
from .landings import SHORT

if TYPE_CHECKING:
    from pandas import DataFrame

VISIBLE = 1e-4  # of the largest value: an error that no plot shows, and no experiment on adhesion resolves
FINER = {"tolerance": "tighter", "du_x": "finer"}  # the name of a smaller value


def sentence(report: Report) -> str:
    """What a tolerance buys in this scene, and whether every method ended on the same branches; one line."""
    return " ".join(filter(None, (choice(report, "tolerance"), _price(report), branches(report))))


def choice(report: Report, sweep: str) -> str:
    """The cheapest value of a parameter at which fast has no visible error, as a sentence."""
    points = [p for p in report.of(sweep, "fast") if p.branch_error is not None and not p.failure]
    if not points:
        return f"No {sweep} tried was finished with fast."
    good = [p for p in points if p.branch_error <= VISIBLE and p.right]
    if not good:
        best = min(points, key=lambda p: p.branch_error)
        return (
            f"No {sweep} tried brings F, L and A to {VISIBLE:g} on the right branches;"
            f" the best, {best.value:g}, leaves {best.branch_error:.0e}."
        )
    cheap = max(good, key=lambda p: p.value)
    slip = cheap.worst("position")
    place = "" if slip is None else f", slips to {slip:.0e} nm"
    rest = [p for p in points if p.value < cheap.value]
    worse = [f"{p.value:g} leaves {p.branch_error:.0e}" for p in rest if p not in good]
    more = f"{FINER[sweep]} buys nothing visible" if rest else f"{FINER[sweep]} was not tried"
    more = f"yet {FINER[sweep]} is not always better: {', '.join(worse)}" if worse else more
    return (
        f"{sweep} {cheap.value:g} gives F to {cheap.F:.0e}, L to {cheap.L:.0e}, A to {cheap.A:.0e}{place}"
        f" in {cheap.seconds:.2g} s; {more}."
    )


def _price(report):
    """The work of every other method over that of fast, at the smallest tolerance that both finished."""
    fast, parts = {p.value: p for p in report.of("tolerance", "fast") if not p.failure}, []
    for series in dict.fromkeys(p.series for p in report.of("tolerance") if p.series != "fast"):
        common = [p for p in report.of("tolerance", series) if not p.failure and p.value in fast]
        if common:
            point = min(common, key=lambda p: p.value)
            own = fast[point.value]
            work, time = point.evaluations / max(own.evaluations, 1), point.seconds / own.seconds
            parts.append(f"{series} {_round(work)} ({_round(time)} times the time, both at {point.value:g})")
    return f"Times the force evaluations of fast: {', '.join(parts)}." if parts else ""


def branches(report: Report) -> str:
    """The number of slips after which the branch was the reference's, and every series with another one."""
    counts = {}  # series: (right, known)
    for p in report.points:
        counts[p.series] = [a + b for a, b in zip(counts.get(p.series, (0, 0)), p.branches, strict=True)]
    right, known = map(sum, zip(*counts.values(), strict=True)) if counts else (0, 0)
    if known == 0:
        return "There are no slips to compare."
    wrong = [f"{series} after {n - own} of {n}" for series, (own, n) in counts.items() if own < n]
    counted = f"The branch of the paper's GFMD was reached after {right} of {known} slips of all runs"
    counted += f"; another one by {', '.join(wrong)} (see the tables)." if wrong else "."
    if astray := _places(report.landings.differs):
        counted += f" The reference itself leaves it{astray}: errors beyond that slip mean nothing."
    return counted


def _landed(report):
    """The method that decides about branches, and its doubts; lines of text."""
    landed, known = report.landings, report.known_slips
    near = [f"F, L, A before the first slip to {landed.error:.0e}"] if landed.error is not None else []
    near += [f"slips in shear to {landed.apart:.0e} nm"] if landed.apart is not None else []
    lines = [
        f"Branches are compared with those of gfmd, from rest to rest at tolerance {landed.tolerance:g} nm,"
        f" increments halved to {SHORT:g} nm where the surface slips, {landed.seconds:.2g} s. The reference follows it"
        f" through {landed.right} of {len(known)} slips" + (f"; both agree on {' and '.join(near)}." if near else ".")
    ]
    if landed.differs:
        lines.append(f"The reference is on another branch than gfmd{_places(landed.differs)}.")
    if landed.finer:
        elsewhere = f"lands elsewhere{_places(landed.changed)}: not counted"
        lines.append(f"With half its time step gfmd {elsewhere if landed.changed else 'lands in the same states'}.")
    if landed.untold:
        lines.append(f"Unknown{_places(landed.untold)}: {landed.failure or 'the next slip follows too soon'}.")
    return lines


def _places(slips):
    """The loads of these slips (stage, load), as text; "" if there are none."""
    names = {"shear": "U_x", "approach": "delta"}
    return " after the slip at " + ", ".join(f"{names[s]} = {load:.5g} nm" for s, load in slips) if slips else ""


def failures(report: Report) -> list[str]:
    """A line for every run that did not finish."""
    return [f"{p.series}, {p.sweep} {p.value:g}: {p.failure}" for p in report.points if p.failure]


def table(report: Report, sweep: str) -> "DataFrame":
    """The Points of a sweep as a DataFrame of text."""
    from pandas import DataFrame  # takes longer to import than the solver

    return DataFrame([_row(p) for p in report.of(sweep)])


def _row(p: Point):
    return {
        "series": p.series,
        "value": f"{p.value:g}",
        "seconds": "-" if p.seconds is None else f"{p.seconds:.3g}",
        "evaluations": "-" if p.evaluations is None else str(p.evaluations),
        **{name: _short(getattr(p, name)) for name in QUANTITIES},
        "slip, nm": _short(p.worst("position")),
        "F_s": _short(p.worst("force")),
        "same branch": "{} of {}".format(*p.branches) if p.branches[1] else "-",
    }


def _round(value):
    """Two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _short(value):
    return "-" if value is None else f"{value:.1e}"


def title(report: Report) -> str:
    """The scene's parameters that differ from the default, and the end of the runs."""
    return f"{changes(report.scene) or 'default scene'}, up to U_x = {report.horizon:g} nm"


def command(report: Report) -> str:
    """The command that makes this report."""
    changed, effort = changes(report.scene), QUICK if report.quick else FULL
    options = " --quick" if report.quick else ""
    options += f" --slips {report.slips}" if report.slips != effort.slips else ""
    return f"python -m solver accuracy{options}" + (f" --set {changed}" if changed else "")


def notes(report: Report) -> list[str]:
    """The origin of the numbers, as lines of text."""
    (du_x, du_z), effort = report.steps, QUICK if report.quick else FULL
    return [
        f"Runs end at U_x = {report.horizon:g} nm, just beyond slip {report.slips} in shear or at u_x_max;"
        f" each is stopped after {effort.longest:g} s. Seconds are those of one core.",
        f"Reference: fast, tolerance {report.tolerance:g} nm, du_x = {du_x:g}, du_z = {du_z:g}; made in"
        f" {report.seconds:.2g} s.",
        *_landed(report),
        *flutter(report.scene, report.safe_damping),
        "F, L, A: largest error before the first slip over the largest value. slip: largest distance of a slip in shear"
        " from its load in the reference. F_s: error of F there over the largest F.",
        f"same branch: as gfmd's; states right after a slip, at the same load, differ by less than {SAME_BRANCH:g} of"
        " min(delta_n, delta_t).",
        "gfmd and its variants notice a slip at the increment it happens in, and report the load before it.",
    ]


def text(report: Report) -> str:
    """The whole report for people, in lines."""
    lines = [title(report), *notes(report)]
    for sweep in filter(report.of, SWEEPS):
        rows = table(report, sweep).to_string(index=False)
        lines += ["", f"{sweep} [{LIMITS[sweep].unit}]", rows, choice(report, sweep)]
    return "\n".join([*lines, "", *failures(report), sentence(report)])


def data(report: Report) -> dict[str, Any]:
    """The report as plain data, for JSON."""
    points = [asdict(p) | {"branches_right": p.branches[0], "branches_told": p.branches[1]} for p in report.points]
    known = [dict(zip(("stage", "load", "F_bar"), slip, strict=True)) for slip in report.known_slips]
    steps = dict(zip(("du_x", "du_z"), report.steps, strict=True))
    made = {"seconds": report.seconds, "slips": known, "judged": asdict(report.landings)}
    return {
        "command": command(report),
        "scene": asdict(report.scene),
        "quick": report.quick,
        "U_x_end": report.horizon,
        "slips_wanted": report.slips,
        "reference": {"tolerance": report.tolerance, **steps, **made},
        "same_branch_within": SAME_BRANCH,
        "points": points,
        "sentence": sentence(report),
        "sentences": {sweep: choice(report, sweep) for sweep in SWEEPS if report.of(sweep)},
    }
