"""Which column of a table is what: by a short list of names, or as given. What is not certain is asked for."""

import json
import re
from collections.abc import Mapping, Sequence
from os import PathLike
from types import MappingProxyType
from typing import Any

from ..surfaces import DataError
from .tables import Block, Table
from .units import is_unit, parted

Given = Mapping[str, str | int | None]
UNIT_TELLS = "time", "segment", "stage"  # T (C) is no time, a phase in deg no segment


def plain(name: str) -> str:
    """A name in small letters without blanks and signs."""
    return re.sub(r"[\W_]", "", name.lower())


def recognised(
    table: Table, words: Mapping[str, Sequence[str]], units: Mapping[str, tuple[str, ...]] = MappingProxyType({})
) -> tuple[dict[str, int], list[str]]:
    """({role: index} of the roles that one column has by its name, [the role of each column, or ""]).

    words: {role: names as of `plain`}. units: {role: units in which it may be read}. Of several columns of a role the
    only one in such a unit is meant; one in another unit is no time, and one in any unit no segment.
    """
    role_of = {word: role for role, names in words.items() for word in names}
    roles = [role_of.get(plain(column.name), "") for column in table.columns]
    for role in units.keys() & {*roles}:
        at = [k for k, own in enumerate(roles) if own == role]
        suited = [k for k in at if is_unit(table.columns[k].unit, units[role])]
        strict = role in UNIT_TELLS
        for k in at:
            if k not in suited and (len(suited) == 1 if len(at) > 1 else strict and table.columns[k].unit):
                roles[k] = ""
    return {role: k for k, role in enumerate(roles) if role and roles.count(role) == 1}, roles


def given(table: Table, columns: Given | None, allowed: Sequence[str]) -> dict[str, int | None]:
    """{role: index} of the argument `columns`: {role: name, or number from 1 on, or None for none}."""
    wanted = checked("columns", columns, allowed).items()
    return {role: None if name is None else _index(table, role, name) for role, name in wanted}


def checked(name: str, values: Mapping[str, Any] | None, allowed: Sequence[str]) -> dict[str, Any]:
    """An argument {role: value}; raises DataError for a role that is not allowed."""
    for role in values or {}:
        if role not in allowed:
            raise DataError(f"{name} has {role!r}; allowed: {', '.join(allowed)}; give some of these")
    return dict(values or {})


def _index(table, role, wanted):
    if str(wanted).isdigit():
        at = [k for k in range(len(table.columns)) if k + 1 == int(wanted)]
    else:
        whole = str(wanted).strip().lower()
        both = [(column.name.lower(), (column.unit or "").lower()) for column in table.columns]
        at = [k for k, each in enumerate(both) if each[0] and (each[0] == whole or each == parted(whole))]
    if len(at) != 1:
        why = "is the name of several; give its number" if at else "is none of them; give a name or a number"
        raise DataError(f"columns[{role!r}] = {wanted!r} {why}; {table}", table=table, call={"columns": {role: ...}})
    return at[0]


def called(table: Table, index: int | None) -> str | int | None:
    """How the argument `columns` names a column: by its name, or else its number; None for none."""
    if index is None:
        return None
    names = [column.name for column in table.columns]
    return names[index] if names[index] and names.count(names[index]) == 1 else index + 1


def asked(
    table: Table,
    reason: str,
    of: Mapping[str, int | None],
    allowed: Mapping[str, tuple[str, ...]],
    units: Mapping[str, Any],
    **more: Any,
) -> DataError:
    """The DataError that shows a table and asks for the columns and units that are not known of some roles.

    of: {role: index, or None for none} of what is known. allowed: {role: units in which it may be read} of all.
    units: {role: unit} as given, or `...` for one that is not clear. more: other arguments of that call.
    """
    columns = {role: called(table, of[role]) if role in of else ... for role in allowed}
    rest = [column.unit for k, column in enumerate(table.columns) if k not in of.values()]
    wanted: dict[str, Any] = {}
    for role, known in allowed.items():
        k = of.get(role)
        own = rest if role not in of else [] if k is None else [table.columns[k].unit]
        suited = [unit for unit in own if is_unit(unit, known)]
        if role in units or role in of or not suited:  # a column to come brings its own unit
            wanted[role] = units.get(role, suited[0] if suited else ...)
    both = {"columns": columns, "units": wanted}
    call = {name: values for name, values in both.items() if {..., None} & {*values.values()}}
    call = call if call or more else both  # nothing is open: the call says all that is read
    return DataError(f"{reason}; {table}", table=table, call=call | more)


def not_used(block: Block, used: Sequence[int | None]) -> list[str]:
    """[a note on columns that are not used]."""
    rest = [column.name or f"column {k}" for k, column in enumerate(block.table.columns, 1) if k - 1 not in used]
    return [f"Not used: {', '.join(rest[:3])}{' ...' * (len(rest) > 3)}."] if rest else []


def for_user(error: DataError, function: str, source: Any, options: Mapping[str, Any]) -> DataError:
    """The error with the whole call that would read the file: the options as given, and what it asks for.

    function: up to its argument `source`, a path or a content. A role that was given, and that it
    asks for as None, is left out.
    """
    if error.call:
        path = isinstance(source, PathLike) or (isinstance(source, str) and "\n" not in source)
        error.function = function + (json.dumps(str(source), ensure_ascii=False) if path else "source")
        own = {name: value for name, value in options.items() if value is not None and value != {}}
        for name in own.keys() & error.call.keys() & {"columns", "units", "sign"}:
            wanted = error.call[name]
            unclear = {role: value for role, value in wanted.items() if value is ...}
            merged = {**wanted, **own[name], **unclear}
            refused = {role for role, value in wanted.items() if value is None and own[name].get(role) is not None}
            error.call[name] = {role: value for role, value in merged.items() if role not in refused}
        error.call = own | error.call
    return error
