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
LONGER = {"profile": 2000, "link": 5000, "free": 200}  # of those that are longer
# without values
PLAIN = (
    "hello",
    "pause",
    "go",
    "one",
    "skip",
    "rest",
    "reset",
    "measure",
    "cancel",
    "twin",
    "gallery",
)
ASKED = {  # of a page
    **dict.fromkeys(("E", "phi_t", "series"), (int, float)),
    **dict.fromkeys(("what", "of", "x", "y", "free"), str),
}
BROUGHT = ("profile", "measurement")  # by a file
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
    values, do = order.get("values") or {}, order.get("do")
    if do in BROUGHT and isinstance(values, dict) and isinstance(values.get("text"), str):
        return Order(do, {"text": values["text"]}, _number(order.get("n")))
    if not isinstance(values, dict) or not all(map(_is_value, values, values.values())):
        raise Refused("An order may hold short texts and numbers only.")
    n, held, at = _number(order.get("n")), order.get("held") is True, _number(order.get("at")) or 0.0
    checked = Order(str(do), values, n, _place(order.get("from")), held, at)
    if do in PLAIN:
        return Order(checked.do, {}, checked.n)
    if do == "scene" and values and values.keys() <= PARAMETERS.keys():
        return checked
    if do == "ask" and all(isinstance(value, ASKED.get(name, ())) for name, value in values.items()):
        return checked
    if do == "restore" and _is_scene(values):
        return checked
    if do == "beside" and type(values.get("beside")) is int and _is_scene(values, "beside"):
        return checked
    if (
        do == "film"
        and values.keys() == {"run", "frame"}
        and all(type(v) is int and 0 < v < 1e6 for v in values.values())
    ):
        return checked
    if do == "layer" and values.keys() == {"rows", "modes", "depth"} and None not in map(_number, values.values()):
        return checked
    if do == "share" and isinstance(values.get("link"), str):
        return checked
    if do == "take" and values.get("kind") in ("npz", "json"):
        return checked
    if do == "preset" and values.get("preset") in presets():
        return checked
    if do == "page" and isinstance(values.get("page"), str):
        return checked
    raise Refused("An order was not understood.")


def _brought(text):
    """The Order that brings a file; nothing of it is read but one text, however long it is."""
    start = UPLOAD.match(text)
    if start is None:
        raise Refused("An order was too long.")
    do = start[1]
    if len(text) > 1.1 * LARGEST:
        raise Refused(f"{do}: more than {LARGEST / 1e6:g} MB; thin it out.", do)
    try:
        content, end = json.JSONDecoder().raw_decode(text, start.end())
    except ValueError:
        raise Refused(f"{do}: the file could not be read.", do) from None
    rest = plain_json('{"values": {"text": ""' + text[end:][:SMALL])
    return Order(do, {"text": content}, _number(isinstance(rest, dict) and rest.get("n")))


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
