"""The command `verify`: repeats the run of a file, and reports what differs."""

import argparse
import json
import zipfile
from math import inf
from typing import Any

import numpy as np

from .. import METHODS, NotConverged, Profile, Scene, SceneError, summarize
from ..continuation.state import Outcome
from ..files import SCHEMA, origin, plain
from ..run.summary import curves_of, fields_of
from ..schema import RETIRED
from .options import NOT_CONVERGED, add_limit
from .pairs import InputError
from .run import compute

SUMMARY = "A_0", "U_s", "F_s", "L_s", "A_s", "L_min", "L_off", "slips"  # of a summary
NUMBERS = "U_x", "delta", "F", "L", "A"  # of an event or a frame
NEEDED = "allowed: a JSON or NPZ file that run --json, run --npz or the app wrote"
# where such a run ends does not depend on its scene alone
CUT_SHORT = Outcome.OUT_OF_TIME, Outcome.OUT_OF_MEMORY


def add_verify(commands: Any) -> None:
    """Adds `verify` to the subcommands."""
    text = "Repeats the run of a JSON or NPZ file. Exit code 0: the same; 1: something differs, which is listed."
    parser = commands.add_parser("verify", help="repeat a file's run and compare", description=text)
    parser.add_argument("file", metavar="FILE", help="a JSON or NPZ file of a run")
    add_limit(parser)
    parser.set_defaults(command=verify)


def verify(arguments: argparse.Namespace) -> int:
    """Computes and compares; prints the verdict; returns the exit code."""
    try:
        report, scene, recorded = _read(arguments.file)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{arguments.file!r}: {error.strerror}; {NEEDED}") from None
    except (AttributeError, KeyError, TypeError, ValueError, IndexError, zipfile.BadZipFile, SceneError) as error:
        raise InputError(f"{arguments.file!r}: not a run ({type(error).__name__}: {error}); {NEEDED}") from None
    result = compute(scene, report["method"], arguments.limit)
    if result.outcome is Outcome.INTERRUPTED:
        raise KeyboardInterrupt
    if result.outcome in CUT_SHORT:
        raise NotConverged(f"not compared: {result.failure}")
    frames, failure = result.frames, result.failure
    after = [frame for frame in frames if frame.stage != "approach"]
    arrays = fields_of(after) | {name.split(" ")[0]: values for name, values in curves_of(after).items()}
    computed = arrays if "T" in recorded else _numbers(plain(summarize(frames)))
    # ends of branches are located to 1e-6 nm; the error of F and L is at most 100 tolerances. Small lengths would allow
    # any difference: beyond 1 % of the largest value it is one
    allowed = min(1e-2, max(1e-6, 100.0 * scene.tolerance / min(scene.delta_n, scene.delta_t)))
    off = {name: _difference(values, np.array(computed[name], float)) for name, values in recorded.items()}
    for where, of in (("file", report), ("here", origin())):
        print(f"{where}: schema {of['schema']}, version {of['version']}, commit {of['commit'] or 'unknown'}")
    residual = max((frame.residual for frame in frames), default=inf)
    ended = f"; here the run ends early: {failure}" if failure else ""
    print(f"tolerance {scene.tolerance:.3g} nm, largest residual here {residual:.3g} nm{ended}")
    wrong = [f"  {name:16} {what}" for name, (error, what) in off.items() if not error <= allowed]
    if wrong:
        print(f"differs: {len(wrong)} of {len(off)} quantities, by more than {allowed:.0e} of their largest")
        print("\n".join(wrong))
        return NOT_CONVERGED
    worst = max(error for error, _ in off.values())
    print(f"same: {len(off)} quantities agree to {allowed:.0e} of their largest; worst {worst:.1e}")
    return 0


def _read(file):
    """(report, Scene, {quantity: array}) of a file; raises one of many errors for what is none."""
    arrays: dict[str, Any] = {}
    if zipfile.is_zipfile(file):
        with np.load(file) as held:
            report, arrays = json.loads(str(held["report"])), dict(held)
    else:
        with open(file, encoding="utf-8") as text:
            report = json.load(text)
    for name, allowed in (("schema", (SCHEMA,)), ("method", METHODS)):
        if report[name] not in allowed:
            remedy = f"allowed: {', '.join(map(str, allowed))}; use the version that wrote it, or write it again"
            raise InputError(f"{file!r}: {name} {report[name]}; {remedy}")
    if (outcome := report.get("outcome")) in (*CUT_SHORT, Outcome.INTERRUPTED):
        remedy = "allowed: a run that was not cut short; run it again, with a larger --limit"
        raise InputError(f"{file!r}: outcome {outcome}; {remedy}")
    given = {name: inf if value == "inf" else value for name, value in report["scene"].items()}
    for name in RETIRED.keys() & given.keys():
        print(f"{name} = {given.pop(name)}: {RETIRED[name]}")
    if measured := given.pop("measured", None):
        given["measured"] = Profile(measured["length"], measured["heights"], tuple(measured["notes"]))
    written = [name for name in SUMMARY if name in report]  # a file of an earlier version has fewer
    recorded = {name: arrays[name] for name in (*NUMBERS, "u", "T")} if arrays else _numbers(report, written)
    return report, Scene(**given), {name: np.asarray(values, float) for name, values in recorded.items()}


def _numbers(report, names=SUMMARY):
    """{quantity: values} of a summary with its events."""
    events = {f"events: {name}": [event[name] for event in report["events"] if name in event] for name in NUMBERS}
    return {name: [report.get(name)] for name in names} | events


def _difference(a, b):
    """(largest difference of two arrays over the largest value of the first, what differs); nan equals nan only."""
    if a.shape != b.shape or not a.size:
        return (inf, f"file {a.size} values, here {b.size}") if a.shape != b.shape else (0.0, "")
    off = np.where(np.isnan(a) & np.isnan(b), 0.0, np.nan_to_num(np.abs(a - b), nan=inf))
    k = int(np.argmax(off))
    error = float(off.flat[k]) / (float(np.nanmax(np.abs(a), initial=0.0)) or 1.0)
    return error, f"file {a.flat[k]:.10g}, here {b.flat[k]:.10g} ({error:.1e})"
