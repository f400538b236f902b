"""What a work-precision Report means, in words, tables and plain data."""

from dataclasses import asdict

from ..cautions import flutter
from ..scene import LIMITS
from ..text import changes
from .accuracy import LONGEST, SLIPS, SWEEPS, VISIBLE
from .compare import QUANTITIES, SAME_BRANCH
from .landings import SHORT

# sweep: (what the other direction is called, whether a larger value is the cheaper one, stage of the slips it moves)
DIRECTION = {
    "tolerance": ("tighter", True, "shear"),
    "du_x": ("finer", True, "shear"),
    "du_z": ("finer", True, "approach"),
    "window_n": ("wider", False, "shear"),
    "window_t": ("wider", False, "shear"),
}
HEAD = ("series", "value", "seconds", "evaluations", "F", "L", "A", "slip, nm", "F_s", "same branch")


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
            f"No {sweep} tried brings F, L and A to {VISIBLE:g} on the right branches;"
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
    """The first Point with errors below VISIBLE, every branch the right one; None if there is none."""
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
    counted = f"The branch of the paper's GFMD was reached after {right} of {told} slips of all runs"
    counted += f"; another one by {', '.join(wrong)} (see the tables)." if wrong else "."
    astray = _places(report.judgement.differs)
    return counted + (
        f" The reference itself leaves it{astray}: errors of what follows mean nothing." if astray else ""
    )


def judged(report):
    """By what branches are judged, and where that is in doubt; lines of text."""
    j, known = report.judgement, report.known_slips
    near = [f"F, L, A before the first slip to {j.error:.0e}"] if j.error is not None else []
    near += [f"slips in shear to {j.apart:.0e} nm"] if j.apart is not None else []
    lines = [
        f"Branches are judged by gfmd, from rest to rest at tolerance {j.tolerance:g} nm, increments halved to"
        f" {SHORT:g} nm where the surface slips, {j.seconds:.2g} s. The reference follows it through {j.right} of"
        f" {len(known)} slips" + (f"; both agree on {' and '.join(near)}." if near else ".")
    ]
    if j.differs:
        lines.append(f"The reference is on another branch than gfmd{_places(j.differs)}.")
    if j.finer:
        found = f"changes its mind{_places(j.changed)}: not counted" if j.changed else "lands in the same states"
        lines.append(f"With half its time step gfmd {found}.")
    if j.untold:
        lines.append(f"Not judged{_places(j.untold)}: {j.failure or 'the next slip follows too soon'}.")
    return lines


def _places(slips):
    """Where these slips (stage, load) are, as text."""
    names = {"shear": "U_x", "approach": "delta"}
    return " after the slip at " + ", ".join(f"{names[s]} = {load:.5g} nm" for s, load in slips) if slips else ""


def _counted(points):
    """(slips after which the branch was right, slips after which it could be told) of all these Points."""
    return sum(p.branches[0] for p in points), sum(p.branches[1] for p in points)


def failures(report):
    """A line for every run that did not finish."""
    return [f"{p.series}, {p.sweep} {p.value:g}: {p.failure}" for p in report.points if p.failure]


def table(report, sweep):
    """The Points of a sweep as a DataFrame of text."""
    from pandas import DataFrame  # takes longer to import than the solver

    rows = []
    for p in report.of(sweep):
        errors = [_short(getattr(p, name)) for name in QUANTITIES]
        place = _short(p.worst("position", DIRECTION[sweep][2]))
        seconds = "-" if p.seconds is None else f"{p.seconds:.3g}"
        right = "{} of {}".format(*p.branches) if p.branches[1] else "-"
        count = "-" if p.evaluations is None else str(p.evaluations)
        rows.append((p.series, f"{p.value:g}", seconds, count, *errors, place, _short(p.worst("force")), right))
    return DataFrame(rows, columns=HEAD)


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
        *judged(report),
        *flutter(report.scene, report.safe_damping),
        "F, L, A: largest error before the first slip over the largest value. slip: farthest slip off its place in"
        " the reference (du_z: in approach; others: in shear). F_s: error of F there over the largest F.",
        f"same branch: as gfmd's; states right after a slip, at the same load, differ by less than {SAME_BRANCH:g} of"
        " min(delta_n, delta_t).",
        "gfmd and its kin notice a slip at the increment it happens in, and report the load before it.",
    ]


def text(report):
    """The whole report for people, in lines."""
    lines = [title(report), *notes(report)]
    for sweep in filter(report.of, SWEEPS):
        lines += [
            "",
            f"{sweep} [{LIMITS[sweep].unit}]",
            table(report, sweep).to_string(index=False),
            choice(report, sweep),
        ]
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
            "judged": asdict(report.judgement),
        },
        "same_branch_within": SAME_BRANCH,
        "points": points,
        "sentence": sentence(report),
        "sentences": {sweep: choice(report, sweep) for sweep in SWEEPS if report.of(sweep)},
    }
