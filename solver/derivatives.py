"""The commands that stand on derivatives of a run: `sensitivities`, `fit` and `spread`."""

import argparse
import csv
import sys

from . import NotConverged, NotFollowed, __version__, skeleton_of
from .command import BAD_INPUT, NOT_CONVERGED, InputError, check_writable, parameter_table, scene_of, settings, writing
from .files import write_json

AT_A_SLIP = ("U_s", "F_s", "L_s", "A_s")


def _command(commands, name, said, description, run):
    """A subcommand of a scene with --set, --json and --csv."""
    parser = commands.add_parser(
        name,
        help=said,
        description=description,
        epilog=parameter_table(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="as in run")
    parser.add_argument("--json", metavar="FILE", help="write every number")
    parser.add_argument("--csv", metavar="FILE", help="write a table")
    parser.set_defaults(command=_guarded(run))
    return parser


def _guarded(run):
    """The command, with a run that has no derivatives told in a sentence."""

    def command(arguments):
        for option in ("json", "csv"):
            check_writable(option, getattr(arguments, option))
        try:
            with writing():
                return run(arguments)
        except (NotConverged, NotFollowed) as error:
            print(f"{error}; derivatives are had of runs that are followed: change a parameter", file=sys.stderr)
            return NOT_CONVERGED

    return command


def write_rows(file, heading, rows):
    """A CSV, if a file is named."""
    if file is None:
        return
    with open(file, "w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(heading)
        writer.writerows(rows)


def write_report(file, report):
    """Strict JSON with the version, if a file is named."""
    if file is not None:
        write_json(file, {"version": __version__} | report)


def add_sensitivities(commands):
    """Adds `sensitivities` to the subcommands."""
    text = "Derivatives of every slip's U_s, F_s, L_s and A_s by every continuous parameter of an experiment."
    _command(commands, "sensitivities", "what matters for when and how it slips", text, sensitivities)


def sensitivities(arguments):
    """Computes and prints them; returns the exit code."""
    from .analysis.sensitivities import sensitivities as found_of  # what `run` does not need

    scene = scene_of(settings(arguments.set))
    found = found_of(skeleton_of(scene))
    rows = []
    for number, slip in enumerate(found.slips, 1):
        shares = slip.per_cent(scene)
        rows += [
            [number, slip.event.load, name, getattr(scene, name), *map(float, d), *map(float, shares[name])]
            for name, d in slip.by.items()
        ]
    if not rows:
        print("It slides smoothly, without a slip: no U_s to change")
    elif found.slips:
        print(f"First slip at U_s = {found.slips[0].event.load:.6g} nm; change in % per % of the parameter:")
        print(f"{'':12}" + "".join(f"{name:>10}" for name in AT_A_SLIP))
        for row in (row for row in rows if row[0] == 1):
            print(f"{row[2]:12}" + "".join(f"{share:10.4f}" for share in row[8:]))
    per_cent = [f"{name} % per %" for name in AT_A_SLIP]
    write_rows(
        arguments.csv, ["slip", "U_x", "parameter", "value", *(f"d{name}" for name in AT_A_SLIP), *per_cent], rows
    )
    write_report(arguments.json, {"slips": [_told(scene, slip) for slip in found.slips]})
    return 0


def _told(scene, slip):
    """A SlipSensitivity by plain names."""
    shares = slip.per_cent(scene)
    named = {
        name: {
            "per_unit": dict(zip(AT_A_SLIP, map(float, d), strict=True)),
            "per_cent": dict(zip(AT_A_SLIP, map(float, shares[name]), strict=True)),
        }
        for name, d in slip.by.items()
    }
    nodes = {name: [float(value) for value in row] for name, row in zip(AT_A_SLIP, slip.nodes, strict=True)}
    return {"event": slip.event.as_dict(), "by": named, "nodes": nodes}


def add_fit(commands):
    """Adds `fit` to the subcommands."""
    text = "Fits parameters of an experiment to measured friction: F (and L, A) against U_x."
    parser = _command(commands, "fit", "parameters from a measurement", text, fit)
    parser.add_argument(
        "file", metavar="FILE", help="a CSV with columns U_x and F_bar (or F in N/m), L_bar or L, A_bar"
    )
    parser.add_argument("--free", nargs="+", required=True, metavar="NAME", help="parameters, scale_U, offset_U, ...")
    parser.add_argument("--starts", type=int, default=3, metavar="N", help="from how many places, default 3")


def fit(arguments):
    """Fits and prints values with their errors; returns the exit code."""
    from .analysis.fit import fit as fitted
    from .analysis.measurement import MeasurementError, read_measurement

    scene = scene_of(settings(arguments.set))
    try:
        measured = read_measurement(arguments.file, scene)
        found = fitted(scene, measured, arguments.free, starts=arguments.starts)
    except (MeasurementError, ValueError) as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    for name, value in found.values.items():
        print(f"{name:12} {value:12.6g} +- {found.errors[name]:.2g}")
    print(f"chi^2 per degree of freedom {found.chi2:.3g}, {found.runs} runs followed")
    for sentence in found.warnings:
        print(f"Caution: {sentence}", file=sys.stderr)
    write_rows(arguments.csv, ["U_x", "quantity", "measured", "model"], found.rows)
    write_report(arguments.json, found.as_dict())
    return 0 if found.reached else NOT_CONVERGED


def add_spread(commands):
    """Adds `spread` to the subcommands."""
    text = "What a spread of parameters makes of the curves and of the static friction force."
    parser = _command(commands, "spread", "curves of parameters that are not known exactly", text, spread)
    parser.add_argument("--of", nargs="+", required=True, metavar="NAME=SHARE", help="standard deviation: phi_n=10%%")
    parser.add_argument("--draws", type=int, default=0, metavar="N", help="check by as many followed runs")


def spread(arguments):
    """Computes the band, prints the interval of each slip; returns the exit code."""
    from .analysis.spread import deviations, spread_of

    scene = scene_of(settings(arguments.set))
    try:
        of = deviations(scene, settings(arguments.of))
        if arguments.draws < 0:
            raise ValueError(f"--draws {arguments.draws}: allowed: 0 or more")
    except ValueError as error:
        raise InputError(str(error)) from None
    found = spread_of(skeleton_of(scene), of, arguments.draws)
    for sentence in found.sentences():
        print(sentence)
    write_rows(arguments.csv, ["branch", "U_x", "F_bar", "L_bar", "A_bar", "sd_F", "sd_L", "sd_A"], found.rows())
    write_report(arguments.json, found.as_dict())
    return 0
