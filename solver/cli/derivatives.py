"""The commands that need derivatives of a run: `sensitivities` and `fit`."""

import argparse
from collections.abc import Callable
from functools import partial
from typing import Any

from .. import plots, skeleton_of
from ..analysis import fit as fits
from ..analysis import sensitivities as analysis
from ..analysis.curve_files import read_measurement
from ..analysis.fit import LIMIT, UNITS
from ..analysis.trial import AXES
from ..files import write_json, write_rows
from ..scene import LIMITS, Scene
from .options import (
    NOT_CONVERGED,
    InputError,
    add_command,
    add_file,
    add_plot,
    caution,
    within,
    write,
)

SLIP = ("U_s", "F_s", "L_s", "A_s")  # the derivatives of a slip
VERDICTS = {  # by whether the curve fits within the noise, and whether nothing limits what that means
    (True, True): "The curve fits the data, and the data determine the parameters.",
    (True, False): "The curve fits the data. The cautions name what limits this result.",
    (False, True): "The search found no curve within the noise.",
    (False, False): "The search found no curve within the noise. The cautions name possible reasons.",
}


def _add(commands: Any, name: str, run: Callable, summary: str, text: str, table: str) -> argparse.ArgumentParser:
    """Adds a subcommand with --json and --csv; table: what the CSV has a row for."""
    parser = add_command(commands, name, run, summary, text)
    add_file(parser, "json", "all results")
    add_file(parser, "csv", f"a row per {table}")
    return parser


def add_sensitivities(commands: Any) -> None:
    """Adds `sensitivities` to the subcommands."""
    text = "Derivatives of every slip's U_s, F_s, L_s and A_s by every continuous parameter of an experiment."
    _add(commands, "sensitivities", sensitivities, "derivatives of slips by the parameters", text, "slip and parameter")


def sensitivities(scene: Scene, arguments: argparse.Namespace) -> int:
    """Computes the derivatives, writes the files asked for, prints those of the first slip; returns the exit code."""
    rows, slips = [], []
    for k, slip in enumerate(analysis.sensitivities(skeleton_of(scene)).slips, 1):
        per_cent, by = slip.per_cent(scene), {}
        for name, per_unit in slip.by.items():
            by[name] = {"per_unit": _named(per_unit), "per_cent": _named(per_cent[name])}
            rows.append([k, slip.event.load, name, getattr(scene, name), *per_unit, *per_cent[name]])
        slips.append({"slip": _named(slip.values), "by": by, "nodes": _named(slip.nodes)})
    if slips:
        print(f"First slip at U_s = {rows[0][1]:.6g} nm; change in % per % of the parameter:")
        print(f"{'':12}" + "".join(f"{name:>10}" for name in SLIP))
        for name, change in slips[0]["by"].items():
            shares = "".join(f"{share:10.4f}" for share in change["per_cent"].values())
            print(f"{name:12}{shares if getattr(scene, name) else '  is 0: --csv has its derivatives'}")
    else:
        print(f"The run has no slip up to u_x_max = {scene.u_x_max:g} nm: there is none to differentiate")
    heading = ["slip", "U_x", "parameter", "value", *(f"d{name}" for name in SLIP)]
    write(arguments.csv, write_rows, [*heading, *(f"{name} % per %" for name in SLIP)], rows)
    write(arguments.json, write_json, {"slips": slips})
    return 0


def _named(values: Any) -> dict[str, Any]:
    """{U_s, F_s, L_s, A_s: row} of an array (4, ...)."""
    return dict(zip(SLIP, values.tolist(), strict=True))


def add_fit(commands: Any) -> None:
    """Adds `fit` to the subcommands."""
    text = "Fits parameters to a measured curve: friction F over U_x, and load L and contact area A where measured."
    parser = _add(commands, "fit", fit, "parameters from a measured curve", text, "measured point")
    parser.usage = f"{parser.prog} FILE --free NAME [NAME ...] [options]"  # argparse would print FILE behind the names
    columns = "a CSV with columns U_x (nm) and F (N/m) or F_bar; L or L_bar and A_bar if measured"
    parser.add_argument("file", metavar="FILE", help=columns)
    free = f"continuous parameters of the scene, or of the measurement: {', '.join(AXES)}"
    parser.add_argument("--free", nargs="+", required=True, metavar="NAME", help=free)
    add_plot(parser, "data, fitted curve and residuals")
    limit = "time limit, default %(default)g"
    parser.add_argument("--limit", type=within(0.0, kind=float), default=LIMIT, metavar="SECONDS", help=limit)


def fit(scene: Scene, arguments: argparse.Namespace) -> int:
    """Fits and prints values with their errors; returns the exit code."""
    try:
        measured = read_measurement(scene, arguments.file)
        result = fits.fit(scene, measured, arguments.free, arguments.limit)
    except ValueError as error:  # DataError among them
        raise InputError(str(error)) from None
    for note in measured.notes:
        print(note)
    for name, value in result.values.items():
        unit = LIMITS[name].unit if name in LIMITS else UNITS.get(name, "")
        print(f"{name:12} {value:12.6g} +- {result.errors[name]:.2g} {unit}".rstrip())
    print(f"chi^2 per degree of freedom {result.chi2:.3g}, {result.runs} runs")
    print(VERDICTS[result.reached, not result.warnings])
    caution(result.warnings)
    write(arguments.html, partial(plots.save, title=repr(scene)), plots.comparison, result.rows)
    write(arguments.csv, write_rows, ["U_x", "quantity", "measured", "model"], result.rows)
    write(arguments.json, write_json, result.as_dict())
    return 0 if result.reached else NOT_CONVERGED
