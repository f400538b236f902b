"""Which columns of a table are those of a measured curve, and in which units: what is not certain is asked for."""

import re
from contextlib import suppress
from math import inf
from types import SimpleNamespace

from ..surfaces import DataError
from .columns import asked, called, checked, given, plain, recognised
from .tables import SHOWN, Table
from .units import FORCE, LENGTH, agreed, allowed_of, is_unit, measure, mentioned, named_unit, quantity, unit_said

NEEDED_BY = {
    "friction": "U_x and F of friction, or time and F with a speed",
    "load": "delta and L of a load",
    "area": "A over F, L or U_x",
}
NEEDED = "; ".join(NEEDED_BY.values())
KINDS = ("friction", "loop", "load", "area")
ROLES = ("U_x", "delta", "time", "F", "F_bar", "L", "L_bar", "A", "A_bar", "segment", "stage")  # of `columns`
# heights that a sensor measured, the best first; then setpoints of the piezo
HEIGHTS = (
    *("heightmeasured", "measuredheight", "capacitivesensorheight"),
    *("heightmeasuredsmoothed", "smoothedmeasuredheight", "smoothedcapacitivesensorheight", "height", "heightpiezo"),
)
NAMED = {  # what a heading may say, in small letters without blanks and signs
    "U_x": ("ux", "tangentialdisplacement", "lateraldisplacement", "slidingdistance", "shift"),
    # along the surface or into it: the other column or `kind` tells
    "displacement": ("displacement", "position", "extension", "crosshead", "distance"),
    "F_bar": ("fbar",),
    "F": ("fx", "fy", "ff", "ft", "friction", "frictionforce", "tangentialforce", "lateralforce", "shearforce"),
    "force": ("f", "force"),  # F beside U_x or an area; L beside delta or a height
    "L_bar": ("lbar",),
    "L": ("l", "fz", "fn", "load", "normalload", "normalforce", "verticaldeflection", "vdeflection"),
    "A_bar": ("abar",),
    "A": ("a", "area", "contactarea", "realcontactarea"),
    "delta": ("delta", "indentation", "indentationdepth", "depth", "penetration"),
    "height": HEIGHTS,  # falls as delta grows, and has the lever in it
    "gap": ("gap", "separation", "tipsampleseparation", "tipposition"),  # falls as delta grows
    "position": ("z", "zsense", "zsensor", "zposition", "piezo", "normaldisplacement"),  # either way
    "time": ("time", "t", "times", "elapsedtime", "seriestime"),
    "stage": ("stage",),
    "segment": ("segment", "phase"),
}
SYMBOLS = ("f", "l", "delta")  # names of this package, each of which means one quantity
DEEP, FORCES, LOADS, AREAS = ("delta", "height", "gap", "position"), ("F_bar", "F"), ("L", "L_bar"), ("A", "A_bar")
MEANT = {  # over one of, one of; the first that a heading names is meant
    "friction": (("U_x", "displacement", "time"), (*FORCES, "force")),
    "load": ((*DEEP, "displacement"), (*LOADS, "force")),
    "area": (("U_x", "displacement", *FORCES, "force", *LOADS), AREAS),
}
SIDES = {  # quantities of either side of a curve, the likely one first
    "friction": (("U_x", "time"), ("F",)),
    "load": (("delta",), ("L",)),
    "area": (("F", "L", "U_x"), ("A",)),
}
UNITS_OF = {"U_x": LENGTH, "delta": LENGTH, "time": ("s",), "F": FORCE, "L": FORCE, "A": (*LENGTH, "A_0")}


def quantity_of(role: str, kind: str = "") -> str:
    """What a column of that role is in a curve of that kind."""
    if role in ("height", "gap", "position") or (role == "displacement" and kind == "load"):
        return "delta"
    if role == "force":
        return "L" if kind == "load" else "F"
    return "U_x" if role == "displacement" else role.removesuffix("_bar")


READ_AS = {role: UNITS_OF.get(quantity_of(role), ()) for role in NAMED if not role.endswith("_bar")}


def proposed(table: Table, kind: str = "") -> tuple[str, dict[str, int]]:
    """(the kind of a curve, "" where it is not certain; {quantity: index} of the columns that names tell)."""
    roles = Roles(table, SimpleNamespace(kind=kind or None, columns=None, units=None, speed=None, force=None))
    with suppress(DataError):
        roles.find(None)
    return kind or roles.kind, roles.of


def _with_units(table, headings):
    """The Table with the units that lines above its heading label."""
    both = zip(table.columns, headings, strict=True)
    units = [unit_said(table.above, column.unit, READ_AS.get(role, ())) for column, role in both]
    columns = (column._replace(unit=unit) for column, unit in zip(table.columns, units, strict=True))
    return table._replace(columns=tuple(columns))


class Roles:
    """The columns of a curve. Raises DataError where they are not certain, or without a unit.

    how: the arguments of `read_measurement`. headings: what each column is by its name, or ""; known: {role: index}.
    kind: "friction" (a loop as well), "load" or "area". of: {quantity: index of its column}, that of x first; role:
    {quantity: what its heading says it is}; scaled: {quantity: (factor, unit of what is read)}. notes: what is left
    out, `noted` of it by role, and units as given.
    """

    def __init__(self, table: Table, how: SimpleNamespace) -> None:
        _, self.headings = recognised(table, NAMED)
        self.table, self.how = _with_units(table, self.headings), how
        table = self.table
        names = {plain(column.name) for column in table.columns}
        best = next((k for k, word in enumerate(HEIGHTS) if word in names), len(HEIGHTS))
        less = {*HEIGHTS[best + 1 :]}
        if best < len(HEIGHTS) - 1 or names & {*NAMED["gap"][:-1]}:  # what is computed from the piezo comes last
            less |= {HEIGHTS[-1], NAMED["gap"][-1]}
        known, roles = recognised(table, {role: [*{*words} - less] for role, words in NAMED.items()}, READ_AS)
        self.given = given(table, how.columns, ROLES)
        how.units = checked("units", how.units, ROLES)
        free = {role: k for role, k in known.items() if k not in self.given.values()}
        self.known = {role: k for role, k in (free | self.given).items() if k is not None}
        self.named = {*self.known, *(role for role in roles if roles.count(role) > 1)}
        self.of: dict[str, int] = {}
        self.noted: tuple[str, ...] = ()
        self.notes: list[str] = []
        self.kind = ""

    def find(self, sliding: bool | None) -> str:
        """Set the rest, and return the kind.

        sliding: whether a column `stage` has stages that slide; None without one.
        """
        self.kind, self.role = self._kind(sliding)
        self.of = {name: self.known[role] for name, role in self.role.items()}
        if self.heading("delta") in ("height", "gap", "position"):  # also one that an argument calls delta
            self.role["delta"] = self.heading("delta")
        self._reject_units()
        self.scaled = {name: scaled for name in self.of if (scaled := self._unit(name))}
        if missing := [name for name in list(self.of)[:2] if name not in self.scaled]:
            raise self._asked_units(missing)
        self.of = {name: self.of[name] for name in self.scaled}
        return self.kind

    def heading(self, name: str) -> str:
        """What a heading says that the column of a quantity is."""
        return self.headings[self.of[name]] if name in self.of else ""

    def _kind(self, sliding):
        """(the kind of the curve, {quantity: role})."""
        kind = "friction" if self.how.kind == "loop" else self.how.kind
        known, named = self.known, self.named
        over = [role for role in ("U_x", "delta", "time") if self.given.get(role) is not None]
        along, timed = {"U_x", *FORCES} & named, {"time"} if self.how.speed is not None else set()
        for found in (kind,) if kind else MEANT:
            across, values = MEANT[found]
            x = [role for role in over or across if role in across and role in named]
            y = [role for role in values if role in named and not (x and known.get(role, -1) == known.get(x[0]))]
            if not (x and y) or (sliding is not None and sliding != (found == "friction")):
                continue
            if not kind and found == "friction" and y[0] == "force" and x[0] not in {"U_x", *timed}:
                continue
            if not kind and found != "friction" and x[0] == "displacement":  # a machine's may be that of a press
                continue
            if not kind and found == "load" and along and not over and sliding is None:
                continue
            if x[0] not in known or y[0] not in known or self._rivals(x) or self._rivals([y[0], "force"]):
                break
            if not kind and x[0] == "displacement" and x[0] not in over and (beside := self._other_way()):
                name = called(self.table, known[x[0]])
                reason = f"is {name!r} the way along the surface, beside {beside!r}? Else give time and speed"
                raise self._asked(reason, {"F": known[y[0]]}, ("U_x", "F"))
            return found, self._with_others(found, x[0], y[0])
        raise self._asked_kind(kind)

    def _rivals(self, roles):
        """Whether columns of other roles may be meant in place of the first one, which was not given."""
        rivals = {*DEEP, "displacement"} if roles[0] in (*DEEP, "displacement") else {*FORCES, *LOADS, "force"}
        meant = {self.known[role] for role in roles if role in self.known and role in rivals}
        others = () if roles[0] in FORCES else SYMBOLS  # F beside L is no load
        meant = {k for k in meant if plain(self.table.columns[k].name) not in others}
        return len(meant) > 1 and roles[0] in rivals and roles[0] not in self.given

    def _other_way(self):
        """The name of a time, or of another length, beside which a displacement may be wear; "" without one."""
        others = [k for k, role in enumerate(self.headings) if role not in ("displacement", "A", "A_bar")]
        of = self.table.columns
        return next((of[k].name for k in others if self.headings[k] == "time" or is_unit(of[k].unit, LENGTH)), "")

    def _with_others(self, kind, over, value):
        """{quantity: role} of a curve of that kind, L and A beside a friction force among them."""
        role = {quantity_of(over, kind): over, quantity_of(value, kind): value}
        if kind == "friction":
            own, other = ("L_bar", "L") if value == "F_bar" else ("L", "L_bar")
            if other in self.known and own not in self.known:
                self.noted = ("L", "L_bar")
                beside = "F_bar" if value == "F_bar" else "F"
                self.notes.append(f"{other} is left out beside {beside}; give {own}: w E may be free.")
            role |= {quantity_of(each, kind): each for each in (own, *reversed(AREAS)) if each in self.known}
        return role

    def _asked_kind(self, kind):
        """The DataError for columns that are not certain."""
        known, table, named = self.known, self.table, self.named
        if not kind and "displacement" in known and {"force", *LOADS} & known.keys():
            reason = "a displacement and a force: along the surface (friction, loop) or into it (load)?"
            return DataError(f"{reason} {table}", table=table, call={"kind": ...})
        if not kind and {"time", "force"} <= known.keys() and not {*DEEP} & named:
            return DataError(f"a force over time; {table}", table=table, call={"kind": "friction", "speed": ...})
        reason = f"which column is what is not certain; needed: {NEEDED_BY[kind] if kind else NEEDED}"
        loads = {*DEEP, *LOADS} & known.keys() and not {"U_x", *FORCES} & named
        kind = kind or ("area" if {*AREAS} & known.keys() else "load" if loads else "friction")
        both = zip(table.columns, self.headings, strict=True)
        way = {"U_x", "displacement"} & named or any(is_unit(column.unit, LENGTH) for column, role in both if not role)
        timed = kind == "friction" and "time" in known and not way
        names = ("time", "F") if timed else tuple(side[0] for side in SIDES[kind])
        over, values = [role for role in MEANT[kind][0] if (role == "time") == timed], MEANT[kind][1]
        at = [{known.get(each) for each in roles if each in named} for roles in (over, values)]
        self.of = {name: found.pop() for name, found in zip(names, at, strict=True) if len(found) == 1}
        self.of = {name: k for name, k in self.of.items() if k is not None}
        return self._asked(reason, self.of, names, **{"speed": ...} if timed and self.how.speed is None else {})

    def _asked(self, reason, of, names, **more):
        """The DataError for the columns and units of quantities."""
        return asked(self.table, reason, of, {name: UNITS_OF[name] for name in names}, self.how.units, **more)

    def _reject_units(self):
        """Raises DataError for a unit of what is no column of the file."""
        there = dict.fromkeys([*self.of, *self.known, *(quantity_of(role, self.kind) for role in self.known)])
        there = [role for role in there if role in ROLES and role not in ("segment", "stage")]
        for role in self.how.units:
            if role not in there:
                reason = f"units has {role!r}, and no column is that; there are {', '.join(there)}; leave it out"
                raise DataError(reason)

    def _unit(self, name):
        """(factor, unit of what is read) of a quantity; None where neither the file nor an argument names one."""
        role, column, force = self.role[name], self.table.columns[self.of[name]], self.how.force
        wanted = self.how.units.get(name, self.how.units.get(role))
        own, allowed = column.unit, UNITS_OF[name]
        if role.endswith("_bar"):
            if unit := wanted or (own if own and named_unit(own) else None):
                call = {} if wanted else {"columns": {name: called(self.table, self.of[name])}}
                if call and role in self.given:
                    call["columns"][role] = None
                remedy = f"{'leave it out, or ' * bool(wanted)}give the column as {name}"
                raise DataError(f"{role} has no unit, and {unit} is one; {remedy}", table=self.table, call=call)
            return 1.0, "w" if name == "A" else "w E"
        if force is not None and name in ("F", "L"):
            if not 0.0 < force < inf:
                raise DataError(f"force = {force:g}; allowed: above 0, in N/m; give a number in that range, and sign=")
            if wanted or quantity(own) in ("N/m", "F_s"):
                raise DataError(f"force = {force:g}, but {column.name or name} is in {wanted or own}; leave force out")
            return force, "N/m"
        if wanted:
            if own and not is_unit(own, allowed):
                self.notes.append(f"{name} is read as {wanted}; the file says {own[:SHOWN]}.")
            return agreed(wanted, own, allowed, f"units[{name!r}]")
        return measure(own, allowed) if is_unit(own, allowed) else None

    def _asked_units(self, missing):
        """The DataError for quantities without a unit that is known."""
        whys = []
        for name in missing:
            unit, allowed = self.table.columns[self.of[name]].unit, allowed_of(UNITS_OF[name])
            why = f"{called(self.table, self.of[name])} in {unit[:SHOWN]!r}" if unit else f"{name} has no unit"
            why += "" if unit else mentioned(self.table.above, UNITS_OF[name])
            whys.append(f"{why}; allowed units: {allowed}")
            if unit and name == "A" and re.search("[²2]", unit):
                whys.append("divide it by its value without shear, and write A/A_0")
        over = [name for name in list(self.role)[:2] if not self.role[name].endswith("_bar")]
        return self._asked("; ".join(whys), self.of, over)
