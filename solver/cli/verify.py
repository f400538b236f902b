"""The command `verify`: repeats the run of a file, and reports what differs."""

import argparse
import json
import zipfile
from math import inf
from typing import Any

import numpy as np

from .. import METHODS, Profile, Scene, SceneError, load_path, summarize
from ..files import SCHEMA, origin, plain
from ..results import collected
from ..run.summary import curves_of, fields_of
from ..schema import RETIRED
from .options import NOT_CONVERGED, InputError

SAME = 1e-6  # of the largest of its kind: ends of branches are located to 1e-6 nm
TOLERANCES = 100.0  # over the tolerance of the run, in delta_n or delta_t: error of F and L at the default, or less
FIRST = ("A_0", "U_s", "F_s", "L_s", "A_s", "L_min", "slips")  # of a summary
NUMBERS = ("U_x", "delta", "F", "L", "A")  # of an event or a frame
HOLDS = "allowed: a JSON or NPZ file that run --json, run --npz or the app wrote"


def add_verify(commands: Any) -> None:
    """Adds `verify` to the subcommands."""
    text = "Repeats the run of a JSON or NPZ file. Exit code 0: the same; 1: something differs, which is listed."
    parser = commands.add_parser("verify", help="repeat a file's run and compare", description=text)
    parser.add_argument("file", metavar="FILE", help="a JSON or NPZ file of a run")
    parser.set_defaults(command=verify)


def verify(arguments: argparse.Namespace) -> int:
    """Computes and compares; prints the verdict; returns the exit code."""
    report, scene, recorded = read(arguments.file)
    frames, failure = collected(load_path(scene, method=report["method"]))
    after = [frame for frame in frames if frame.stage != "approach"]
    arrays = fields_of(after) | {name.split(" ")[0]: values for name, values in curves_of(after).items()}
    computed = arrays if "T" in recorded else numbers_of(plain(summarize(frames)))
    compared = {name: _compared(values, np.array(computed[name], float)) for name, values in recorded.items()}
    allowed = max(SAME, TOLERANCES * scene.tolerance / min(scene.delta_n, scene.delta_t))
    for where, of in (("file", report), ("here", origin())):
        print(f"{where}: schema {of['schema']}, version {of['version']}, commit {of['commit'] or 'unknown'}")
    residual = max((frame.residual for frame in frames), default=inf)
    print(f"tolerance {scene.tolerance:.3g} nm, largest residual here {residual:.3g} nm")
    if failure:
        print(f"here the run ends early: {failure}")
    wrong = [f"  {name:16} {what}" for name, (error, what) in compared.items() if not error <= allowed]
    if wrong:
        print(f"differs: {len(wrong)} of {len(compared)} quantities, by more than {allowed:.0e} of their largest")
        print("\n".join(wrong))
        return NOT_CONVERGED
    worst = max(error for error, _ in compared.values())
    print(f"same: {len(compared)} quantities agree to {allowed:.0e} of their largest; worst {worst:.1e}")
    return 0


def read(file: str) -> tuple[dict[str, Any], Scene, dict[str, np.ndarray]]:
    """(report, Scene, {quantity: values}) of a file; raises InputError for what neither `run` nor the app wrote."""
    try:
        if zipfile.is_zipfile(file):
            with np.load(file) as held:
                report = json.loads(str(held["report"]))
                values = {
                    name: held[name] for name in (*NUMBERS, "u", "T") if name in held or report["schema"] == SCHEMA
                }
        else:
            with open(file, encoding="utf-8") as text:
                report = json.load(text)
            values = None
        if report["schema"] != SCHEMA:
            remedy = "use the version that wrote it, or write it again"
            raise InputError(f"{file!r}: schema {report['schema']}; allowed: {SCHEMA}; {remedy}")
        if report["method"] not in METHODS:
            allowed = f"allowed: {', '.join(METHODS)}; use the version that wrote the file"
            raise InputError(f"{file!r}: method {report['method']!r}; {allowed}")
        values = numbers_of(report) if values is None else {name: values[name] for name in (*NUMBERS, "u", "T")}
        return report, _scene(report["scene"]), {name: np.asarray(each, float) for name, each in values.items()}
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{file!r}: {error.strerror}; {HOLDS}") from None
    except (AttributeError, KeyError, TypeError, ValueError, IndexError, zipfile.BadZipFile, SceneError) as error:
        raise InputError(f"{file!r}: not a run ({type(error).__name__}: {error}); {HOLDS}") from None


def _scene(values):
    """The Scene of its fields in JSON."""
    given = {name: inf if value == "inf" else value for name, value in values.items()}
    for name in RETIRED.keys() & given.keys():
        print(f"{name} = {given.pop(name)}: {RETIRED[name]}")
    if measured := given.pop("measured", None):
        given["measured"] = Profile(measured["length"], measured["heights"], tuple(measured["notes"]))
    return Scene(**given)


def numbers_of(report: dict[str, Any]) -> dict[str, list[Any]]:
    """{quantity: values} of a summary with its events."""
    events = {f"events: {name}": [event[name] for event in report["events"] if name in event] for name in NUMBERS}
    return {name: [report.get(name)] for name in FIRST} | events


def _compared(a, b):
    """(largest difference of two arrays over the largest value of the first, what differs); nan equals nan only."""
    if a.shape != b.shape:
        return inf, f"file {a.size} values, here {b.size}"
    if not a.size:
        return 0.0, ""
    off = np.where(np.isnan(a) & np.isnan(b), 0.0, np.nan_to_num(np.abs(a - b), nan=inf))
    k, largest = int(np.argmax(off)), float(np.nanmax(np.abs(a), initial=0.0))
    error = float(off.flat[k]) / (largest or 1.0)
    return error, f"file {a.flat[k]:.10g}, here {b.flat[k]:.10g} ({error:.1e})"
