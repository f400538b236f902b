"""What a browser may ask for: small JSON of known names, text and numbers, checked before anything is done with it."""

import json
import re
from dataclasses import dataclass, field
from math import isfinite

from app.session.controls import PARAMETERS
from solver.presets import presets

SMALL = 8000  # characters of an order, but for one that brings a file
LARGEST = 2_000_000  # characters of a file
LONGEST = 64  # characters of a value
LONGER = {"profile": 2000, "link": 5000, "free": 200, "text": SMALL}  # of those that are longer
PLAIN = ("hello", "pause", "go", "one", "skip", "rest", "reset")
ASKED = {  # of a page
    **dict.fromkeys(("E", "phi_t", "series", "percent", "draws"), (int, float)),
    **dict.fromkeys(("what", "of", "x", "y", "free"), str),
}
UPLOAD = re.compile(r'\{\s*"do"\s*:\s*"(profile|measurement)"\s*,\s*"values"\s*:\s*\{\s*"text"\s*:\s*(?=")')


class Refused(ValueError):
    """Something that no page of ours says; the message is a sentence for whoever said it, `where` an entry."""

    def __init__(self, message, where=None):
        super().__init__(message)
        self.where = where


@dataclass(frozen=True)
class Order:
    """do: what, with values {name: str, number or bool}; n: its number; after: (run, frame) to go on from.

    held: whether a hand is on the slider; at: U_x (nm) of what is on screen then.
    """

    do: str
    values: dict = field(default_factory=dict)
    n: float | None = None
    after: tuple | None = None
    held: bool = False
    at: float = 0.0


def read(text):
    """The Order in a text; raises Refused."""
    if len(text) > SMALL:
        return _brought(text)
    order = plain_json(text)
    if not isinstance(order, dict):
        raise Refused("An order could not be read.")
    do, values = str(order.get("do")), order.get("values") or {}
    if not isinstance(values, dict) or not all(map(_is_value, values, values.values())):
        raise Refused("An order may hold short texts and numbers only.")
    if do not in KNOWN or not KNOWN[do](values):
        raise Refused("An order was not understood.")
    held, at = order.get("held") is True, _number(order.get("at")) or 0.0
    return Order(do, values, _number(order.get("n")), _place(order.get("from")), held, at)


def _brought(text):
    """The Order that brings a file."""
    do, content, rest = one_text(text, UPLOAD)
    if len(text) > 1.1 * LARGEST:
        raise Refused(f"{do}: more than {LARGEST / 1e6:g} MB; thin it out.", do)
    order = plain_json('{"values": {"text": ""' + rest[:SMALL])
    return Order(do, {"text": content}, _number(isinstance(order, dict) and order.get("n")))


def one_text(message, start):
    """(what `start` finds at the beginning, the text behind it, the rest); raises Refused. Else nothing is read."""
    begun = start.match(message)
    if begun is None:
        raise Refused("A message was too long.")
    try:
        text, end = json.JSONDecoder().raw_decode(message, begun.end())
    except ValueError:
        raise Refused("A message could not be read.") from None
    return begun[1], text, message[end:]


def plain_json(text):
    """JSON of finite numbers, not too deep; raises Refused."""
    try:
        return json.loads(text, parse_constant=_no_number)
    except (ValueError, RecursionError):
        raise Refused("A message could not be read.") from None


def _no_number(text):
    raise ValueError(text)


def _is_scene(values, other=None):
    """Whether these are texts of an address, but for the value called `other`."""
    known = {"preset", "profile", *PARAMETERS}
    return all(name == other or (name in known and isinstance(value, str)) for name, value in values.items())


def _is_film(values):
    return values.keys() == {"run", "frame"} and all(type(v) is int and 0 < v < 1e6 for v in values.values())


def _is_layer(values):
    return values.keys() == {"rows", "modes", "depth"} and None not in map(_number, values.values())


KNOWN = {  # what may be ordered: whether it may be with these values
    **dict.fromkeys(PLAIN, lambda values: True),
    **dict.fromkeys(("profile", "measurement"), lambda values: isinstance(values.get("text"), str)),
    "scene": lambda values: values and values.keys() <= PARAMETERS.keys(),
    "ask": lambda values: all(isinstance(value, ASKED.get(name, ())) for name, value in values.items()),
    "restore": _is_scene,
    "beside": lambda values: type(values.get("beside")) is int and _is_scene(values, "beside"),
    "film": _is_film,
    "layer": _is_layer,
    "share": lambda values: isinstance(values.get("link"), str),
    "take": lambda values: values.get("kind") in ("npz", "json"),
    "preset": lambda values: values.get("preset") in presets(),
    "page": lambda values: isinstance(values.get("page"), str),
}


def _is_value(name, value):
    if isinstance(value, str):
        return len(value) <= LONGER.get(name, LONGEST)
    return isinstance(value, int | float) and abs(value) < 1e15


def _number(value):
    """A number that is told back, or None."""
    known = isinstance(value, int | float) and not isinstance(value, bool)
    return value if known and isfinite(value) and abs(value) < 1e15 else None


def _place(value):
    """(run, frame) as whole numbers, or None."""
    if not value:
        return None
    if isinstance(value, list) and len(value) == 2 and all(type(part) is int and 0 <= part < 1e9 for part in value):
        return tuple(value)
    raise Refused("An order names no increment of a run.")
