"""Scenes as text: the one reader of numbers for the command line, the page's address and the entries of the app."""

import re
from collections.abc import Mapping
from typing import Any

from .scene import CHOICES, LIMITS, PARAMETERS, Scene, SceneError
from .surfaces import Profile

NUMBER = re.compile(r"(?P<mantissa>[+-]?(?:\d+[.,]?\d*|[.,]\d+|inf))(?P<exponent>(?:[eE][+-]?\d+)?) ?(?P<unit>.*)")
THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2},\d{3}")  # the comma of 1,234 may part thousands; that of 0,123 does not
UNITS = {  # that may follow a number of that unit, and what they are of it
    "nm": {"nm": 1.0, "µm": 1e3, "um": 1e3, "Å": 0.1, "m": 1e9},
    "GPa": {"GPa": 1.0, "MPa": 1e-3, "TPa": 1e3, "Pa": 1e-9},
    "N/m": {"N/m": 1.0, "J/m²": 1.0, "J/m2": 1.0, "mN/m": 1e-3, "mJ/m²": 1e-3, "mJ/m2": 1e-3},
    "δₙ": {"δₙ": 1.0, "delta_n": 1.0},
    "δₜ": {"δₜ": 1.0, "delta_t": 1.0},
    "δ₀": {"δ₀": 1.0, "delta_0": 1.0},
}


def number_from_text(name, text, notes=None, known=None, whole=None):
    """The number that `text` gives for parameter `name`, within its range or not; raises SceneError where it is none.

    '−0.5' with a true minus, '0,3' with a decimal comma (said in the list `notes`), '70 GPa', '2.5 µm' with a unit.
    known: a Range to name in messages, narrower than that of Scene. whole: the length in nm that the parameter is a
    part of; then a length may be given as well, '4 nm' of 10 nm for 0.4.
    """
    given = " ".join(str(text).split())  # thin spaces as well
    for other, usual in (("−", "-"), ("∞", "inf"), ("μ", "µ")):  # the last: Greek mu, and the micro sign
        given = given.replace(other, usual)
    found = NUMBER.fullmatch(given)
    known = known or LIMITS[name]
    units = _units(known, whole)
    if found and THOUSANDS.fullmatch(found["mantissa"]):
        other = given.replace(",", "")
        raise SceneError(
            name, text, f"{given.replace(',', '.')} or {other}? allowed: {known.span}", "write a decimal point"
        )
    if not found or found["unit"] not in {"", *units}:
        unit = f", alone or with its unit ({', '.join(units)})" if known.unit else ""
        raise SceneError(name, text, f"allowed: {known.span}", f"give a number in that range{unit}")
    value = float(found["mantissa"].replace(",", ".") + found["exponent"])
    if "," in given and notes is not None:
        notes.append(f"{name} = {given}: the comma was read as a decimal point, {value:g}.")
    return float(f"{value * units[found['unit']]:.12g}") if found["unit"] else value  # 0.07 TPa is 70 GPa


def _units(known, whole):
    """{unit: what it is of the Range's own} that may follow a number; whole: as of `number_from_text`."""
    lengths = {unit: nm / whole for unit, nm in UNITS["nm"].items()} if whole else {}
    return UNITS.get(known.unit, {known.unit: 1.0}) | lengths


def scene_from_text(pairs: Mapping[str, str], profile: Profile | None = None, notes: list[str] | None = None) -> Scene:
    """A Scene from {'name': 'text'}, as the command line gives it; raises SceneError.

    profile: a measured Profile; the scene then shows it, over its own length, unless `pairs` say otherwise.
    notes: a list that takes what is to be said of how a text was read.
    """
    values: dict[str, Any] = {"surface": "measured", "width": profile.length, "measured": profile} if profile else {}
    for name, text in pairs.items():
        if name not in PARAMETERS:
            raise SceneError("name", name, f"allowed: {', '.join(PARAMETERS)}", "use one of these names")
        values[name] = text if name in CHOICES else number_from_text(name, text, notes)
    return Scene(**values)


def changes(scene):
    """'name=value ...' of what differs from the default, as `--set` takes it; a measured profile as profile=FILE."""
    usual = Scene()
    values = {name: getattr(scene, name) for name in PARAMETERS if getattr(scene, name) != getattr(usual, name)}
    if scene.measured:
        values["profile"] = "FILE"
    return " ".join(f"{name}={value}" for name, value in values.items())
