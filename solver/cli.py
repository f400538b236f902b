"""The command line: `python -m solver run` computes one experiment; see `--help`."""

import argparse
import sys
from collections import deque
from contextlib import suppress
from dataclasses import asdict, replace
from time import perf_counter

import numpy as np

from . import METHODS, NotConverged, NotFollowed, Scene, SceneError, __version__, load_path, summarize
from .cautions import cautions
from .cluster import ClusterError
from .command import (
    BAD_INPUT,
    INTERRUPTED,
    NOT_CONVERGED,
    InputError,
    add_command,
    add_file,
    check_writable,
    progress,
    scene_of,
    settings,
    write,
)
from .derivatives import add_fit, add_sensitivities, add_spread
from .files import write_csv, write_json, write_npz
from .mapping import add_map
from .presets import PresetError, preset, presets
from .reports import add_accuracy, add_stability
from .run.load_steps import load_steps_of
from .run.shortcuts import account
from .threads import one_thread

# Small, and yet they stick, slip and stick again: they compile every kernel before the clock starts. Two, because
# arrays of a part of the surface and of all of it differ in layout, and Numba compiles for each.
WARM_UP = [
    Scene(nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=10.0),
    Scene(nodes=16, width=40.0, delta_bar=0.1, du_z=0.5, du_x=0.5, u_x_max=8.0),
]
NO_FIELD = np.empty((2, 0))


class Parser(argparse.ArgumentParser):
    """Reports an error in one line, without the usage text."""

    def error(self, message):
        self.exit(BAD_INPUT, f"{self.prog}: {message}\n")


def main(argv=None):
    """Runs the subcommand named in `argv` and returns the exit code."""
    try:
        parser = Parser(prog="python -m solver", description="Adhesive contacts under mixed-mode loading.")
        parser.add_argument("--version", action="version", version=__version__)
        commands = parser.add_subparsers(required=True, metavar="COMMAND")
        for add in (add_run, add_accuracy, add_stability, add_map, add_sensitivities, add_fit, add_spread):
            add(commands)
        arguments = parser.parse_args(argv)
        check_writable(arguments)
        with one_thread():
            return arguments.command(arguments)
    except (ClusterError, InputError, PresetError, SceneError) as error:
        print(error, file=sys.stderr)
        return BAD_INPUT
    except NotConverged as error:
        print(error, file=sys.stderr)
        return NOT_CONVERGED
    except NotFollowed as error:
        print(f"{error}; derivatives are had of runs that are followed: change a parameter", file=sys.stderr)
        return NOT_CONVERGED
    except KeyboardInterrupt:
        print("Interrupted; run again to finish", file=sys.stderr)
        return INTERRUPTED


def add_run(commands):
    """Adds `run` to the subcommands."""
    text = "Computes one experiment along its path, approach and then shear, and prints a summary."
    parser = add_command(commands, "run", run, "compute one experiment", text, "\n\n" + preset_table())
    parser.add_argument("--preset", metavar="NAME", help="start from a named experiment, listed below")
    parser.add_argument("--method", choices=METHODS, default="fast", help="default: fast; gfmd is the reference")
    add_file(parser, "csv", "the curves, a row per increment after the approach")
    add_file(parser, "npz", "the curves and the fields of these increments")
    add_file(parser, "json", "scene, version, method and summary")


def preset_table():
    """Every preset with its title, as text."""
    lines = [f"  {name:<11} {known.label}" for name, known in presets().items()]
    return "\n".join(["presets:", *lines])


def run(arguments):
    """Computes the experiment, writes the files asked for, prints a summary; returns the exit code."""
    named = {} if arguments.preset is None else preset(arguments.preset).differences
    scene = scene_of({name: str(value) for name, value in named.items()} | settings(arguments.set))
    for small in WARM_UP:
        with suppress(NotConverged):
            deque(load_path(small, method=arguments.method), maxlen=0)
    for sentence in cautions(scene):
        print(f"Caution: {sentence}", file=sys.stderr, flush=True)
    start = perf_counter()
    frames, failure, code = compute(scene, arguments.method, fields_too=arguments.npz is not None)
    seconds = perf_counter() - start
    report = report_of(scene, frames, arguments.method, seconds, failure)
    for sentence in sorted({*cautions(scene, safe_damping=report["safe_damping"])} - {*cautions(scene)}):
        print(f"Caution: {sentence}", file=sys.stderr, flush=True)
    after = [frame for frame in frames if frame.stage != "approach"]
    for note in scene.measured.notes if scene.measured else ():
        print(f"profile: {note}")
    print(described(report, len(frames)))
    write(arguments.csv, write_csv, after)
    write(arguments.npz, write_npz, scene, after)
    write(arguments.json, write_json, report)
    if failure is not None:
        print(failure, file=sys.stderr)
    return code


def report_of(scene, frames, method, seconds, failure):
    """What --json writes beside the version: scene, method and summary."""
    report = {"method": method, "scene": asdict(scene)}
    left_out = account(frames) if method == "fast" else {}
    return report | summarize(scene, frames) | {"seconds": seconds, "failure": failure, "left_out": left_out}


def compute(scene, method, fields_too):
    """(frames, failure, exit code) of the whole load path, frames up to the failure; u and T only if asked for."""
    frames = []
    try:
        with progress(sum(step.increments + 1 for step in load_steps_of(scene)), " increments") as bar:
            for frame in load_path(scene, method=method):
                if frames and not fields_too:  # a curve needs no fields; the last ones stay, for `account`
                    frames[-1] = replace(frames[-1], u=NO_FIELD, T=NO_FIELD)
                frames.append(frame)
                bar.update()
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


def described(report, increments):
    """The summary in a few lines for people."""

    def shown(name, unit=""):
        value = report.get(name)
        return f"{name} = " + ("none" if value is None or value != value else f"{value:.6g}{unit}")

    slips = report.get("slips", 0)
    first = "the contact sticks"
    if report.get("U_s") is not None:
        first = f"first at {shown('U_s', ' nm')}: {shown('F_s')}, {shown('A_s')}"
    elif "L_min" in report:
        first = f"pull-off at {shown('L_min')}"
    state = "converged" if report["converged"] else "NOT converged"
    return (
        f"{report['method']}: {increments} increments {state}, {report.get('evaluations', 0)} evaluations,"
        f" {report['seconds']:.3g} s\n{shown('A_0')}\n{slips} slips; {first}"
    )
