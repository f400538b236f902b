"""The command `run`: one experiment, its summary and files."""

import argparse
import sys
from collections import deque
from contextlib import suppress
from math import inf
from time import perf_counter
from typing import Any

from .. import METHODS, Frame, NotConverged, Scene, load_path
from ..cautions import cautions
from ..continuation.state import Outcome
from ..files import report_of, write_json, write_npz, write_table
from ..results import Result, ended, keep, with_progress
from ..run.held_load import held_at
from ..run.loadpath import deadline, time_limit
from ..text import counted
from .measured import add_curve, compared, curve_of, reading
from .options import INTERRUPTED, NOT_CONVERGED, add_command, add_file, add_limit, caution, write

# These small runs stick and slip: they load or compile every kernel before the clock starts. The patch of the first is
# a part of the cell, that of the second all of it: arrays of another layout, for which Numba compiles again.
WARM_UP = [
    Scene(nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=10.0),
    Scene(nodes=16, width=40.0, delta_bar=0.1, du_z=0.5, du_x=0.5, u_x_max=8.0),
]


def add_run(commands: Any) -> None:
    """Adds `run` to the subcommands."""
    text = "Computes one experiment: the approach, then the shear or another path. Prints the first slip."
    parser = add_command(commands, "run", run, "compute one experiment", text)
    parser.add_argument("--method", choices=METHODS, default="fast", help="default fast; gfmd is the slower reference")
    load = "hold this normal load during the shear, in place of delta_bar and hold; negative for a pull"
    parser.add_argument("--load", type=float, metavar="N/m", help=load)
    add_limit(parser)
    add_curve(parser)
    add_file(parser, "csv", "the curves: a row per increment")
    add_file(parser, "npz", "curves and fields of the increments after the approach")
    add_file(parser, "json", "scene, version, method and summary, for `verify`")


def run(scene: Scene, arguments: argparse.Namespace) -> int:
    """Computes the experiment, writes the files asked for, prints a summary; returns the exit code."""
    curve = curve_of(scene, reading(arguments))
    for small in WARM_UP:
        with suppress(NotConverged):
            deque(load_path(small, method=arguments.method), maxlen=0)
    before = cautions(scene)
    caution(before)
    start = perf_counter()
    result = compute(scene, arguments.method, arguments.limit, arguments.load)
    scene, frames, failure = result.scene, result.frames, result.failure
    report = report_of(scene, frames, arguments.method, perf_counter() - start, failure, result.outcome)
    caution(sentence for sentence in report["cautions"] if sentence not in before)
    for note in scene.measured.notes if scene.measured else ():
        print(f"profile: {note}")
    print(described(report, len(frames), result.parted))
    write(arguments.csv, lambda file: write_table(file, result.table))  # which imports pandas
    write(arguments.npz, write_npz, scene, frames, arguments.method, result.outcome)
    write(arguments.json, write_json, report)
    if failure is not None:
        print(failure, file=sys.stderr)
    if curve is not None:
        print(compared(curve, result))
    if result.outcome is Outcome.INTERRUPTED:
        return INTERRUPTED
    return 0 if report["converged"] else NOT_CONVERGED


def compute(scene: Scene, method: str, limit: float | None = None, load: float | None = None) -> Result:
    """The Result of a load path, to its end, a failure or an interruption; load: N/m to hold, in place of delta_bar.

    limit: processor time, s. By default it is that of `time_limit`, but none for gfmd, which is slow by design.
    """
    frames: list[Frame] = []
    default = None if method == "fast" else inf
    whole = time_limit(scene, default if limit is None else limit)
    soft = f"So soft a layer may take long. The run ends after {whole:g} s of processor time: --limit allows more."
    caution([soft] * (limit is None and whole < inf))
    try:
        if load is not None:
            scene, *_ = held_at(scene, load, deadline(whole, inf))
            print(f"delta_bar = {scene.delta_bar:.6g}, where the approach reaches {load:g} N/m")
        for frame in with_progress(scene, load_path(scene, method=method, limit=whole), leave=False, disable=None):
            keep(frames, frame)
    except NotConverged as error:
        return ended(scene, frames, error)
    except KeyboardInterrupt:
        position = f"at {frames[-1].stage} increment {frames[-1].index}" if frames else "before the first increment"
        return Result(scene, frames, f"Interrupted {position}; run again to finish", outcome=Outcome.INTERRUPTED)
    return Result(scene, frames)


def described(report: dict[str, Any], increments: int, parted: str = "") -> str:
    """The summary in three lines; parted: where the contact pulled off under its held load."""

    def shown(name, key, unit):
        return f"{name} = " + ("none" if report[key] is None else f"{report[key]:.4g} {unit}")

    if report["U_s"] is not None:
        first = f"first slip at U_x = {report['U_s']:.2f} nm: {shown('F', 'F_s', 'N/m')}, {shown('A', 'A_s', 'nm')}"
    elif "L_min" in report:
        first = f"largest pull {shown('L', 'L_min', 'N/m')}, parting load {shown('L', 'L_off', 'N/m')}"
    elif report["slips"]:
        first = "none along U_x"
    else:
        first = (
            "" if parted else "the run ended early" if report["failure"] else "the contact sticks or slides smoothly"
        )
    state = "converged" if report["converged"] else "NOT converged"
    cost = f"{report['evaluations']} force evaluations, {report['seconds']:.3g} s"
    lines = [f"{report['method']}: {increments} increments, {state}, {cost}"]
    lines += [f"contact area at U_x = 0: {shown('A_0', 'A_0', 'nm')}"]
    first = "; ".join(filter(None, [first, parted and f"{parted[0].lower()}{parted[1:].rstrip('.')}"]))
    return "\n".join([*lines, f"{counted(report['slips'], 'slip')}; {first}"])
