"""The commands that compute many scenes, on this machine or on a cluster: `stability`, and of flats `map`."""

import csv
import math
import os

from . import __version__
from .command import (
    NOT_CONVERGED,
    InputError,
    check_writable,
    progress,
    scene_of,
    settings,
    writing,
)
from .files import write_json
from .isolated import Lost, outcomes


def add_scheduler(parser):
    """Adds --scheduler."""
    said = "compute on a dask cluster, tcp://host:8786, whose workers have this version and one thread each"
    parser.add_argument("--scheduler", metavar="ADDRESS", help=said)


def add_stability(commands):
    """Adds `stability` to the subcommands."""
    text = "Stiff and extreme scenes, each checked by sums in extended precision; closed forms; conditioning."
    parser = commands.add_parser("stability", help="stiff and extreme scenes", description=text)
    parser.add_argument("--quick", action="store_true", help="some 200 scenes, a few minutes")
    parser.add_argument("--scenes", nargs="+", type=int, metavar="N", help="those numbers only, without closed forms")
    parser.add_argument("--limit", type=float, metavar="SECONDS", help="for one scene, 1 or more; 120 unless told")
    add_scheduler(parser)
    parser.add_argument("--json", metavar="FILE", help="write every number")
    parser.add_argument("--html", metavar="FILE", help="write the report as a page that opens offline")
    parser.set_defaults(command=stability)


def stability(arguments):
    """Computes the atlas, writes the files asked for, prints tables; 1 if anything came out as it must not."""
    from .verification import atlas_report, closed_forms, conditioning  # what `run` does not need
    from .verification.atlas import cases
    from .verification.robustness import LIMIT, atlas

    limit = LIMIT if arguments.limit is None else arguments.limit
    if not 1.0 <= limit < math.inf:
        raise InputError(f"--limit {limit:g}: allowed: 1 or more seconds")
    asked = cases(arguments.quick)
    if strange := set(arguments.scenes or ()) - {case.number for case in asked}:
        raise InputError(f"--scenes {min(strange)}: allowed: 0 .. {len(asked) - 1}")
    for option in ("json", "html"):
        check_writable(option, getattr(arguments, option))
    with progress(100, "%") as bar:
        asked = [case for case in asked if arguments.scenes is None or case.number in arguments.scenes]
        results = atlas(asked, arguments.scheduler, lambda part: bar.update(int(100 * part) - bar.n), limit)
    forms = closed_forms.closed_forms() if arguments.scenes is None else []
    report = results, forms, conditioning.conditioning()
    print(atlas_report.text(*report))
    with writing():
        if arguments.json is not None:
            write_json(arguments.json, {"version": __version__} | atlas_report.data(*report))
        if arguments.html is not None:
            atlas_report.write_page(arguments.html, *report)
    return NOT_CONVERGED if atlas_report.failed(*report) else 0


def flats(arguments):
    """Computes the map of regimes of flats and writes it; 1 if a point has no result but a reason."""
    from .analysis.regimes import COLUMNS, LIMIT, points, regime  # what `run` does not need

    if not 2 <= arguments.points <= 100:
        raise InputError(f"--points {arguments.points}: allowed: 2 .. 100")
    asked = points(scene_of(settings(arguments.set)), arguments.points)
    check_writable("csv", arguments.csv)
    rows = [None] * len(asked)
    with progress(len(asked), " points") as bar:
        for k, found in outcomes(regime, asked, arguments.scheduler or os.cpu_count() or 1, LIMIT):
            _, E, phi_t = asked[k]
            rows[k] = {"E": E, "phi_t": phi_t, "reason": found.reason} if isinstance(found, Lost) else found
            bar.update()
    with writing(), open(arguments.csv, "w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    without = sum(bool(row["reason"]) for row in rows)
    print(
        f"{len(rows)} points: {sum(bool(row.get('slips')) for row in rows)} stick and slip, {without} without a result"
    )
    return NOT_CONVERGED if without else 0
