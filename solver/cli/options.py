"""What the commands share: their options, the scene, progress, the files they write, and exit codes."""

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..presets import preset
from ..run.loadpath import SOFT_LIMIT
from ..scene import SET_BY_POINTS, Scene, SceneError
from ..text import number_from_text, scene_from_text
from .measured import add_reading, profile_of, reading, refuse_unused
from .pairs import InputError, settings

NOT_CONVERGED, BAD_INPUT, INTERRUPTED = 1, 2, 130  # exit codes; 2 as argparse, 130 as shells report Ctrl-C
SCRIPT = "mixed-mode-contact"  # of pyproject.toml


def program() -> str:
    """The name by which the command line was called."""
    return SCRIPT if Path(sys.argv[0]).stem == SCRIPT else "python -m solver"


def add_command(commands: Any, name: str, run: Callable, summary: str, text: str, epilog: str = "") -> Any:
    """Adds the subcommand run(scene, arguments) -> exit code, with options of the Scene, and returns its parser."""
    lists = f"`{program()} parameters` and `{program()} presets` list what --set and --preset accept."
    parser = commands.add_parser(name, help=summary, description=text, epilog=f"{epilog} {lists}")
    setting = {"nargs": "+", "action": "extend", "default": [], "metavar": "NAME=VALUE"}
    parser.add_argument("--set", **setting, help="parameters of the scene, in place of their defaults")
    parser.add_argument("--preset", metavar="NAME", help="start from this named experiment; --set changes it")
    add_reading(parser)

    def command(arguments):
        _refuse_same_files(arguments)
        return run(scene_of(arguments.set, arguments.preset, reading(arguments)), arguments)

    parser.set_defaults(command=command)
    return parser


def _refuse_same_files(arguments):
    """Raises InputError where an output is another one, or the file that is read."""
    named: dict[str, str] = {}
    for option in ("measured", "csv", "npz", "json"):
        file = getattr(arguments, option, None)
        if file and (other := named.setdefault(os.path.realpath(file), option)) != option:
            raise InputError(f"--{option} {file}: the file of --{other}; name another one")


def scene_of(pairs: Sequence[str], named: str | None = None, how: Mapping[str, Any] | None = None) -> Scene:
    """The Scene of NAME=VALUE arguments, over a preset if one is named; profile=FILE reads a measured surface.

    how: as of `measured.reading`. Prints how ambiguous numbers were read, and which are not used. Raises SceneError or
    InputError.
    """
    start = preset(named).scene.differences() if named else {}
    given = settings(pairs)
    texts = {name: str(value) for name, value in start.items()} | given
    file, profile, how = texts.pop("profile", None), None, how or {}
    refuse_unused(how, file is not None)
    notes: list[str] = []
    if file is not None:
        if given.get("surface", "measured") != "measured":
            raise SceneError(
                "surface", given["surface"], "allowed with profile=FILE: measured", "leave one of them out"
            )
        texts["surface"] = "measured"  # in place of the preset's
        width = number_from_text("width", texts["width"]) if "width" in texts else None
        profile = profile_of(file, width, how)
    scene = scene_from_text(texts, profile, notes)
    unused = [name for name in SET_BY_POINTS if scene.legs and name in given]
    for note in [*notes, *(f"{name} is not used with path=points: the points set it." for name in unused)]:
        print(note)
    return scene


def add_file(parser: argparse.ArgumentParser, option: str, content: str, **options: Any) -> None:
    """Adds --option FILE."""
    parser.add_argument(f"--{option}", type=_writable, metavar="FILE", help=f"write {content}", **options)


def add_limit(parser: argparse.ArgumentParser) -> None:
    """Adds --limit S."""
    text = f"processor time of a run, default none, but {SOFT_LIMIT:g} s for a soft layer by fast"
    parser.add_argument("--limit", type=float, metavar="S", help=text)


def count(text: str) -> int:
    """A type for argparse: a whole number from 1 on."""
    try:
        value = int(text)
    except ValueError:
        value = 0
    if value < 1:
        raise argparse.ArgumentTypeError(f"{text}: allowed: 1 or more, whole numbers")
    return value


def _writable(file):
    """A type for argparse: the name of a file that can be written; leaves an existing file unchanged."""
    new = not os.path.lexists(file)
    try:
        with open(file, "ab"):
            pass
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or error
        message = f"{file!r}: {reason}; allowed: a writable file in an existing directory"
        raise argparse.ArgumentTypeError(message) from None
    if new:
        os.remove(file)
    return file


def caution(sentences: Iterable[str]) -> None:
    """Prints cautions on standard error."""
    for sentence in sentences:
        print(f"Caution: {sentence}", file=sys.stderr, flush=True)


def write(file: str | None, writer: Callable, *content: Any) -> None:
    """Calls writer(file, *content) if a file is named, and reports it; raises InputError where that fails."""
    if file is None:
        return
    try:
        writer(file, *content)
    except OSError as error:
        raise InputError(f"Writing the results failed: {error}; name a file on a disk with free space") from None
    print(f"wrote {file}", file=sys.stderr)


def progress(total: int, unit: str) -> Any:
    """A progress bar on standard error, shown on a terminal only and wiped at the end."""
    from tqdm import tqdm  # only commands need it

    return tqdm(total=total, unit=unit, leave=False, disable=None)
