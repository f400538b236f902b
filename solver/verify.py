"""The command `verify`: repeats the run of a file, and reports what differs."""

import argparse
import json
import zipfile
from collections.abc import Sequence
from math import inf, nan
from typing import Any, NamedTuple

import numpy as np

from . import METHODS, Frame, Profile, Scene, SceneError, __version__, load_path, summarize
from .command import NOT_CONVERGED, InputError
from .files import SCHEMA, commit, plain
from .results import collected
from .run.summary import fields_of

SAME = 1e-6  # of the largest of its kind: ends of branches are located to 1e-6 nm
TOLERANCES = 100.0  # over the tolerance of the run, in delta_n or delta_t: error of F and L at the default, or less
FIRST = ("A_0", "U_s", "F_s", "A_s", "L_min", "slips")  # of a summary
NUMBERS = ("U_x", "delta", "F_bar", "L_bar", "A_bar")  # of an event
HOLDS = "allowed: a JSON or NPZ file that run --json, run --npz or the app wrote"


class Recorded(NamedTuple):
    """What a file holds: the scene, the method, what wrote it, {quantity: values}, and their kind."""

    scene: Scene
    method: str
    origin: str
    values: dict[str, np.ndarray]
    fields: bool  # whether these are arrays of curves and fields, or the numbers of a summary


class Difference(NamedTuple):
    """The largest difference of a quantity, over the largest value of its kind; inf: not of the same shape."""

    quantity: str
    recorded: float
    computed: float
    relative: float


def add_verify(commands: Any) -> None:
    """Adds `verify` to the subcommands."""
    text = "Repeats the run of a JSON or NPZ file. Exit code 0: the same; 1: something differs, which is listed."
    parser = commands.add_parser("verify", help="repeat a file's run and compare", description=text)
    parser.add_argument("file", metavar="FILE", help="a JSON or NPZ file of a run")
    parser.set_defaults(command=verify)


def verify(arguments: argparse.Namespace) -> int:
    """Computes and compares; prints the verdict; returns the exit code."""
    recorded = read(arguments.file)
    scene = recorded.scene
    frames, failure = collected(load_path(scene, method=recorded.method))
    allowed = max(SAME, TOLERANCES * scene.tolerance / min(scene.delta_n, scene.delta_t))
    computed = fields_and_curves(scene, frames) if recorded.fields else numbers_of(plain(summarize(scene, frames)))
    differences = [_difference(name, values, computed[name]) for name, values in recorded.values.items()]
    residual = max((frame.residual for frame in frames), default=nan)
    print(f"file: {recorded.origin}; here: version {__version__}, commit {commit() or 'unknown'}")
    print(f"tolerance {scene.tolerance:.3g} nm, largest residual here {residual:.3g} nm")
    if failure:
        print(f"here the run ends early: {failure}")
    off = [each for each in differences if not each.relative <= allowed]
    worst = max((each.relative for each in differences), default=0.0)
    if not off:
        print(f"same: {len(differences)} quantities agree to {allowed:.0e} of their largest; worst {worst:.1e}")
        return 0
    print(f"differs: {len(off)} of {len(differences)} quantities, by more than {allowed:.0e} of their largest")
    for each in off:
        print(f"  {each.quantity:12} file {each.recorded:.10g}, here {each.computed:.10g} ({each.relative:.1e})")
    return NOT_CONVERGED


def read(file: str) -> Recorded:
    """Reads a file. Raises InputError for anything that `run` or the app did not write."""
    try:
        if fields := zipfile.is_zipfile(file):
            with np.load(file) as held:
                report = json.loads(str(held["report"]))
                values = {name: held[name] for name in (*NUMBERS, "u", "T")}
        else:
            with open(file, encoding="utf-8") as text:
                report = json.load(text)
        if report["schema"] > SCHEMA:
            raise InputError(f"{file!r}: schema {report['schema']}; allowed: up to {SCHEMA}; use a newer version")
        origin = f"schema {report['schema']}, version {report['version']}, commit {report['commit'] or 'unknown'}"
        if report["method"] not in METHODS:
            method, allowed = report["method"], ", ".join(METHODS)
            raise InputError(f"{file!r}: method {method!r}; allowed: {allowed}; use the version that wrote the file")
        if report.get("changes"):
            how = "allowed: one scene for the whole run; use the version that wrote the file"
            raise InputError(f"{file!r}: its parameters change along the run; {how}")
        values = values if fields else numbers_of(report)
        values = {name: np.asarray(numbers, float) for name, numbers in values.items()}
        return Recorded(_scene(report), report["method"], origin, values, fields)
    except InputError:
        raise
    except OSError as error:
        raise InputError(f"{file!r}: {error.strerror}; {HOLDS}") from None
    except (AttributeError, KeyError, TypeError, ValueError, IndexError, zipfile.BadZipFile, SceneError) as error:
        raise InputError(f"{file!r}: not a run ({type(error).__name__}: {error}); {HOLDS}") from None


def _scene(report):
    """The Scene of the run."""
    given = {name: inf if value == "inf" else value for name, value in report["scene"].items()}
    if measured := given.pop("measured", None):
        given["measured"] = Profile(measured["length"], measured["heights"], tuple(measured["notes"]))
    return Scene(**given)


def numbers_of(report: dict[str, Any]) -> dict[str, list[Any]]:
    """{quantity: values} of a summary with its events."""
    events = {f"events: {name}": [event[name] for event in report["events"] if name in event] for name in NUMBERS}
    return {name: [report.get(name)] for name in FIRST} | events


def fields_and_curves(scene: Scene, frames: Sequence[Frame]) -> dict[str, Any]:
    """{quantity: array} of Frames, as an NPZ file holds them."""
    after = [frame for frame in frames if frame.stage != "approach"]
    return fields_of(scene, after) | {name: np.array([getattr(f, name) for f in after]) for name in NUMBERS}


def _difference(name, recorded, computed):
    """The Difference of an array and a list or another array; None and nan are equal to each other only."""
    a, b = recorded, np.array(computed, float)
    if a.shape != b.shape:
        return Difference(f"{name}: count", a.size, b.size, inf)
    if a.size == 0:
        return Difference(name, 0.0, 0.0, 0.0)
    if (np.isnan(a) != np.isnan(b)).any():
        k = int(np.argmax(np.isnan(a) != np.isnan(b)))
        return Difference(name, a.flat[k], b.flat[k], inf)
    off = np.nan_to_num(np.abs(a - b))
    k, largest = int(np.argmax(off)), float(np.nanmax(np.abs(a), initial=0.0))
    return Difference(name, a.flat[k], b.flat[k], float(off.flat[k]) / (largest or 1.0))
