"""Orders of a browser. Each class declares the fields, their types, and the action on the visitor's Session.

An order is {"do": name, "n": number, field: value, ...}.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Annotated, ClassVar

from bokeh.core.properties import Any
from bokeh.model import DataModel

from app.session.controls import PARAMETERS

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


def _is_number(value):
    return type(value) in (int, float) and abs(value) < 1e15  # false for nan


def _is_whole(value):
    return type(value) is int and 0 <= value < 1e9


def _is_increment(value):
    return isinstance(value, list) and len(value) == 2 and all(map(_is_whole, value))


def _is_text(value, most=64):
    return isinstance(value, str) and len(value) <= most


def _is_link(value):
    return _is_text(value, 5000)


def _is_any_text(value):
    return isinstance(value, str)


def _is_flag(value):
    return isinstance(value, bool)


def _are_entries(values):
    named = isinstance(values, dict) and values.keys() <= PARAMETERS.keys()
    return named and all(_is_text(value, SMALL) or _is_number(value) for value in values.values())


def _is_address(values):
    named = isinstance(values, dict) and values.keys() <= {"preset", "profile", *PARAMETERS}
    return named and all(_is_text(value, SMALL) for value in values.values())


# The type of a field, and the test of its values
Text, Link, Content = Annotated[str, _is_text], Annotated[str, _is_link], Annotated[str, _is_any_text]
Number, Whole, Flag = Annotated[float, _is_number], Annotated[int, _is_whole], Annotated[bool, _is_flag]
Increment = Annotated[list[int], _is_increment]  # [number of a run, frame]
Entries = Annotated[dict[str, str | float], _are_entries]  # {parameter: as it was entered}
Address = Annotated[dict[str, str], _is_address]
FileEntry, Format = Annotated[str, FILES.__contains__], Annotated[str, FORMATS.__contains__]


class Order(ABC):
    """A request of a browser. Subclasses declare fields; `obey` runs it."""

    kinds: ClassVar = {}  # {name: subclass}

    def __init_subclass__(cls):
        Order.kinds[cls.__name__.lower()] = dataclass(frozen=True)(cls)

    @abstractmethod
    def obey(self, session):
        """Run the order on a Session, under the lock of its document."""


class Hello(Order):
    """Start the first run: the page is ready."""

    def obey(self, session):
        session.hello()


class Scene(Order):
    """Change parameters. held: a slider is moving; at: U_x (nm) on screen; after: the increment to continue from."""

    values: Entries
    held: Flag = False
    at: Number = 0.0
    after: Increment = None

    def obey(self, session):
        session.change(self.values, self.after and tuple(self.after), self.held, self.at)


class Release(Order):
    """Compute the exact run: the visitor released the slider."""

    def obey(self, session):
        session.pursuit.release()


class Skip(Order):
    """End a slow run and keep its frames."""

    def obey(self, session):
        session.pursuit.skip()


class Pause(Order):
    """Compute no further slice."""

    def obey(self, session):
        session.pursuit.pause()


class Resume(Order):
    """Continue a paused run."""

    def obey(self, session):
        session.pursuit.resume()


class Step(Order):
    """Compute one increment of a paused run."""

    def obey(self, session):
        session.pursuit.step()


class Restore(Order):
    """Show the scene of an address; an empty one means the default preset."""

    values: Address

    def obey(self, session):
        session.restore(self.values)


class Pin(Order):
    """Send the run of a pin, given by its address."""

    pin: Whole
    values: Address

    def obey(self, session):
        session.pinned.request(self.pin, self.values)


class File(Order):
    """Read a file: a measured profile, or a measured curve to fit."""

    entry: FileEntry
    text: Content

    def obey(self, session):
        if self.entry == "profile":
            session.read_profile(self.text)
        else:
            session.pages.order({"what": "file", "text": self.text})


class Film(Order):
    """Send the transient that led to a frame of a run."""

    run: Whole
    frame: Whole

    def obey(self, session):
        session.film.request(vars(self))


class Layer(Order):
    """Send the table of the stress inside the layer, down to a depth (nm)."""

    rows: Number
    modes: Number
    depth: Number

    def obey(self, session):
        session.layer.request(vars(self))


class Share(Order):
    """Send the QR code of a link, and Python lines for the run on screen."""

    link: Link

    def obey(self, session):
        session.share.sheet(self.link)


class Export(Order):
    """Send the run on screen as a file."""

    kind: Format

    def obey(self, session):
        session.share.export(self.kind)


class Page(Order):
    """Open a page beside the experiment; an empty name closes it."""

    page: Text

    def obey(self, session):
        session.pages.open(self.page)


class Ask(Order):
    """Pass the values of the open page's controls to that page."""

    what: Text = None
    of: Text = None
    x: Text = None
    y: Text = None
    free: Link = None
    E: Number = None
    phi_t: Number = None
    series: Number = None

    def obey(self, session):
        session.pages.order({name: value for name, value in vars(self).items() if value is not None})


def read(given):
    """Return the Order that a browser has given as {name: value}; raises Refused."""
    kind = Order.kinds.get(str(given.get("do")))
    values = {name: value for name, value in given.items() if name not in ("do", "n") and value is not None}
    types = {field.name: field.type for field in fields(kind)} if kind else {}
    try:
        if all(types[name].__metadata__[0](value) for name, value in values.items()):
            return kind(**values)
    except (KeyError, TypeError):  # a field is unknown or missing
        pass
    raise Refused


def number_of(given):
    """Return the number of an order, or None."""
    return given.get("n") if _is_number(given.get("n")) else None
