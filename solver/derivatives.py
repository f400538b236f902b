"""The commands that stand on derivatives of a run: `sensitivities`, `fit` and `spread`."""

import sys

from . import skeleton_of
from .command import NOT_CONVERGED, InputError, add_command, add_file, scene_of, settings, write
from .files import write_json, write_rows

AT_A_SLIP = ("U_s", "F_s", "L_s", "A_s")


def _command(commands, name, *given):
    """A subcommand with --json and --csv."""
    parser = add_command(commands, name, *given)
    add_file(parser, "json", "every number")
    add_file(parser, "csv", "a table")
    return parser


def add_sensitivities(commands):
    """Adds `sensitivities` to the subcommands."""
    text = "Derivatives of every slip's U_s, F_s, L_s and A_s by every continuous parameter of an experiment."
    _command(commands, "sensitivities", sensitivities, "what matters for when and how it slips", text)


def sensitivities(arguments):
    """Computes and prints them; returns the exit code."""
    from .analysis.sensitivities import sensitivities as found_of  # what `run` does not need

    scene = scene_of(settings(arguments.set))
    slips = found_of(skeleton_of(scene)).slips
    told = [_told(scene, slip) for slip in slips]
    rows = [
        [number, slip.event.load, name, getattr(scene, name), *by["per_unit"].values(), *by["per_cent"].values()]
        for number, (slip, one) in enumerate(zip(slips, told, strict=True), 1)
        for name, by in one["by"].items()
    ]
    if slips:
        print(f"First slip at U_s = {slips[0].event.load:.6g} nm; change in % per % of the parameter:")
        print(f"{'':12}" + "".join(f"{name:>10}" for name in AT_A_SLIP))
        for name, by in told[0]["by"].items():
            print(f"{name:12}" + "".join(f"{share:10.4f}" for share in by["per_cent"].values()))
    else:
        print("It slides smoothly, without a slip: no U_s to change")
    heading = ["slip", "U_x", "parameter", "value", *(f"d{name}" for name in AT_A_SLIP)]
    write(arguments.csv, write_rows, [*heading, *(f"{name} % per %" for name in AT_A_SLIP)], rows)
    write(arguments.json, write_json, {"slips": told})
    return 0


def _told(scene, slip):
    """A SlipSensitivity by plain names."""

    def named(values):
        return dict(zip(AT_A_SLIP, values.tolist(), strict=True))

    shares = slip.per_cent(scene)
    by = {name: {"per_unit": named(d), "per_cent": named(shares[name])} for name, d in slip.by.items()}
    return {"event": slip.event.as_dict(), "by": by, "nodes": named(slip.nodes)}


def add_fit(commands):
    """Adds `fit` to the subcommands."""
    text = "Fits parameters of an experiment to measured friction: F (and L, A) against U_x."
    parser = _command(commands, "fit", fit, "parameters from a measurement", text)
    parser.add_argument(
        "file", metavar="FILE", help="a CSV with columns U_x and F_bar (or F in N/m), L_bar or L, A_bar"
    )
    parser.add_argument("--free", nargs="+", required=True, metavar="NAME", help="parameters, scale_U, offset_U, ...")
    parser.add_argument("--starts", type=int, default=3, metavar="N", help="from how many places, default 3")


def fit(arguments):
    """Fits and prints values with their errors; returns the exit code."""
    from .analysis.fit import fit as fitted
    from .analysis.measurement import read_measurement

    scene = scene_of(settings(arguments.set))
    try:
        found = fitted(scene, read_measurement(arguments.file, scene), arguments.free, starts=arguments.starts)
    except ValueError as error:  # MeasurementError among them
        raise InputError(str(error)) from None
    for name, value in found.values.items():
        print(f"{name:12} {value:12.6g} +- {found.errors[name]:.2g}")
    print(f"chi^2 per degree of freedom {found.chi2:.3g}, {found.runs} runs followed")
    for sentence in found.warnings:
        print(f"Caution: {sentence}", file=sys.stderr)
    write(arguments.csv, write_rows, ["U_x", "quantity", "measured", "model"], found.rows)
    write(arguments.json, write_json, found.as_dict())
    return 0 if found.reached else NOT_CONVERGED


def add_spread(commands):
    """Adds `spread` to the subcommands."""
    text = "What a spread of parameters makes of the curves and of the static friction force."
    parser = _command(commands, "spread", spread, "curves of parameters that are not known exactly", text)
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
    write(arguments.csv, write_rows, ["branch", "U_x", "F_bar", "L_bar", "A_bar", "sd_F", "sd_L", "sd_A"], found.rows())
    write(arguments.json, write_json, found.as_dict())
    return 0
