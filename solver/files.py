"""The files of a run: curves as CSV, curves and fields as NPZ, everything else as strict JSON."""

import json
import subprocess
from collections.abc import Sequence
from dataclasses import asdict
from functools import cache
from math import inf, isfinite
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import __version__
from .cautions import cautions_of
from .continuation.state import Outcome
from .run.frame import Frame
from .run.summary import curves_of, fields_of, left_out, summarize
from .scene import Scene, refuse_other

if TYPE_CHECKING:
    import pandas as pd

SCHEMA = 2  # of JSON and NPZ files: raised when a field changes its name or meaning


def write_table(file: str | PathLike, table: "pd.DataFrame") -> None:
    """Writes a table as CSV, numbers in full precision."""
    table.to_csv(file, index=False, lineterminator="\n")


def write_npz(
    file: str | PathLike,
    scene: Scene,
    frames: Sequence[Frame],
    method: str = "fast",
    outcome: Outcome = Outcome.FINISHED,
) -> None:
    """Writes the columns of `curves_of`, by names without units, and the arrays of `fields_of`, after the approach.

    `report` is JSON text: schema, version, commit, scene, method and outcome. Raises SceneError for frames of another
    scene.
    """
    _refuse_others(scene, frames)
    after = [frame for frame in frames if frame.stage != "approach"]
    curves = {name.split(" ")[0]: np.array(values) for name, values in curves_of(after).items()}
    report = {"method": method, "scene": asdict(scene), "outcome": str(outcome)}
    arrays: dict[str, Any] = fields_of(after) | curves
    with open(file, "wb") as out:  # NumPy would append .npz to a name
        np.savez_compressed(out, **arrays, report=json.dumps(plain(origin() | report)))


def _refuse_others(scene, frames):
    for frame in frames:
        refuse_other(scene, frame.scene, "run")


def origin() -> dict[str, Any]:
    """Schema, version and commit of the program that writes a file."""
    return {"schema": SCHEMA, "version": __version__, "commit": commit()}


def write_json(file: str | PathLike, report: dict[str, Any]) -> None:
    """Writes strict JSON with schema, version and commit; nan becomes null, infinity "inf", as `--set` takes it."""
    with open(file, "w", encoding="utf-8") as out:
        json.dump(plain(origin() | report), out, indent=2, allow_nan=False)
        out.write("\n")


def report_of(
    scene: Scene,
    frames: Sequence[Frame],
    method: str,
    seconds: float,
    failure: str | None,
    outcome: Outcome = Outcome.FINISHED,
) -> dict[str, Any]:
    """What --json writes beside the version: scene, method and summary; raises SceneError for another one's frames."""
    _refuse_others(scene, frames)
    report = {"method": method, "scene": asdict(scene)}
    failed = None if outcome.reached else failure  # a pull-off under a held load is the end of a path
    ended = {"seconds": seconds, "outcome": str(outcome), "failure": failed, "left_out": left_out(frames)}
    return report | summarize(frames, outcome) | {"cautions": cautions_of(scene, frames)} | ended


@cache
def commit() -> str | None:
    """The commit of the checkout that computes, with "+" where files differ from it; None outside a checkout."""
    root = Path(__file__).parents[1]
    if not (root / ".git").exists():
        return None
    command = ["git", "-C", str(root), "describe", "--always", "--dirty=+", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout.strip()
    except (OSError, subprocess.SubprocessError):  # no git, or not its repository
        return None


def plain(value: Any) -> Any:
    """A value in the types of JSON: nan becomes null, infinity "inf"."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(item) for item in value]
    if isinstance(value, bytes):  # heights of a measured profile
        return np.frombuffer(value, "<f8").tolist()
    if isinstance(value, np.generic):
        value = value.item()
    if value == inf:
        return "inf"
    return None if isinstance(value, float) and not isfinite(value) else value
