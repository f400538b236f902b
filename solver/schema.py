"""A parameter: a range or choices with unit and meaning, declared beside its field of Scene.

The command line, the page's address, the app's entries and all messages read these declarations.
"""

import reprlib
from collections.abc import Iterable
from dataclasses import field, fields
from difflib import get_close_matches
from math import inf, isfinite, nan
from typing import Any, NamedTuple

ASCII = str.maketrans(  # for outputs that cannot show a letter of a unit or a subscript
    {"δ": "delta", "φ": "phi", "ν": "nu", "χ": "chi", "ₙ": "_n", "ₜ": "_t", "₀": "_0", "µ": "u", "μ": "u", "Å": "A"}
    | {"²": "2", "−": "-", "∞": "inf", "⁻": "-", "¹": "1", "·": " "}
)


class SceneError(ValueError):
    """A parameter outside its range; the message gives its name, its value, the range and a remedy, in ASCII."""

    def __init__(self, name: str, value: object, allowed: str, remedy: str) -> None:
        self.name, self.value, self.allowed, self.remedy = name, value, allowed, remedy
        super().__init__(f"{name} = {reprlib.repr(value)}: {allowed}; {remedy}".translate(ASCII))

    def __reduce__(self) -> tuple[type, tuple[Any, ...]]:  # by default pickle would pass the message alone
        return SceneError, (self.name, self.value, self.allowed, self.remedy)


class Range(NamedTuple):
    """A number from `low` to `high`, in `unit`; `group` is its heading among the app's parameters."""

    low: float
    high: float
    unit: str
    meaning: str
    group: str
    whole: bool = False
    unbounded: bool = False  # infinity is allowed as well
    beyond: str = ""  # why lower values are not allowed, for messages

    @property
    def span(self) -> str:
        """The range as text, with its unit."""
        return f"{self.low:g} .. {self.high:g}{' or inf' * self.unbounded} {self.unit}".rstrip()

    def checked(self, name: str, value: Any) -> float:
        """`value` as an int or float; raises SceneError, which calls the parameter `name`."""
        number = as_number(value)
        if self.unbounded and (number == inf or str(value) == "inf"):  # the word stands for it in JSON
            return inf
        if isfinite(number) and self.low <= number <= self.high and (not self.whole or number == int(number)):
            return int(number) if self.whole else number
        kind = "a whole number" if self.whole else "a number"
        why = f" ({self.beyond})" if self.beyond and number < self.low else ""
        raise SceneError(name, value, f"allowed: {self.span}{why}", f"give {kind} in that range")


class Choice(NamedTuple):
    """One word of `choices` {word: meaning}."""

    choices: dict[str, str]
    meaning: str
    group: str

    @property
    def span(self) -> str:
        """The words as text."""
        return " | ".join(self.choices)

    def checked(self, name: str, value: Any) -> str:
        """`value`, if it is one of the choices; raises SceneError."""
        if not isinstance(value, str) or value not in self.choices:
            raise SceneError(name, value, f"allowed: {', '.join(self.choices)}", "choose one of them")
        return value


class Points(NamedTuple):
    """Points of a path as text: "0,-1; 0,0.2; 8,0.2" holds three pairs of numbers; `axes` are their ranges."""

    axes: tuple[Range, Range]
    most: int
    meaning: str
    group: str

    @property
    def span(self) -> str:
        """The ranges as text."""
        return f"up to {self.most} pairs, {self.axes[0].span} and {self.axes[1].span}"

    def read(self, name: str, text: Any) -> list[tuple[float, float]]:
        """The pairs of a text; raises SceneError, which names the pair."""
        pairs = [pair for pair in str(text).replace("−", "-").split(";") if pair.strip()]  # a true minus, as of numbers
        if not isinstance(text, str) or len(pairs) > self.most:
            raise SceneError(name, text, f"allowed: {self.span}", f"write at most {self.most} of them as text")
        return [self._pair(name, pair.split(",")) for pair in pairs]

    def _pair(self, name, numbers):
        try:
            x, y = map(float, numbers)
        except ValueError:
            allowed, remedy = "allowed: pairs of numbers", "write them as 0,-1; 0,0.2; 8,0.2"
            raise SceneError(name, ",".join(numbers).strip(), allowed, remedy) from None
        x, y = (axis.checked(name, value) for axis, value in zip(self.axes, (x, y), strict=True))
        return x, y

    def checked(self, name: str, value: Any) -> str:
        """`value` in its shortest form; raises SceneError."""
        return "; ".join(f"{x:.12g},{y:.12g}" for x, y in self.read(name, value))


def as_number(value: Any) -> float:
    """`value` as a float; nan for texts, truth values and everything else that is not a number."""
    try:
        return nan if isinstance(value, (bool, str, bytes)) else float(value)
    except (TypeError, ValueError, OverflowError):
        return nan


RETIRED = {  # {a parameter that there was: why it has no effect, and since which version}
    "window_n": "it has no effect since version 0.2, as springs act at any gap: leave it out"
}
MEANT = {  # {parameter: what others call it, in small letters without underscores}
    "E": ("emod", "emodulus", "young", "youngs", "youngsmodulus", "youngmodulus", "modulus", "stiffness"),
    "nu": ("poisson", "poissonratio", "poissonsratio"),
    "phi_ratio": ("phit", "ratio", "friction"),
    "phi_n": ("adhesion", "workofadhesion", "workofseparation", "gamma"),
    "delta_bar": ("delta", "depth", "indentation", "pressdepth"),
    "hold": ("load", "force", "normalload", "deadload"),
    "u_x_max": ("ux", "uxmax", "displacement", "distance"),
    "width": ("w", "length"),
    "height": ("h", "thickness"),
    "radius": ("r",),
    "nodes": ("n", "points"),
    "tolerance": ("tol",),
}


def name_remedy(name: str, allowed: Iterable[str]) -> str:
    """What to do about a name that is not allowed: leave it out if it is retired, else an allowed one like it."""
    if name in RETIRED:
        return RETIRED[name]
    by_lower = {other.lower(): other for other in allowed}
    plain = name.lower().replace("_", "").replace("'", "")
    meant = [other for other, words in MEANT.items() if plain in words and other.lower() in by_lower]
    similar = get_close_matches(name.lower(), by_lower, 1)
    return f"did you mean {(meant or [by_lower[similar[0]]])[0]}?" if meant or similar else "use one of these names"


def unknown_name(name: str, allowed: Iterable[str]) -> SceneError:
    """The error for a name that is no parameter."""
    allowed = list(allowed)
    return SceneError("name", name, f"allowed: {', '.join(allowed)}", name_remedy(name, allowed))


def number(default: float, *declared: Any, **more: Any) -> Any:
    """A dataclass field that holds a number; the other arguments are those of Range."""
    return field(default=default, metadata={"parameter": Range(*declared, **more)})


def word(default: str, *declared: Any) -> Any:
    """A dataclass field that holds one of several words; the other arguments are those of Choice."""
    return field(default=default, metadata={"parameter": Choice(*declared)})


def path_points(default: str, declared: Points) -> Any:
    """A dataclass field that holds the points of a path as text."""
    return field(default=default, metadata={"parameter": declared})


def parameters(cls: type) -> dict[str, Range | Choice | Points]:
    """{name: Range, Choice or Points} of a dataclass, in the order of its fields."""
    return {f.name: f.metadata["parameter"] for f in fields(cls) if "parameter" in f.metadata}
