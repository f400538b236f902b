"""Scenes as text: the one reader of numbers for the command line, the page's address and the entries of the app."""

import re
import shlex
from collections.abc import Mapping
from typing import Any
from unicodedata import normalize

from .scene import LIMITS, PARAMETERS, Scene, SceneError
from .schema import ASCII, Range, unknown_name
from .surfaces import Profile

NUMBER = re.compile(r"(?P<mantissa>[+-]?(?:\d+[.,]?\d*|[.,]\d+|inf))(?P<exponent>(?:[eE][+-]?\d+)?) ?(?P<unit>.*)")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")  # 1,234 may mean 1234 or 1.234; 0,123 is unambiguous
UNITS = {  # {unit of a parameter: {unit that its text may give: factor}}
    "nm": {"nm": 1.0, "µm": 1e3, "um": 1e3, "Å": 0.1, "mm": 1e6, "m": 1e9},
    "GPa": {"GPa": 1.0, "MPa": 1e-3, "TPa": 1e3, "Pa": 1e-9},
    "N/m": {"N/m": 1.0, "mN/mm": 1.0, "N/mm": 1e3, "mN/m": 1e-3}
    | {"J/m²": 1.0, "J/m2": 1.0, "mJ/m²": 1e-3, "mJ/m2": 1e-3},
    "MPa/nm": {"MPa/nm": 1.0, "GPa/nm": 1e3},
    "δₙ": {"δₙ": 1.0, "delta_n": 1.0},
    "δₜ": {"δₜ": 1.0, "delta_t": 1.0},
    "δ₀": {"δ₀": 1.0, "delta_0": 1.0},
}
SAME = str.maketrans({"−": "-", "∞": "inf", "μ": "µ"})  # the last: Greek mu, and the micro sign


def number_from_text(
    name: str, text: str, notes: list[str] | None = None, limits: Range | None = None, whole: float | None = None
) -> float:
    """The number that `text` gives for parameter `name`; it may lie outside the range.

    Accepts a true minus ('−0.5'), a decimal comma ('0,3', reported in the list `notes`) and a unit ('2.5 µm').
    limits: a Range to name in messages, narrower than that of Scene. whole: the length in nm that the parameter is a
    fraction of; the text may then give a length, '4 nm' of 10 nm for 0.4. Raises SceneError.
    """
    given = normalize("NFC", " ".join(str(text).split())).translate(SAME)  # split: at thin spaces; NFC: one sign Å
    limits = limits or LIMITS[name]
    match = NUMBER.fullmatch(given)
    units = UNITS.get(limits.unit, {limits.unit: 1.0})
    if whole:
        units = units | {unit: nm / whole for unit, nm in UNITS["nm"].items()}
    if match and THOUSANDS.fullmatch(match["mantissa"]):
        allowed = f"{given.replace(',', '.')} or {given.replace(',', '')}? allowed: {limits.span}"
        raise SceneError(name, text, allowed, "write a decimal point")
    if not match or match["unit"] not in {"", *units}:
        unit = f", alone or with its unit ({', '.join(units)})" if limits.unit else ""
        raise SceneError(name, text, f"allowed: {limits.span}", f"give a number in that range{unit}")
    value = float(match["mantissa"].replace(",", ".") + match["exponent"])
    if "," in given and notes is not None:
        notes.append(f"{name} = {given}: the comma was read as a decimal point, {value:g}.")
    # 0.07 TPa is 70 GPa, not 70.00000000000001
    return float(f"{value * units[match['unit']]:.{12}g}") if match["unit"] else value


def scene_from_text(pairs: Mapping[str, str], profile: Profile | None = None, notes: list[str] | None = None) -> Scene:
    """Reads a scene from texts, as the command line and the address of the page have them.

    Parameters: pairs: {'name': 'text'}; profile: a measured Profile, whose surface and length are used unless `pairs`
    name others; notes: a list that collects how ambiguous texts were read.
    Returns a Scene.
    Raises SceneError.

    Example: `scene_from_text({"E": "70 GPa", "delta_bar": "0.2"})`
    """
    values: dict[str, Any] = {"surface": "measured", "width": profile.length, "measured": profile} if profile else {}
    for name, text in pairs.items():
        if name not in PARAMETERS:
            raise unknown_name(name, PARAMETERS)
        values[name] = number_from_text(name, text, notes) if name in LIMITS else text
    if values.get("path") == "points":  # they set it; the caller prints that
        values.pop("delta_bar", None)
    return Scene(**values)


def in_ascii(text: str) -> str:
    """The text with ASCII names for its letters, as `delta_n`; others are escaped."""
    return text.translate(ASCII).encode("ascii", "backslashreplace").decode("ascii")


def named(error: UnicodeError) -> tuple[str, int]:
    """A handler for `codecs.register_error`: what an encoding cannot show is written as by `in_ascii`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return in_ascii(error.object[error.start : error.end]), error.end


def counted(count: int, noun: str) -> str:
    """The count with its noun in singular or plural: 1 slip, 2 slips."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def changes(scene: Scene) -> str:
    """'name=value ...' of what differs from the default, quoted for a shell; a measured profile as profile=FILE."""
    values = scene.differences() | ({"profile": "FILE"} if scene.measured else {})
    return shlex.join(f"{name}={value}" for name, value in values.items())
