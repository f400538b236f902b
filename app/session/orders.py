"""Orders of a browser, {"do": name, "n": number, field: value, ...}: their fields, and what they do for a visitor."""

from typing import NamedTuple

from bokeh.core.properties import Any
from bokeh.model import DataModel

from app.session.controls import FOR_SERVER, PARAMETERS

SMALL = 8000  # characters of an entry; more than any number needs
LARGEST = 2_000_000  # bytes of a file; the browser checks this too
FILES, FORMATS = ("profile", "measurement"), ("npz", "json")


class Wire(DataModel):
    """The model through which a browser gives its orders."""

    order = Any(default=None)


class Refused(ValueError):
    """A rejected order."""

    def __init__(self):
        super().__init__("The page sent an order that this server does not know. Reload the page.")


# tests of the value of a field


def is_number(value):
    return type(value) in (int, float) and abs(value) < 1e15  # false for nan


def is_whole(value):
    return type(value) is int and 0 <= value < 1e9


def is_increment(value):
    """Whether it is [number of a run, frame]."""
    return isinstance(value, list) and len(value) == 2 and all(map(is_whole, value))


def is_text(value, most=64):
    return isinstance(value, str) and len(value) <= most


def is_link(value):
    return is_text(value, 5000)


def is_content(value):
    return isinstance(value, str)


def is_flag(value):
    return isinstance(value, bool)


def are_entries(values):
    """Whether it is {parameter: as it was entered}."""
    named = isinstance(values, dict) and values.keys() <= PARAMETERS.keys()
    return named and all(is_text(value, SMALL) or is_number(value) for value in values.values())


def is_address(values):
    named = isinstance(values, dict) and values.keys() <= FOR_SERVER
    return named and all(is_text(value, SMALL) for value in values.values())


class Order(NamedTuple):
    """What the Session does, the tests of the fields that the order must have, and of those that it may have."""

    method: str
    needs: dict = {}  # noqa: RUF012 (never changed)
    takes: dict = {}  # noqa: RUF012


ORDERS = {
    "hello": Order("hello"),  # the page is ready
    # held: a slider is moving; at: U_x (nm) on screen; after: the increment to continue from
    "scene": Order("change", {"values": are_entries}, {"held": is_flag, "at": is_number, "after": is_increment}),
    "release": Order("pursuit.release"),
    "skip": Order("pursuit.skip"),
    "pause": Order("pursuit.pause"),
    "resume": Order("pursuit.resume"),
    "step": Order("pursuit.step"),
    "restore": Order("restore", {"values": is_address}),
    "pin": Order("pinned.request", {"pin": is_whole, "values": is_address}),
    "file": Order("read_file", {"entry": FILES.__contains__, "text": is_content}),
    "film": Order("film.request", {"run": is_whole, "frame": is_whole}),
    # frame: of the run on screen, whose layer may differ from that of the frames after it
    "layer": Order("layer.request", {"rows": is_number, "modes": is_number, "depth": is_number}, {"frame": is_whole}),
    "share": Order("share.sheet", {"link": is_link}),
    "export": Order("share.export", {"kind": FORMATS.__contains__}),
    "page": Order("pages.open", {"page": is_text}),
    "ask": Order(  # values of the open page's controls
        "pages.order",
        takes={
            **dict.fromkeys(("what", "of", "x", "y"), is_text),
            **dict.fromkeys(("E", "phi_t", "series"), is_number),
            "free": is_link,
        },
    ),
}


def read(given):
    """Return (the method of a Session, {field: value}) for an order that a browser has given; raises Refused."""
    order = ORDERS.get(str(given.get("do")))
    values = {name: value for name, value in given.items() if name not in ("do", "n") and value is not None}
    tests = order.needs | order.takes if order else {}
    if not order or not order.needs.keys() <= values.keys() <= tests.keys():
        raise Refused
    if not all(tests[name](value) for name, value in values.items()):
        raise Refused
    return order.method, values
