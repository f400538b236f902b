"""The command line: `python -m solver run` computes one experiment; see `--help`."""

import argparse
import csv
import json
import os
import sys
from collections import deque
from contextlib import suppress
from dataclasses import asdict, fields, replace
from math import isfinite, nan
from time import perf_counter

import numpy as np

from . import LIMITS, METHODS, NotConverged, Scene, SceneError, __version__, load_path, scene_from_text, summarize
from .left_out import account
from .progress import Progress

COLUMNS = ("U_x", "F_bar", "L_bar", "A_bar", "residual", "evaluations", "slip")
# Small, and yet they stick, slip and stick again: they compile every kernel before the clock starts. Two, because
# arrays of a part of the surface and of all of it differ in layout, and Numba compiles for each.
WARM_UP = [
    Scene(nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=10.0),
    Scene(nodes=16, width=40.0, delta_bar=0.1, du_z=0.5, du_x=0.5, u_x_max=8.0),
]
NO_FIELD = np.empty((2, 0))
NOT_CONVERGED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit codes


class InputError(ValueError):
    """Bad input on the command line; the message is one line that names it and says what is allowed."""


class Parser(argparse.ArgumentParser):
    """Reports an error in one line, without the usage text."""

    def error(self, message):
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n")


def main(argv=None):
    """Runs the subcommand named in `argv` and returns the exit code."""
    parser = Parser(prog="python -m solver", description="Adhesive contacts under mixed-mode loading.")
    parser.add_argument("--version", action="version", version=__version__)
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    for add in (add_run, add_accuracy, add_stability):
        add(commands)
    arguments = parser.parse_args(argv)
    try:
        return arguments.command(arguments)
    except (InputError, SceneError) as error:
        print(error, file=sys.stderr)
        return BAD_INPUT


def add_run(commands):
    """Adds `run` to the subcommands."""
    parser = commands.add_parser(
        "run",
        help="compute one experiment",
        description="Approach, then shear: computes one experiment and prints a summary.",
        epilog=parameter_table(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="parameters, listed below"
    )
    parser.add_argument("--method", choices=METHODS, default="fast", help="default: fast; gfmd is the reference")
    parser.add_argument("--csv", metavar="FILE", help="write the curves, a row per shear increment")
    parser.add_argument("--npz", metavar="FILE", help="write the curves and the fields of every shear increment")
    parser.add_argument("--json", metavar="FILE", help="write scene, version, method and summary")
    parser.set_defaults(command=run)


def add_accuracy(commands):
    """Adds `accuracy` to the subcommands."""
    parser = commands.add_parser(
        "accuracy",
        help="error against run time",
        description="Error against run time of one experiment, by every method, swept over tolerance, steps, windows.",
        epilog=parameter_table(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--set", nargs="+", action="extend", default=[], metavar="NAME=VALUE", help="as in run")
    parser.add_argument("--quick", action="store_true", help="one slip and fewer runs: some ten seconds, not a minute")
    parser.add_argument("--slips", type=int, metavar="N", help="end beyond slip N in shear, default 2 (quick 1)")
    parser.add_argument("--json", metavar="FILE", help="write every number")
    parser.add_argument("--html", metavar="FILE", help="write the diagram as a page that opens offline")
    parser.set_defaults(command=accuracy)


def accuracy(arguments):
    """Measures error against run time, writes the files asked for, prints tables; returns the exit code."""
    from . import plotpage, verdict  # what `run` does not need
    from .accuracy import measure

    scene = scene_from_text(settings(arguments.set))
    if arguments.slips is not None and arguments.slips < 1:
        raise InputError(f"--slips {arguments.slips}: allowed: 1 or more")
    for option in ("json", "html"):
        check_writable(option, getattr(arguments, option))
    try:
        with Progress(100, unit="per cent") as progress:
            for done, so_far in measure(scene, arguments.quick, arguments.slips):
                progress(int(100 * done))
                report = so_far
    except (NotConverged, KeyboardInterrupt) as error:
        print(str(error) or "Interrupted; run again to finish", file=sys.stderr)
        return NOT_CONVERGED if isinstance(error, NotConverged) else INTERRUPTED
    print(verdict.text(report))
    try:
        if arguments.json is not None:
            write_json(arguments.json, {"version": __version__} | verdict.data(report))
        if arguments.html is not None:
            plotpage.write_page(arguments.html, report)
    except OSError as error:
        raise InputError(f"Writing the results failed: {error}; name a file where there is room") from None
    return 0


def add_stability(commands):
    """Adds `stability` to the subcommands."""
    text = "Stiff and extreme scenes, each checked by sums in extended precision; closed forms; conditioning."
    parser = commands.add_parser("stability", help="stiff and extreme scenes", description=text)
    parser.add_argument("--quick", action="store_true", help="some 200 scenes, about a minute")
    parser.add_argument("--json", metavar="FILE", help="write every number")
    parser.add_argument("--html", metavar="FILE", help="write the report as a page that opens offline")
    parser.set_defaults(command=stability)


def stability(arguments):
    """Computes the atlas, writes the files asked for, prints tables; 1 if anything came out as it must not."""
    from . import atlas_report, closed_forms, conditioning  # what `run` does not need
    from .stability import atlas

    for option in ("json", "html"):
        check_writable(option, getattr(arguments, option))
    try:
        with Progress(100, unit="per cent") as progress:
            results = atlas(arguments.quick, progress=lambda part: progress(int(100 * part)))
        report = results, closed_forms.closed_forms(), conditioning.conditioning()
    except KeyboardInterrupt:
        print("Interrupted; run again to finish", file=sys.stderr)
        return INTERRUPTED
    print(atlas_report.text(*report))
    try:
        if arguments.json is not None:
            write_json(arguments.json, {"version": __version__} | atlas_report.data(*report))
        if arguments.html is not None:
            atlas_report.write_page(arguments.html, *report)
    except OSError as error:
        raise InputError(f"Writing the results failed: {error}; name a file where there is room") from None
    return NOT_CONVERGED if atlas_report.failed(*report) else 0


def parameter_table():
    """Every parameter with its range, default, unit and meaning, as text."""
    lines = ["parameters:", "  surface     circular | flat, default circular"]
    for name, (low, high, unit, meaning) in LIMITS.items():
        default = next(f.default for f in fields(Scene) if f.name == name)
        span = f"{low:g} .. {high:g}" + (f" [{unit}]" if unit else "")
        lines.append(f"  {name:<11} {span}, default {default:g}: {meaning}")
    return "\n".join(lines)


def run(arguments):
    """Computes the experiment, writes the files asked for, prints a summary; returns the exit code."""
    scene = scene_from_text(settings(arguments.set))
    for option in ("csv", "npz", "json"):
        check_writable(option, getattr(arguments, option))
    for small in WARM_UP:
        with suppress(NotConverged):
            deque(load_path(small, method=arguments.method), maxlen=0)
    start = perf_counter()
    frames, failure, code = compute(scene, arguments.method, fields_too=arguments.npz is not None)
    seconds = perf_counter() - start
    report = {"version": __version__, "method": arguments.method, "scene": asdict(scene)}
    left_out = account(scene, frames) if arguments.method == "fast" else {}
    report |= summarize(scene, frames) | {"seconds": seconds, "failure": failure, "left_out": left_out}
    shear = [frame for frame in frames if frame.stage == "shear"]
    print(described(report, len(frames)))
    try:
        if arguments.csv is not None:
            write_csv(arguments.csv, shear)
        if arguments.npz is not None:
            write_npz(arguments.npz, scene, shear)
        if arguments.json is not None:
            write_json(arguments.json, report)
    except OSError as error:
        raise InputError(f"Writing the results failed: {error}; name a file where there is room") from None
    if failure is not None:
        print(failure, file=sys.stderr)
    return code


def settings(pairs):
    """{'name': 'text'} from NAME=VALUE arguments; raises InputError."""
    texts = {}
    for pair in pairs:
        name, equals, text = pair.partition("=")
        if not equals:
            names = ", ".join(f.name for f in fields(Scene))
            raise InputError(f"--set {pair}: give NAME=VALUE, NAME one of {names}")
        texts[name.strip()] = text.strip()
    return texts


def check_writable(option, file):
    """Raises InputError where the file of --option cannot be written; leaves what is there as it is."""
    if file is None:
        return
    new = not os.path.lexists(file)
    try:
        with open(file, "ab"):
            pass
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"--{option} {file!r}: {reason}; allowed: a writable file in an existing directory") from None
    if new:
        os.remove(file)


def compute(scene, method, fields_too):
    """(frames, failure, exit code) of the whole load path, frames up to the failure; u and T only if asked for."""
    frames = []
    try:
        with Progress(scene.approach_increments + scene.shear_increments + 2) as progress:
            for frame in load_path(scene, method=method):
                if frames and not fields_too:  # a curve needs no fields; the last ones stay, for `account`
                    frames[-1] = replace(frames[-1], u=NO_FIELD, T=NO_FIELD)
                frames.append(frame)
                progress(len(frames))
                if not frame.residual <= scene.tolerance:  # a contract of load_path; nan fails it too
                    return frames, unfinished(scene, frame), NOT_CONVERGED
    except NotConverged as error:
        return frames, str(error), NOT_CONVERGED
    except KeyboardInterrupt:
        place = f"at {frames[-1].stage} increment {frames[-1].index}" if frames else "before the first increment"
        return frames, f"Interrupted {place}; run again to finish", INTERRUPTED
    return frames, None, 0


def unfinished(scene, frame):
    """The place and a remedy for a frame above tolerance."""
    return (
        f"Not converged at U_x = {frame.U_x:g} nm, delta = {frame.delta:g} nm: residual {frame.residual:.2g} nm,"
        f" tolerance = {scene.tolerance:g} nm; try a smaller du_x and du_z, or a larger tolerance"
    )


def write_csv(file, frames):
    """A row per frame, numbers in full precision."""
    with open(file, "w", newline="", encoding="utf-8") as out:
        writer = csv.writer(out, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([number(getattr(frame, name)) for name in COLUMNS] for frame in frames)


def number(value):
    """A plain int or float, whose text is exact; booleans become 0 and 1."""
    return float(value) if isinstance(value, (float, np.floating)) else int(value)


def write_npz(file, scene, frames):
    """Curves (frames,), x (m,) nm, u and T (frames, 2, m); nodes outside a frame's own patch hold nan and 0."""
    first = min((frame.first for frame in frames), default=0)
    last = max((frame.first + frame.u.shape[1] for frame in frames), default=0)
    u = np.full((len(frames), 2, last - first), nan)
    T = np.zeros_like(u)
    for k, frame in enumerate(frames):
        patch = slice(frame.first - first, frame.first - first + frame.u.shape[1])
        u[k, :, patch], T[k, :, patch] = frame.u, frame.T
    curves = {name: np.array([number(getattr(frame, name)) for frame in frames]) for name in COLUMNS}
    with open(file, "wb") as out:  # an open file, or NumPy would append .npz to the name that was asked for
        np.savez_compressed(out, x=np.arange(first, last) * scene.spacing, u=u, T=T, **curves)


def write_json(file, report):
    """Strict JSON: what is not a number becomes null."""
    with open(file, "w", encoding="utf-8") as out:
        json.dump(plain(report), out, indent=2, allow_nan=False)
        out.write("\n")


def plain(value):
    """The same in types JSON knows."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not isfinite(value) else value


def described(report, increments):
    """The summary in a few lines for people."""

    def shown(name, unit=""):
        value = report.get(name)
        return f"{name} = " + ("none" if value is None or value != value else f"{value:.6g}{unit}")

    slips = report.get("slips", 0)
    first = f"first at {shown('U_s', ' nm')}: {shown('F_s')}, {shown('A_s')}" if slips else "the contact sticks"
    state = "converged" if report["converged"] else "NOT converged"
    return (
        f"{report['method']}: {increments} increments {state}, {report.get('evaluations', 0)} evaluations,"
        f" {report['seconds']:.3g} s\n{shown('A_0')}\n{slips} slips; {first}"
    )


if __name__ == "__main__":
    sys.stdout.reconfigure(errors="replace")  # units in --help are Greek, which some terminals cannot show
    sys.exit(main())
