"""The command `sweep`: the first slip of every combination of parameter values."""

import argparse
from contextlib import nullcontext
from typing import Any

from .. import sweep
from ..continuation.state import Outcome
from ..executors import processes
from ..files import write_table
from ..scene import LIMITS, PARAMETERS, Scene
from ..schema import unknown_name
from ..text import number_from_text
from .options import NOT_CONVERGED, add_command, add_file, add_limit, count, write
from .pairs import settings

FORM = "NAME=VALUE,VALUE,..."
COMPUTED = ("slips", "no slip", Outcome.PULLED_OFF)  # outcomes that are results


def add_sweep(commands: Any) -> None:
    """Adds `sweep` to the subcommands."""
    text = "Computes the first slip for every combination of parameter values. Prints a row for each."
    epilog = "Columns: the parameters, U_s (nm), F_s, L_s (N/m), A_s (nm), outcome."
    parser = add_command(commands, "sweep", swept, "first slips of combinations of values", text, epilog)
    over = "values of parameters, but one of points"
    parser.add_argument("--over", nargs="+", action="extend", required=True, metavar=FORM, help=over)
    parser.add_argument("--workers", type=count, default=1, metavar="N", help="number of processes, default 1")
    add_limit(parser)
    add_file(parser, "csv", "a row per combination")


def swept(scene: Scene, arguments: argparse.Namespace) -> int:
    """Computes, prints and writes the rows; 1 if a combination has no result."""
    values = {name: _values(name, text) for name, text in settings(arguments.over, "--over", FORM).items()}
    with processes(arguments.workers) if arguments.workers > 1 else nullcontext() as executor:
        table = sweep(scene, executor, arguments.limit, progress=True, **values)
    print(table.to_string(index=False))
    write(arguments.csv, write_table, table)
    return 0 if table["outcome"].isin(COMPUTED).all() else NOT_CONVERGED


def _values(name, text):
    """The values of a parameter in a text with commas between them; raises SceneError."""
    if name not in PARAMETERS:
        raise unknown_name(name, PARAMETERS)
    listed = [text] if name == "points" else text.split(",")  # which have commas of their own
    return [PARAMETERS[name].checked(name, number_from_text(name, one) if name in LIMITS else one) for one in listed]
