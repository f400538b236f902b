"""Options that say how measured files are read: arguments of `read_profile` and `read_measurement`."""

import argparse
import re
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..scene import Scene
from ..surfaces import DataError, Profile
from .pairs import InputError, settings

PAIRS = {"columns": "NAME=COLUMN", "units": "NAME=UNIT", "sign": "NAME=SIGN"}
IN_PYTHON = {  # how a refusal calls an argument: the option
    r"\b(units|columns)\['(\w+)'\]": r"--\1 \2",
    r'\bunits=\{"(\w+)": "([^"]*)"\}': r"--units \1='\2'",
    r"\bunit='([^']*)'": r"--units '\1'",
}
OF_PROFILES, OF_CURVES, SHARED = ("line", "cut_off"), ("kind", "sign", "deflection", "speed"), ("part", "channel")
FILES = "profile=FILE", "--measured FILE"
USED_WITH = dict.fromkeys(OF_PROFILES, FILES[:1]) | dict.fromkeys(OF_CURVES, FILES[1:])  # other options with both


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Adds the options of every file that is read, with profile=FILE or --measured FILE."""
    columns = "names or numbers of columns, x=... z=... of a profile, U_x=... F=... of a curve; none for none"
    parser.add_argument("--columns", nargs="+", metavar="NAME=COLUMN", help=columns)
    parser.add_argument("--units", nargs="+", metavar="NAME=UNIT", help="their units; UNIT alone for all of a profile")
    part = "only this part, nm: of the curve with --measured, else of the profile"
    parser.add_argument("--part", nargs=2, type=float, metavar=("FROM", "TO"), help=part)
    parser.add_argument("--channel", help="name or number of one of several channels or tables of that file")
    parser.add_argument("--line", metavar="'row N'", help="row or column of a map of heights")
    parser.add_argument("--cut-off", type=float, metavar="NM", help="wavelength below which a profile is smoothed")


def add_curve(parser: argparse.ArgumentParser) -> None:
    """Adds --measured FILE, and the options of curves alone."""
    parser.add_argument("--measured", metavar="FILE", help="compare with this measured curve")
    parser.add_argument("--kind", help="friction, loop, load or area")
    parser.add_argument("--sign", nargs="+", metavar="NAME=SIGN", help="L=-1 turns the sign of a column")
    parser.add_argument("--deflection", type=float, metavar="N/m", help="stiffness of a lever, taken off delta")
    parser.add_argument("--speed", type=float, metavar="nm/s", help="of friction over time")


def refuse_unused(arguments: Mapping[str, Any], profile: bool) -> None:
    """Raises InputError for an option of a kind of file that is not read; profile: whether a profile is."""
    files = {file for file, read in zip(FILES, (profile, "measured" in arguments), strict=True) if read}
    for name in arguments:
        if files.isdisjoint(wanted := USED_WITH.get(name, FILES)):
            option, kinds = name.replace("_", "-"), " or ".join(wanted)
            raise InputError(f"--{option}: used with {kinds}; name a file, or leave it out")


def profile_of(file: str, width: float | None, arguments: Mapping[str, Any]) -> Profile:
    """The Profile in a file, read as the arguments say; raises InputError in words of the command line."""
    from ..measured.profile import read_profile
    from ..measured.roles import ROLES  # only measured files need it

    beside = "measured" in arguments
    given = _given(arguments, {*OF_CURVES, *(SHARED if beside else ())}, ROLES if beside else ())
    if alone := given.get("units", {}).pop("", None):
        given["unit"] = alone
    try:
        return read_profile(Path(file), width, **given)
    except DataError as error:
        raise InputError(f"profile = {file!r}: {_in_words(error)}") from None


def curve_of(scene: Scene, arguments: Mapping[str, Any]) -> Any:
    """The Measurement or Recording of --measured, or None without; raises InputError in words of the command line."""
    if "measured" not in arguments:
        return None
    from ..measured.curves import read_measurement

    given = _given(arguments, OF_PROFILES, ("x", "z") if scene.measured else ())
    try:
        return read_measurement(scene, Path(arguments["measured"]), **given)
    except DataError as error:
        raise InputError(f"--measured {arguments['measured']}: {_in_words(error)}") from None


def compared(curve: Any, result: Any) -> str:
    """How far a curve is from a Result; raises InputError in words of the command line."""
    try:
        return "\n".join(["measured: " + " ".join(curve.notes)] * bool(curve.notes) + [repr(curve.residuals(result))])
    except ValueError as error:
        raise InputError(f"--measured: {error}".replace("part=(from, to)", "--part FROM TO")) from None


def reading(arguments: argparse.Namespace) -> dict[str, Any]:
    """The options of this module that are given, by name; raises InputError."""
    names = ("measured", "part", "channel", "line", "cut_off", "kind", "deflection", "speed")
    found = {name: value for name in names if (value := getattr(arguments, name, None)) is not None}
    for name, form in PAIRS.items():
        texts = getattr(arguments, name, None) or []
        if name == "units":  # one alone is that of x and z
            texts = [text if "=" in text else f"={text}" for text in texts]
        found |= {name: settings(texts, f"--{name}", form, "")} if texts else {}
    if "columns" in found:
        found["columns"] = {role: None if text == "none" else text for role, text in found["columns"].items()}
    if "sign" in found:
        found["sign"] = {name: _number(text) for name, text in found["sign"].items()}
    return found


def _number(text):
    try:
        return float(text)
    except ValueError:
        raise InputError(f"--sign {text}: allowed: 1 or -1; give NAME=1 or NAME=-1") from None


def _given(arguments, others, roles):
    """The arguments but those of other files: some by name, and columns and units of other roles."""
    given = {name: value for name, value in arguments.items() if name not in ("measured", *others)}
    for name in PAIRS.keys() & given.keys():
        given[name] = {role: each for role, each in given[name].items() if role not in roles}
    return given | ({"part": tuple(given["part"])} if "part" in given else {})


def _in_words(error):
    """A DataError with the options that read the file, in place of a call."""
    words = []
    for name, value in error.call.items():
        if name == "unit":
            name = "units"
        if name in ("width", "periodic"):
            continue
        pairs = [f"{key}={_shown(each)}" for key, each in value.items()] if isinstance(value, dict) else None
        values = pairs or ([_shown(each) for each in value] if isinstance(value, tuple) else [_shown(value)])
        words.append(" ".join([f"--{name.replace('_', '-')}", *map(shlex.quote, values)]))
    brief = error.brief
    for python, option in IN_PYTHON.items():
        brief = re.sub(python, option, brief)
    return f"{brief}; add {' '.join(words)}" if words else brief


def _shown(value):
    return {...: "...", None: "none"}.get(value, f"{value:g}" if isinstance(value, float) else str(value))
