"""Units of lengths, forces and times, as headings name them; nothing is read from prose."""

import math
import re
from collections.abc import Iterable
from unicodedata import normalize

from ..surfaces import DataError
from ..text import UNITS

LENGTH, FORCE = ("nm",), ("N/m", "N", "F_s")  # units in which a length, or a force, is read
NM = {  # nm: words of a unit, in small letters
    1.0: ("nm", "nanometer", "nanometre"),
    1e3: ("um", "µm", "âµm", "micron", "micrometer", "micrometre"),  # the third: UTF-8 read as Latin-1
    1e6: ("mm", "millimeter", "millimetre"),
    1e7: ("cm", "centimeter", "centimetre"),
    1e9: ("m", "meter", "metre"),
    0.1: ("å", "a", "angstrom", "angström", "ångström", "ångstrom"),
    25.4e6: ("in", "inch", "inches"),
}
SIZES = {  # {the unit in which it is read: {unit: how much it is}}
    "nm": {plural: nm for nm, words in NM.items() for word in words for plural in (word, word + "s" * (len(word) > 2))},
    "N/m": UNITS["N/m"],
    "N": {"kN": 1e3, "N": 1.0, "mN": 1e-3, "µN": 1e-6, "uN": 1e-6, "nN": 1e-9, "pN": 1e-12}
    | dict.fromkeys(("g", "gf", "gram", "grams"), 9.80665e-3)
    | {"kgf": 9.80665, "kg": 9.80665, "lbf": 4.4482216152605, "lb": 4.4482216152605},
    "s": {"s": 1.0, "sec": 1.0, "seconds": 1.0, "second": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0},
    "F_s": {"F_s": 1.0},
    "A_0": {"A_0": 1.0},
}
READ = tuple(SIZES)
READ_IN = {unit: name for name, units in SIZES.items() for unit in units}
OTHERS = ("V", "mV", "volt", "volts", "ft", "pm", "px", "pixel", "pixels", "deg", "%", "Nm", "Pa", "kPa", "MPa")
USUAL = {  # the first to choose from, of each of these
    "nm": ("nm", "um", "mm", "cm", "m", "Å", "in"),
    "N/m": ("N/m", "mN/mm"),
    "N": ("N", "mN", "uN", "nN", "pN", "g", "lbf"),
    "s": ("s", "ms", "min", "h"),
}
WHICH = ("measured", "piezo", "smoothed", "sensor")  # in brackets behind a name, and no unit
RAISED = str.maketrans("⁻¹·*", "-1  ")
TIMES = re.compile(r"([\d.]+(?:[eE][+-]?\d+)?)\s*(\S.*)")
BRACKETS = re.compile(r"(.*?)\s?[\[({]([^\])}]{0,40})[\])}]")
COMMA = re.compile(r"(.*[^\s,]), ?([^\s,]{1,13})")
SLASH = re.compile(r"([^/]*[^/\s]) ?/ ?([^\d/][^/]{0,12}(?:/\w{1,4})?)")
LAST = re.compile(r"(.*?[^\W_])(?: in |[ _])([^\W\d_]{1,13})")
LABEL = re.compile(
    r"\W*+((?:[^\W\d_]{1,20}[ _-]){0,2}[^\W\d_]{0,20}?)[ _-]?units?\W+([^\W\d_]{1,13}(?:/\w{1,4})?)\W*", re.I
)
FOR_X = re.compile(r"\b(lateral|horizontal|length|distance|x)\b", re.I)
FOR_Z = re.compile(r"\b(values?|height|vertical|y|z)\b", re.I)


def plain_unit(text: str) -> str:
    """A unit with one sign for micro and one for Angstrom, each of which Unicode has twice; N m^-1 as N/m."""
    text = normalize("NFC", text).replace("\N{GREEK SMALL LETTER MU}", "\N{MICRO SIGN}").translate(RAISED)
    return re.sub(r"^(\w+) +(\w+) ?\^?-1$", r"\1/\2", text.strip())


def named_unit(text: str) -> bool:
    """Whether a text is a unit and nothing else."""
    unit = plain_unit(text.strip("[](){} "))
    return bool(quantity(unit)) or unit in OTHERS


def parted(cell: str) -> tuple[str, str | None]:
    """(name, unit or None) of a cell of a heading: F (N/m), F [N/m], F / N/m, x um, x_um, x in um, or a unit alone."""
    if match := BRACKETS.fullmatch(cell):
        return (match[1], plain_unit(match[2])) if match[2] not in WHICH else (cell, None)
    if match := SLASH.fullmatch(cell):
        return match[1], plain_unit(match[2])
    if (match := COMMA.fullmatch(cell)) and named_unit(match[2]):
        return match[1], plain_unit(match[2])
    match = LAST.fullmatch(cell)
    if match and named_unit(match[2]) and (len(match[2]) > 1 or " in " in cell):
        return match[1], plain_unit(match[2])
    if len(cell) > 1 and named_unit(cell) and cell not in (*OTHERS, "F_s", "A_0"):  # pixel is a name as well
        return "", plain_unit(cell)
    words = [
        word for word in re.findall(r"[^\W\d_]{2,}", plain_unit(cell)) if is_unit(word, READ) and word.lower() != "in"
    ]
    return cell, words[0] if len(words) == 1 else None  # within a name, as in Defl_pN_Ex


def quantity(unit: str | None) -> str:
    """The unit in which a unit is read: nm, N/m, N, s, F_s or A_0; "" for one that is not known.

    Lengths may be in capitals, as MICRON, but Nm is a torque.
    """
    if not unit or unit in READ_IN:
        return READ_IN.get(unit or "", "")
    return "nm" if unit.lower() in SIZES["nm"] and (len(unit) > 2 or unit.isupper()) else ""


def usual(of: tuple[str, ...] = LENGTH) -> tuple[str, ...]:
    """Units to choose from, where one of `of` is wanted."""
    return tuple(unit for name in of for unit in USUAL.get(name, (name,)))


def allowed_of(of: tuple[str, ...] = LENGTH) -> str:
    """The same as a message lists them."""
    return f'{", ".join(usual(of))}, or what 1 is, as "0.5 {"nN" if "N" in of else usual(of)[1]}"'


def is_unit(unit: str | None, of: tuple[str, ...] = LENGTH) -> bool:
    """Whether a unit is one of those that are read in one of some units."""
    return quantity(unit) in of


def _times_word(unit):
    """(number, unit) of "0.5 um"; the number is 1 without one."""
    plain = plain_unit(str(unit)).removeprefix("\ufeff")
    match = TIMES.fullmatch(plain)
    return (float(match[1]), match[2]) if match else (1.0, plain)


def measure(unit: str, of: tuple[str, ...] = LENGTH, name: str = "unit") -> tuple[float, str]:
    """(how much a unit is, the unit in which it is read: one of `of`); a number may stand before it, as in "0.5 um".

    Raises DataError, which calls it `name`, for another one.
    """
    times, word = _times_word(unit)
    if not is_unit(word, of) or not times > 0.0:
        raise DataError(f"{name} = {str(unit)[:40]!r}; allowed units: {allowed_of(of)}; give one of these")
    sizes = SIZES[quantity(word)]
    return times * (sizes[word] if word in sizes else sizes[word.lower()]), quantity(word)


def agreed(
    given: str, own: str | None, of: tuple[str, ...] = LENGTH, name: str = "unit", role: str = ""
) -> tuple[float, str]:
    """`measure` of a unit that an argument gives for a role; own: the unit that the file names, or None.

    An argument replaces no unit: raises DataError where both differ, unless `given` says what 1 of the other is, as
    "10 N" does of V.
    """
    found = measure(given, of, name)
    if own and named_unit(own):
        same, number = quantity(own) == found[1], TIMES.fullmatch(plain_unit(given))
        example = f'units={{"{role}": "10 {given}"}}' if role else f'"10 {given}"'
        remedies = ["leave it out"] if is_unit(own, of) else []
        remedies.append("correct the file" if same else f"say what 1 {own} is, as {example}")
        if not math.isclose(measure(own, of)[0], found[0]) if same else not number:
            raise DataError(f"{name} = {given!r}, but the file names {own}; {', or '.join(remedies)}")
    return found


def labelled_unit(line: str) -> tuple[str, str] | None:
    """(words before it, unit) of a line as `Lateral units: um`, `XUnit = mm` and `Units: um`; None of another line."""
    match = LABEL.fullmatch(normalize("NFC", line))
    return (match[1].replace("_", " "), plain_unit(match[2])) if match and named_unit(match[2]) else None


def units_above(lines: Iterable[str]) -> dict[str, str]:
    """{"x", "z": unit} of lines that label a length unit, the lowest first."""
    found: dict[str, str] = {}
    for said, unit in filter(None, map(labelled_unit, reversed(list(lines)))):
        for name, words in (("x", FOR_X), ("z", FOR_Z)):
            if is_unit(unit) and (not said or words.search(said)):  # of both, if it says nothing else
                found.setdefault(name, unit)
    return found


def unit_said(lines: Iterable[str], own: str | None, of: tuple[str, ...]) -> str | None:
    """The unit of a quantity in one of `of`: its own, or that of a line above that labels the only one.

    Two that differ are one that is not known. Beside an own unit a line counts if it names no other quantity.
    """
    labels = [label for label in map(labelled_unit, lines) if label and is_unit(label[1], of)]
    said = dict.fromkeys(unit for words, unit in labels if not own or not words)
    if own and not is_unit(own, of):
        return own
    units = [own, *(unit for unit in said if not own or measure(unit, of) != measure(own, of))] if own else [*said]
    return " or ".join(filter(None, units)) or None


def mentioned(lines: Iterable[str], of: tuple[str, ...] = LENGTH) -> str:
    """Why a unit in some line above the numbers is not used: it may be of anything; "" where there is none."""
    for line in reversed(list(lines)):
        for word in re.findall(r"[^\W\d_]{2,}", plain_unit(line).replace("_", " ")):
            if is_unit(word, of) and word.lower() != "in":
                return f"; the line {' '.join(line.split())[:40]!r} names {word}, but not of which column"
    return ""
