"""Orders of a browser: parameters of the Stage, {"n": number, field: value}. How a method declares one."""

import re
from collections.abc import Callable
from inspect import Parameter, signature
from typing import Any, NamedTuple

from app.session.controls import FOR_SERVER, PARAMETERS

SMALL = 8000  # characters of an entry; more than any number needs
LARGEST = 2_000_000  # bytes of a file that comes in one piece; the browser checks this too
HALF = re.compile("[\ud800-\udfff]")  # half of a character: no encoding can write it, so nothing can send or save it


class Refused(ValueError):
    """A rejected order."""

    def __init__(self) -> None:
        super().__init__("The page sent an order that this server does not know. Reload the page.")


# tests of the value of a field


def is_number(value: Any) -> bool:
    return type(value) in (int, float) and abs(value) < 1e15  # false for nan


def is_whole(value: Any) -> bool:
    return type(value) is int and 0 <= value < 1e9


def is_text(value: Any, most: int = 64) -> bool:
    return isinstance(value, str) and len(value) <= most and not HALF.search(value)


def is_link(value: Any) -> bool:
    return is_text(value, 5000)


def is_content(value: Any) -> bool:
    return isinstance(value, bytes)


def is_flag(value: Any) -> bool:
    return isinstance(value, bool)


def are_entries(values: Any) -> bool:
    """Whether it is {parameter: as it was entered}."""
    named = isinstance(values, dict) and values.keys() <= PARAMETERS.keys()
    return named and all(is_text(value, SMALL) or is_number(value) for value in values.values())


def is_address(values: Any) -> bool:
    named = isinstance(values, dict) and values.keys() <= FOR_SERVER
    return named and all(is_text(value, SMALL) for value in values.values())


class Order(NamedTuple):
    """The name of an order, the tests of the fields that it must have, and of those that it may have."""

    name: str
    needs: dict[str, Callable[[Any], bool]]
    takes: dict[str, Callable[[Any], bool]]


def order(name: str, /, **tests: Callable[[Any], bool]) -> Callable[[Callable], Callable]:
    """Declare a method as an order of the browser; tests: {field: whether a value is valid}.

    A field may be missing if the method has a default for it, or takes any fields (`**values`).
    """

    def declare(method: Callable) -> Callable:
        parameters = signature(method).parameters
        must = {field for field in tests if field in parameters and parameters[field].default is Parameter.empty}
        needs = {field: test for field, test in tests.items() if field in must}
        method.order = Order(name, needs, {field: test for field, test in tests.items() if field not in must})  # type: ignore[attr-defined]
        return method

    return declare


def declared(owner: type) -> dict[str, str]:
    """Return {order: method} of a class."""
    methods = {name: getattr(owner, name) for name in dir(owner)}
    return {method.order.name: name for name, method in methods.items() if hasattr(method, "order")}


def orders_of(*owners: object) -> dict[str, Callable]:
    """Return {order: bound method} of some objects."""
    return {name: getattr(owner, method) for owner in owners for name, method in declared(type(owner)).items()}


def read(method: Callable, given: dict[str, Any]) -> tuple[Callable, dict[str, Any]]:
    """Return (method, {field: value}) for what a browser has set the parameter of a method to; raises Refused."""
    values = {name: value for name, value in given.items() if name != "n" and value is not None}
    _, needs, takes = method.order  # type: ignore[attr-defined]
    tests = needs | takes
    whole = needs.keys() <= values.keys() <= tests.keys()
    if not (whole and all(tests[name](value) for name, value in values.items())):
        raise Refused
    return method, values
