"""What a work-precision Report means, in words, tables and plain data."""

from dataclasses import asdict

from ..scene import LIMITS
from ..text import changes
from .compare import QUANTITIES, SAME_BRANCH
from .measure import LONGEST, SLIPS, SWEEPS, VISIBLE

# sweep: (what the other direction is called, whether a larger value is the cheaper one, stage of the slips it moves)
DIRECTION = {
    "tolerance": ("tighter", True, "shear"),
    "du_x": ("finer", True, "shear"),
    "du_z": ("finer", True, "approach"),
    "window_n": ("wider", False, "shear"),
    "window_t": ("wider", False, "shear"),
}
HEAD = ("value", "seconds", "evaluations", "F", "L", "A", "slip, nm", "F_s", "same branch")


def sentence(report):
    """What a tolerance buys in this scene, and whether every method ended on the same branches; one line."""
    return " ".join(filter(None, (choice(report, "tolerance"), _price(report), branches(report))))


def choice(report, sweep):
    """The cheapest value of a parameter that spoils nothing visible with fast, as a sentence."""
    finer, descending, _ = DIRECTION[sweep]
    points = [p for p in report.of(sweep, "fast") if p.branch_error is not None and not p.failure]
    points.sort(key=lambda p: p.value, reverse=descending)
    if not points:
        return f"No {sweep} tried was finished with fast."
    cheap = chosen(points)
    if cheap is None:
        best = min(points, key=lambda p: p.branch_error)
        return (
            f"No {sweep} tried brings F, L and A to {VISIBLE:g} on the reference's branches;"
            f" the best, {best.value:g}, leaves {best.branch_error:.0e}."
        )
    slip = cheap.worst("position", DIRECTION[sweep][2])
    place = "" if slip is None else f", slips to {slip:.0e} nm"
    rest = points[points.index(cheap) + 1 :]
    worse = [f"{p.value:g} leaves {p.branch_error:.0e}" for p in rest if chosen([p]) is None]
    more = f"{finer} buys nothing visible" if rest else f"{finer} was not tried"
    more = f"yet {finer} is not always better: {', '.join(worse)}" if worse else more
    return (
        f"{sweep} {cheap.value:g} gives F to {cheap.F:.0e}, L to {cheap.L:.0e}, A to {cheap.A:.0e}{place}"
        f" in {cheap.seconds:.2g} s; {more}."
    )


def chosen(points):
    """The first Point with errors below VISIBLE, every branch that of the reference; None if there is none."""
    return next((p for p in points if p.branch_error <= VISIBLE and p.branches[0] == p.branches[1]), None)


def _price(report):
    """How many times the work of fast every other method needs, at the smallest tolerance that both finished."""
    parts = []
    mine = {p.value: p for p in report.of("tolerance", "fast") if not p.failure}
    for series in dict.fromkeys(p.series for p in report.of("tolerance")):
        common = [p for p in report.of("tolerance", series) if not p.failure and p.value in mine]
        if series != "fast" and common:
            point = min(common, key=lambda p: p.value)
            own = mine[point.value]
            work, time = point.evaluations / max(own.evaluations, 1), point.seconds / own.seconds
            parts.append(f"{series} {_round(work)} ({_round(time)} times the time, both at {point.value:g})")
    return f"Times the force evaluations of fast: {', '.join(parts)}." if parts else ""


def branches(report):
    """After how many slips the branch was the reference's, and every series for which it was not."""
    right, told = _counted(report.points)
    if told == 0:
        return "There are no slips to compare."
    wrong = []
    for series in dict.fromkeys(p.series for p in report.points):
        own, slips = _counted([p for p in report.points if p.series == series])
        if own < slips:
            wrong.append(f"{series} after {slips - own} of {slips}")
    counted = f"The reference's branch was reached after {right} of {told} slips of all runs"
    return f"{counted}." if not wrong else f"{counted}; another one by {', '.join(wrong)} (see the tables)."


def _counted(points):
    """(slips after which the branch was right, slips after which it could be told) of all these Points."""
    return sum(p.branches[0] for p in points), sum(p.branches[1] for p in points)


def failures(report):
    """A line for every run that did not finish."""
    return [f"{p.series}, {p.sweep} {p.value:g}: {p.failure}" for p in report.points if p.failure]


def table(report, sweep):
    """Rows of text: the head, then series and numbers of every Point of a sweep."""
    rows = [("series", *HEAD)]
    for p in report.of(sweep):
        errors = [_short(getattr(p, name)) for name in QUANTITIES]
        place = _short(p.worst("position", DIRECTION[sweep][2]))
        seconds = "-" if p.seconds is None else f"{p.seconds:.3g}"
        right = "{} of {}".format(*p.branches) if p.branches[1] else "-"
        count = "-" if p.evaluations is None else str(p.evaluations)
        rows.append((p.series, f"{p.value:g}", seconds, count, *errors, place, _short(p.worst("force")), right))
    return rows


def _round(value):
    """Two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def _short(value):
    return "-" if value is None else f"{value:.1e}"


def title(report):
    """The scene's parameters that differ from the default, and how far the runs go."""
    return f"{changes(report.scene) or 'default scene'}, up to U_x = {report.horizon:g} nm"


def command(report):
    """The command that makes this report."""
    changed = changes(report.scene)
    options = " --quick" if report.quick else ""
    options += f" --slips {report.slips}" if report.slips != SLIPS[report.quick] else ""
    return f"python -m solver accuracy{options}" + (f" --set {changed}" if changed else "")


def notes(report):
    """How the numbers were made, as lines of text."""
    du_x, du_z = report.steps
    return [
        f"Runs end at U_x = {report.horizon:g} nm, just beyond slip {report.slips} in shear or at u_x_max;"
        f" each is stopped after {LONGEST[report.quick]:g} s. Seconds are those of one core.",
        f"Reference: fast, tolerance {report.tolerance:g} nm, du_x = {du_x:g}, du_z = {du_z:g}, {report.seconds:.2g} s;"
        " for the window sweeps also with that window widened until it cuts nothing off.",
        "F, L, A: largest error before the first slip over the largest value. slip: farthest slip off its place in"
        " the reference (du_z: in approach; others: in shear). F_s: error of F there over the largest F.",
        f"same branch: states right after a slip, at the same load, differ by less than {SAME_BRANCH:g} of"
        " min(delta_n, delta_t).",
        "gfmd and its kin notice a slip at the increment it happens in, and report the load before it.",
    ]


def text(report):
    """The whole report for people, in lines."""
    lines = [title(report), *notes(report)]
    for sweep in SWEEPS:
        rows = table(report, sweep)
        if len(rows) > 1:
            widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
            unit = LIMITS[sweep].unit
            lines += ["", f"{sweep} [{unit}]"]
            lines += [
                "  ".join(
                    cell.ljust(w) if i == 0 else cell.rjust(w)
                    for i, (cell, w) in enumerate(zip(row, widths, strict=True))
                )
                for row in rows
            ]
            lines.append(choice(report, sweep))
    return "\n".join([*lines, "", *failures(report), sentence(report)])


def data(report):
    """The report as plain data, for JSON."""
    points = [asdict(p) | {"branches_right": p.branches[0], "branches_told": p.branches[1]} for p in report.points]
    known = [dict(zip(("stage", "load", "F_bar"), slip, strict=True)) for slip in report.known_slips]
    return {
        "command": command(report),
        "scene": asdict(report.scene),
        "quick": report.quick,
        "U_x_end": report.horizon,
        "slips_wanted": report.slips,
        "reference": {
            "tolerance": report.tolerance,
            "du_x": report.steps[0],
            "du_z": report.steps[1],
            "seconds": report.seconds,
            "slips": known,
        },
        "same_branch_within": SAME_BRANCH,
        "points": points,
        "sentence": sentence(report),
        "sentences": {sweep: choice(report, sweep) for sweep in SWEEPS if report.of(sweep)},
    }
