"""Units of length that the lines above the numbers of a file name: those of x and z."""

import re
from unicodedata import normalize

from ..surfaces import DataError

NM = {  # words of a unit, in small letters: nm
    1.0: ("nm", "nanometer", "nanometre"),
    1e3: ("um", "µm", "âµm", "micron", "micrometer", "micrometre"),  # the third: UTF-8 read as Latin-1
    1e6: ("mm", "millimeter", "millimetre"),
    1e7: ("cm", "centimeter", "centimetre"),
    1e9: ("m", "meter", "metre"),
    0.1: ("å", "a", "angstrom", "angström", "ångström", "ångstrom"),
}
FACTORS = {plural: nm for nm, words in NM.items() for word in words for plural in (word, word + "s" * (len(word) > 2))}
OTHERS = ("v", "mv", "volt", "volts", "inch", "inches", "ft", "pm", "px", "pixel", "pixels")  # refused
# a unit in brackets, after a slash, or after "unit"
ENCLOSED = re.compile(
    r"[\[({]\s*([^\W\d]{1,12})\s*[\])}]|/\s?([^\W\d]{1,12})\b|\bunits?\b\W{0,3}([^\W\d]{1,12})$", re.I
)
WORD = re.compile(r"[^\W\d_]+")
FOR_X, FOR_Z = re.compile(r"lateral|horizontal|length|distance", re.I), re.compile(r"value|height|vertical", re.I)


def factor(unit: str) -> float:
    """Return nm per unit of length; raises DataError for an unknown unit."""
    nm = FACTORS.get(unit.strip().lower().replace("\N{GREEK SMALL LETTER MU}", "µ"))
    if nm is None:
        raise DataError(f"unit = {unit[:40]!r}; allowed units: nm, um, mm, cm, m, Å; give one of these")
    return nm


def units_above(text: str) -> tuple[str, str] | None:
    """Return the units of x and z that the lines `text` name, the lowest line first; None where there is none.

    One unit counts for both. Raises DataError for a unit of another kind, and for one that may be of something else.
    """
    x = z = None
    for line in reversed(normalize("NFC", text).replace("\N{GREEK SMALL LETTER MU}", "µ").splitlines()):
        units = _units(line)
        if len(units) > 1:
            names = [word.lower() for word in WORD.findall(line) if word.lower() in ("x", "z")]
            first, second = (1, 0) if names[:2] == ["z", "x"] else (0, 1)
            return x or units[first], z or units[second]
        if not units:
            continue
        if re.search(r"\d", line) and not re.search(r"\bunits?\b", line, re.I):
            reason = f"the line {line.strip()[:40]!r} names {units[0]}, but not of which column"
            raise DataError(f"{reason}; write the units of both right above the numbers, as in x (um), z (um)")
        if FOR_X.search(line) and not FOR_Z.search(line):
            x = x or units[0]
        elif FOR_Z.search(line) and not FOR_X.search(line):
            z = z or units[0]
        else:
            return x or units[0], z or units[0]
    return (x or z, z or x) if x or z else None  # type: ignore[return-value]


def _units(line):
    """The units that a line names, in order."""
    marked = {group.lower() for match in ENCLOSED.findall(line) for group in match if group}
    words = WORD.findall(line.replace("_", " "))
    alone = bool(words) and all(word.lower() in FACTORS for word in words)  # a row of units
    found = []
    for word in words:
        plain = word.lower()
        if plain in OTHERS and plain in marked:
            raise DataError(f"a length in {word}; allowed units: nm, um, mm, cm, m, Å; convert it")
        if plain in FACTORS and (len(plain) > 1 or plain in marked or alone):
            found.append(word)
    return found
