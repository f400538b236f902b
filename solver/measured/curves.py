"""Measured curves from text files: which column is what, in which unit, and which way it was measured."""

import re
from collections.abc import Mapping
from itertools import groupby
from types import SimpleNamespace

import numpy as np

from ..run.frame import STAGES, Stage
from ..scene import Scene
from ..surfaces import DataError
from ..text import counted
from .columns import Given, asked, called, checked, for_user, given, not_used, plain, recognised
from .content import Source
from .force_curves import read_block
from .measurement import Measurement
from .recording import FEWEST, Recording, Segment, parts_of
from .tables import SHOWN, Block, Table, listed
from .units import (
    LENGTHS,
    NEWTONS,
    PER_WIDTH,
    SECONDS,
    agreed,
    allowed_of,
    factor,
    is_unit,
    named_unit,
    parted,
    quantity,
)

NEEDED_BY = {
    "friction": "U_x and F of friction, or time and F with a speed",
    "load": "delta and L of a load",
    "area": "A over F, L or U_x",
}
NEEDED = "; ".join(NEEDED_BY.values())
KINDS = ("friction", "loop", "load", "area")
ROLES = ("U_x", "delta", "time", "F", "F_bar", "L", "L_bar", "A", "A_bar", "segment", "stage")  # of `columns`
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
    "height": ("height", "heightmeasured"),  # falls as delta grows, and has the lever in it
    "gap": ("gap", "separation", "tipsampleseparation"),  # falls as delta grows
    "position": ("z", "zsense", "zsensor", "zposition", "piezo", "normaldisplacement"),  # either way
    "time": ("time", "t", "times", "elapsedtime", "seriestime"),
    "stage": ("stage",),
    "segment": ("segment", "phase"),
}
SYMBOLS = ("f", "l", "delta")  # names of this package, each of which means one quantity
DEEP, FORCES, LOADS, AREAS = ("delta", "height", "gap", "position"), ("F_bar", "F"), ("L", "L_bar"), ("A", "A_bar")
SURE = (  # kind, over one of, one of; the first that a heading names is meant
    ("friction", ("U_x",), (*FORCES, "force")),
    ("friction", ("displacement",), FORCES),
    ("load", DEEP, (*LOADS, "force")),  # where no friction force is named
    ("friction", ("time",), FORCES),
    ("area", ("U_x", *FORCES, "force", *LOADS), AREAS),
)
MEANT = {  # the same where `kind` is given
    "friction": (("U_x", "displacement", "time"), (*FORCES, "force")),
    "load": ((*DEEP, "displacement"), (*LOADS, "force")),
    "area": (("U_x", "displacement", *FORCES, "force", *LOADS), AREAS),
}
PARTS = {  # words for a segment
    "approach": ("approach", "extend", "loading", "false", "0"),
    "retract": ("retract", "withdraw", "unloading", "true", "1"),
    "hold": ("hold", "pause", "dwell", "intermediate", "2"),
    "forth": ("forth", "trace", "forward"),
    "back": ("back", "retrace", "backward"),
}
PART_OF = {word: part for part, words in PARTS.items() for word in words}
OF_STAGE = {"unload": "retract", "reload": "approach", "shear": "forth", "move": "forth"}  # others keep their name
FORCE_UNITS = PER_WIDTH | NEWTONS | {"F_s": 1.0}
UNITS_OF = {"F": FORCE_UNITS, "L": FORCE_UNITS, "time": SECONDS, "A": LENGTHS | {"A_0": 1.0}}  # of others: LENGTHS
SAID = re.compile(r'[#%{\s"]*([^\W\d][^\d:="]{1,60}?)"?\s*[:=]\s*"?((?:[^",]|,(?=\d)){1,60})')
SPRING = re.compile("spring|force con|stiffn", re.I)
SPRINGS = PER_WIDTH | {"nN/nm": 1.0, "pN/nm": 1e-3, "": 1.0}  # units of its stiffness
MOST_SAID = 100
MOST_PULLS = 0.95  # of the points: a load that is negative at more is likely counted downwards
PULL = "a pull (sign 1), or counted downwards (sign -1)?"
DEPTH = " And does delta grow (1) or fall (-1) to contact?"


def read_measurement(
    scene: Scene,
    source: Source | Block,
    speed: float | None = None,
    force: float | None = None,
    kind: str | None = None,
    columns: Given | None = None,
    units: Mapping[str, str] | None = None,
    part: tuple[float, float] | None = None,
    sign: Mapping[str, float] | None = None,
    deflection: float | None = None,
    channel: str | int | None = None,
) -> Measurement | Recording:
    """Reads a measured curve from a table with a heading: friction over U_x or time, a loop, a load, an area.

    NAMED lists what headings may say. Other columns and incomplete rows are left out. Of a file of a run the column
    `stage` names the segments; one stage of shear is a friction curve. L counts beside F, and L_bar beside F_bar.

    Parameters: scene: gives w E and w, over which forces in N/m and areas in nm are taken; source: a path, or the
    content of a file: text with line breaks, bytes, or an open file; or a Block of `read_table`. kind: one of KINDS,
    where columns do not tell.
    columns: {"U_x", "delta", "time", "F", "L", "A": name or number of a column, None for none}. units: {the same:
    unit}, also "0.5 nN" for what 1 in the file is. sign: {"L": -1} turns a column. part: only from .. to, nm of U_x
    or delta, or in the unit of a force. deflection: stiffness of the lever, N/m: L over it is taken off delta.
    speed: nm/s, of friction over time. force: N/m per unit of the forces: the width of the contact across the pull is
    in it. channel: the number of a table, from 1 on, where there are several.
    Returns a Measurement of a friction curve in N/m or as F_bar, which `fit` takes, its noise estimated; else a
    Recording, a loop in N/m among them.
    Raises DataError; where an argument is missing, it shows the table and the call that reads the file. TypeError for a
    scene that is none.

    Example: `read_measurement(Scene(), "measured.csv").noise`
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene = {scene!r:.60}: allowed: a Scene; the order is read_measurement(scene, source)")
    how = SimpleNamespace(speed=speed, force=force, kind=kind, columns=columns, units=units, part=part, sign=sign,
                          deflection=deflection, channel=channel)  # fmt: skip
    try:
        if kind is not None and kind not in KINDS:
            raise DataError(f"kind = {kind!r}: allowed: {', '.join(KINDS)}; give one of these")
        block = source if isinstance(source, Block) else read_block(source, NEEDED, channel)
        return _Reader(scene, block, how).read()
    except DataError as error:
        raise for_user(error, "read_measurement(scene, ", source, vars(how)) from None


class _Reader:
    """A Block on its way to a curve. how: the arguments; units: of its quantities; notes: how they were read.

    of: {quantity: index of its column}; role: {quantity: what its heading says it is}.
    """

    def __init__(self, scene, block, how):
        self.scene, self.block, self.how, self.table = scene, block, how, block.table
        self.said = _said(block.table.above)
        self.units: dict[str, str] = {}
        self.known, self.several = recognised(self.table, NAMED)
        self.given = given(self.table, how.columns, ROLES)
        how.units = checked("units", how.units, ROLES)
        self.own = {k: role for role, k in self.known.items()}  # what a heading says of a column
        self.known = {role: k for role, k in (self.known | self.given).items() if k is not None}
        self.notes: list[str] = []

    def read(self):
        """The Measurement or Recording."""
        self.stages = self._stages()
        self.kind = self._kind()
        values, lines = self._values()
        values = self._turned(self._timed(values))
        kept = self._part(values)
        lines, values = lines[kept], {name: column[kept] for name, column in values.items()}
        return {"friction": self._friction, "load": self._load, "area": self._area}[self.kind](lines, values)

    def _kind(self):
        """The kind of the curve, "friction" for a loop as well; sets `of`. Raises DataError where it is not certain."""
        kind = "friction" if self.how.kind == "loop" else self.how.kind
        known, named = self.known, {*self.known, *self.several}
        over = [role for role in ("U_x", "delta", "time") if self.given.get(role) is not None]
        sides = [(kind, *MEANT[kind])] if kind else SURE
        if self.how.speed is not None:
            sides = (*sides, ("friction", ("time",), ("force",)))
        if not kind and "displacement" in named and not {"U_x", "delta", *FORCES} & named:
            sides = ()  # a machine's displacement and force may be those of a press
        for found, across, values in sides:
            x = [role for role in over or across if role in across and role in named]
            y = [role for role in values if role in named and not (x and known.get(role, -1) == known.get(x[0]))]
            if not (x and y) or (self.stages is not None and found != self._stage_kind()):
                continue
            if not (kind or over or self.stages is not None) and found == "load" and {"U_x", *FORCES} & named:
                continue
            if x[0] not in known or y[0] not in known or self._rivals(x) or self._rivals([y[0], "force"]):
                break
            self._take(found, x[0], y[0])
            return found
        raise self._asked_kind(kind)

    def _rivals(self, roles):
        """Whether columns of other roles may be meant in place of the first one, which was not given."""
        rivals = {*DEEP, "displacement"} if roles[0] in (*DEEP, "displacement") else {*FORCES, *LOADS, "force"}
        meant = {self.known[role] for role in roles if role in self.known and role in rivals}
        others = () if roles[0] in FORCES else SYMBOLS  # F beside L is no load
        meant = {k for k in meant if plain(self.table.columns[k].name) not in others}
        return len(meant) > 1 and roles[0] in rivals and roles[0] not in self.given

    def _stage_kind(self):
        return "friction" if _sliding(self.stages) else "load"

    def _take(self, kind, over, value):
        """Sets `of` and `role`: the columns of a curve of that kind, L and A beside a friction force among them."""
        self.role = {quantity_of(over, kind): over, quantity_of(value, kind): value}
        if kind == "friction":
            own, other = ("L_bar", "L") if value == "F_bar" else ("L", "L_bar")
            if other in self.known and own not in self.known:
                self.notes.append(
                    f"{other} is left out beside {value.replace('force', 'F')}; give {own}: w E may be free."
                )
            self.role |= {quantity_of(role, kind): role for role in (own, *reversed(AREAS)) if role in self.known}
        self.of = {name: self.known[role] for name, role in self.role.items()}
        for name, k in self.of.items():  # a column that is named may be a height all the same
            if name == "delta" and self.own.get(k) in ("height", "gap", "position"):
                self.role[name] = self.own[k]
        for name in [name for name in self.of if name not in self._needed() and self._unit(name) is None]:
            if name in self.how.units:
                continue
            self.of.pop(name)

    def _needed(self):
        return list(self.role)[:2]

    def _asked_kind(self, kind):
        """The DataError for columns that are not certain."""
        known, table, named = self.known, self.table, {*self.known, *self.several}
        if not kind and "displacement" in known and {"force", *LOADS} & known.keys():
            reason = "a displacement and a force: along the surface (friction, loop) or into it (load)?"
            return DataError(f"{reason} {table}", table=table, call={"kind": ...})
        if not kind and {"time", "force"} <= known.keys():
            return DataError(f"a force over time; {table}", table=table, call={"kind": "friction", "speed": ...})
        reason = f"which column is what is not certain; needed: {NEEDED_BY[kind] if kind else NEEDED}"
        loads = {*DEEP, *LOADS} & known.keys() and not {"U_x", *FORCES} & named
        kind = kind or ("area" if {*AREAS} & known.keys() else "load" if loads else "friction")
        names = {"friction": ("U_x", "F"), "load": ("delta", "L"), "area": ("F", "A")}[kind]
        deep = {known[role] for role in DEEP if role in known}
        along = [k for k, column in enumerate(table.columns) if is_unit(column.unit) and k not in deep]
        timed = "time" in known and not {"U_x", "displacement"} & named and ({*FORCES} & named or not along)
        if kind == "friction" and timed:
            names = ("time", "F")
        more = {"speed": ...} if "time" in names and self.how.speed is None else {}
        over, values = MEANT[kind]
        roles = {names[0]: [role for role in over if (role == "time") == (names[0] == "time")], names[1]: values}
        at = {name: {known.get(each) for each in roles[name] if each in named} for name in names}
        of = {name: found.pop() for name, found in at.items() if len(found) == 1 and None not in found}
        return self._asked(reason, of, names, **more)

    def _asked(self, reason, of, names, **more):
        """The DataError for the columns and units of quantities."""
        known = {name: UNITS_OF.get(name, LENGTHS) for name in names}
        return asked(self.table, reason, of, known, self.how.units, **more)

    def _unit(self, name):
        """(factor, unit of what is read) of a quantity; None where neither the file nor an argument names one."""
        role, column, force = self.role[name], self.table.columns[self.of[name]], self.how.force
        wanted, own, known = self.how.units.get(name), column.unit, UNITS_OF.get(name, LENGTHS)
        if role.endswith("_bar"):
            if unit := wanted or (own if own and named_unit(own) else None):
                raise DataError(f"{role} has no unit, and {unit} is one; leave it out, or give the column as {name}")
            return 1.0, "w" if name == "A" else "w E"
        if force is not None and name in ("F", "L"):
            if wanted or own in PER_WIDTH or own == "F_s":
                raise DataError(f"force = {force:g}, but {column.name or name} is in {wanted or own}; leave force out")
            return force, "N/m"
        if wanted:
            times = agreed(wanted, own, known, f"units[{name!r}]")
            if own and not is_unit(own, known):
                self.notes.append(f"{name} is read as {wanted}; the file says {own[:SHOWN]}.")
            return times, quantity(wanted)
        return (factor(own, known), quantity(own)) if is_unit(own, known) else None

    def _values(self):
        """({quantity: (k,)} of complete rows in `units`, numbers of their lines (k,)). Raises DataError."""
        scaled = {name: self._unit(name) for name in self.of}
        if missing := [name for name in self._needed() if scaled[name] is None]:
            raise self._asked_units(missing)
        self.units |= {name: unit for name, (_, unit) in scaled.items()}
        values = np.column_stack([self.block.numbers(name, k) * scaled[name][0] for name, k in self.of.items()])
        self.rows = np.ones(len(values), bool)
        if self.kind == "friction" and self.stages is not None and len(slides := _sliding(self.stages)) == 1:
            self.rows = self.stages == slides[0]
        complete = np.isfinite(values).all(axis=1)
        missing = self.block.lines[self.rows & ~complete].tolist()
        count = counted(len(missing), "row")
        self.notes += [f"{count} without all numbers left out (line {listed(missing)})."] * bool(missing)
        self.rows &= complete
        if not self.rows.any():
            raise DataError(f"no row has numbers in all of {', '.join(self.of)}; needed: {NEEDED}")
        if self.stages is None:
            named = ("stage", "segment", *(("L", "L_bar") if self.notes else ()))  # a note has those already
            beside = [self.known[role] for role in named if role in self.known]
            self.notes += not_used(self.block, [*self.of.values(), *beside])
        self.notes += self.block.notes
        return dict(zip(self.of, values[self.rows].T, strict=True)), np.flatnonzero(self.rows)

    def _asked_units(self, missing):
        """The DataError for quantities without a unit that is known."""
        whys = []
        for name in missing:
            unit, allowed = self.table.columns[self.of[name]].unit, allowed_of(UNITS_OF.get(name, LENGTHS))
            why = f"{called(self.table, self.of[name])} in {unit[:SHOWN]!r}" if unit else f"{name} has no unit"
            whys.append(f"{why}; allowed units: {allowed}")
            if unit and name == "A" and re.search("[²2]", unit):
                whys.append("divide it by its value without shear, and write A/A_0")
        over = [name for name in self._needed() if not self.role[name].endswith("_bar")]
        return self._asked("; ".join(whys), self.of, over)

    def _turned(self, values):
        """The quantities with their signs, without the deflection of the lever; asks for a sign that may be wrong."""
        sign = dict(self.how.sign or {})
        for name, by in sign.items():
            if name not in values or by not in (1, -1):
                raise DataError(f"sign has {name!r}: {by!r}; allowed: 1 or -1 of {', '.join(values)}; give such a sign")
            values[name] = by * values[name]
        if self.kind == "load":
            self._approaching(values, sign)
        elif "L" in values and "L" not in sign and self.stages is None and (values["L"] < 0.0).mean() > MOST_PULLS:
            raise self._asked_sign({"L": ...}, f"L is negative: {PULL}")
        k, (stiffness, said) = self.how.deflection, self._lever()
        if k is not None:
            if self.kind != "load" or self.units["L"] != "N" or not k > 0.0:
                raise DataError(
                    f"deflection = {k!r}: allowed: above 0, N/m, of a load in N; leave it out, or give units"
                )
            values["delta"] = values["delta"] - 1e9 * values["L"] / k
            self.notes += [f"deflection = {k:g} N/m as given; the file says {said}."] * bool(said)
        elif said:
            value = f"={stiffness:g}" if stiffness else ""
            self.notes.append(f"The file says {said}: the lever is in delta; deflection{value} takes it off.")
        return values

    def _lever(self):
        """(stiffness, N/m, or None; how the file says it, or "") of a lever whose deflection may be in delta."""
        if self.kind != "load" or self.units["L"] != "N" or self.own.get(self.of["delta"]) in ("delta", "gap"):
            return None, ""
        return _spring(self.said)

    def _approaching(self, values, sign):
        """Gives delta the sign with which it grows as the surfaces approach; asks where it may be either."""
        delta, L, role = values["delta"], values["L"], self.role["delta"]
        if role in ("height", "gap") and "delta" not in sign:
            delta = values["delta"] = -delta
        far = delta[0]
        if role == "position" and "delta" not in sign:
            likely = -1 if delta[np.argmax(L)] < far else 1
            raise self._asked_sign({"delta": likely}, f"does {self._title('delta')} grow (1) or fall (-1) to contact?")
        deep, edge = np.argsort(delta), max(1, delta.size // 20)
        falls = np.median(L[deep[-edge:]]) < np.median(L[deep[:edge]])
        own = self.own.get(self.of["delta"])
        unsure = own not in ("delta", "height", "gap")
        if "L" not in sign and (falls or (unsure and -L.min() > L.max())):
            either = {} if own == "delta" or "delta" in sign else {"delta": ...}
            why = "falls as the surfaces approach" if falls else "is negative where it is largest"
            reason = f"L {why}: {PULL}{DEPTH * bool(either)}"
            raise self._asked_sign({"L": ...} | either, reason)

    def _title(self, name):
        return repr(self.table.columns[self.of[name]].name[:SHOWN])

    def _asked_sign(self, sign, reason):
        k, said = self._lever() if self.how.deflection is None else (None, "")
        beside = f" The file says {said}: deflection takes the lever off." if said else ""
        call = {"sign": sign} | ({"deflection": k} if k else {})
        return DataError(f"{reason}{beside} {self.table}", table=self.table, call=call)

    def _part(self, values):
        """Which points (k,) are in the part that is asked for."""
        name = next(iter(values))
        over = values[name]
        if self.how.part is None:
            return slice(None)
        start, end = map(float, self.how.part)
        inside = (over >= start) & (over <= end)
        if inside.sum() < FEWEST:
            found = f"{over.min():.6g} .. {over.max():.6g} {self.units[name]}"
            raise DataError(
                f"part = {self.how.part}: {counted(int(inside.sum()), 'point')} of {found}; give a part of that"
            )
        self.notes.append(f"{inside.sum()} of {over.size} points are used, from {start:g} to {end:g}.")
        return inside

    def _friction(self, lines, values):
        """Friction over U_x: one stroke, or a loop."""
        slides = _sliding(self.stages) if self.stages is not None else []
        if len(slides) == 1:
            return self._stroke(values)
        parts = self._named(lines, bool(slides)) or parts_of(values["U_x"], "forth", "back")
        strokes = [part for part in parts if part[0] != "hold"]
        if self.how.kind == "loop" or (len(strokes) > 1 and self.how.kind is None):
            return self._recording("loop", "U_x", parts, values)
        if len(strokes) > 1:
            raise DataError(f"U_x goes to and fro in {len(strokes)} strokes", call={"kind": "loop"})
        name, at = strokes[0]
        if name == "back":
            reason = "U_x falls from first to last; turn the signs of U_x and F, or sort the lines"
            raise DataError(reason, call={"sign": {"U_x": -1, "F": -1}})
        held = values["U_x"].size - at.size
        self.notes += [f"a hold of {counted(held, 'point')} was left out."] * (held > 0)
        return self._stroke({key: column[at] for key, column in values.items()})

    def _load(self, lines, values):
        """Load over approach, and retraction."""
        parts = self._named(lines, False) or parts_of(values["delta"], "approach", "retract")
        return self._recording("load", "delta", parts, values, self.own.get(self.of["delta"]) != "delta")

    def _area(self, lines, values):
        """Area over U_x; or over a force: F, or L where there is no other."""
        over = self._needed()[0]
        if over == "U_x":
            parts = self._named(lines, False) or parts_of(values["U_x"], "forth", "back")
            return self._recording("area over displacement", over, parts, values)
        parts = [("", np.arange(values["A"].size))]
        return self._recording("area over load" if over == "L" else "area over force", over, parts, values)

    def _stroke(self, values):
        """A Measurement of one stroke; a Recording where the force is not in N/m."""
        back = int((np.diff(values["U_x"]) < 0.0).sum())
        if back > values["U_x"].size // 3:
            raise DataError("U_x goes to and fro; sort the lines by U_x")
        self.notes += [f"U_x goes back at {counted(back, 'point')}: put in order."] * (back > 0)
        order = np.argsort(values["U_x"], kind="stable")
        values, U_x = {name: column[order] for name, column in values.items()}, values["U_x"][order]
        if not {self.units[name] for name in values} <= {"nm", "N/m", "w E", "w"}:
            return self._recording("friction", "U_x", [("forth", np.arange(order.size))], values)
        over = {"N/m": self.scene.width * self.scene.E, "nm": self.scene.width}
        bars = {f"{name}_bar": values[name] / over.get(self.units[name], 1.0) for name in "FLA" if name in values}
        unit, width = over["N/m"] if self.units["F"] == "N/m" else None, self.scene.width
        width = width if self.units.get("A") == "nm" else None
        return Measurement.of(U_x, bars, None, unit, tuple(self.notes), width, self.said)

    def _recording(self, kind, over, parts, values, free=False):
        """The Recording of parts of columns, over one of them."""
        if values[over].size < FEWEST:
            raise DataError(f"points: {values[over].size}; needed: {FEWEST} or more; measure more densely")
        others = [name for name in values if name != over]
        segments = [Segment(name, values[over][at], {key: values[key][at] for key in others}) for name, at in parts]
        units = {name: self.units[name] for name in values}
        return Recording(kind, tuple(segments), units, free, self.said, tuple(dict.fromkeys(self.notes)))

    def _stages(self):
        """The column `stage`, as a run writes it; None without one. Raises DataError for one of other words."""
        if "stage" not in self.known:
            return None
        stages = self.block.cells[self.known["stage"]]
        words = list(dict.fromkeys(map(str, stages)))
        known = all(Stage(each).kind in STAGES for each in words)
        if known and (_sliding(stages) or {"delta", "L"} <= self.known.keys()):
            return stages
        found = ", ".join(repr(each[:SHOWN]) for each in words[:3])
        raise DataError(f"stage: {found}; needed: rows of a stage of shear; keep those, or run with path=shear")

    def _named(self, lines, sliding):
        """[(name, indices)] of the rows that a column `stage` or `segment` names; None without one."""
        k = self.known.get("stage", self.known.get("segment"))
        if k is None:
            return None
        cells = self.block.cells[k][lines]
        texts = [each if isinstance(each, str) else f"{each:g}" for each in cells]
        if unknown := [text for text in texts if _part_named(text) is None]:
            self.notes.append(f"Not used: {self.table.columns[k].name} = {unknown[0][:SHOWN]!r}.")
            return None
        parts, first = [], 0
        for text, group in groupby(texts):
            count = len(list(group))
            moves = not sliding or Stage(text).moves == "U_x"
            parts += [(_part_named(text), np.arange(first, first + count))] * moves
            first += count
        return parts

    def _timed(self, values):
        """Quantities over U_x in place of time."""
        if "time" not in values:
            if self.how.speed is not None:
                raise DataError(f"speed = {self.how.speed:g}: used with friction over time only; leave it out")
            return values
        time = values.pop("time")
        if np.any(np.diff(time) < 0.0):
            raise DataError("time goes back; keep one stroke, or sort the lines by time")
        self.units["U_x"] = "nm"
        return {"U_x": self._speed() * (time - time[0])} | values

    def _speed(self):
        """nm/s, as given; raises DataError with what the file says of it."""
        said = [f"{key} = {text}" for key, text in self.said.items() if re.search("speed|velocity|rate", key, re.I)]
        if self.how.speed is None:
            beside = f"; the file says {', '.join(said[:3])}" if said else ""
            raise DataError(f"friction over time needs the speed in nm/s{beside}", call={"speed": ...})
        if not 0.0 < self.how.speed < np.inf:
            raise DataError(f"speed = {self.how.speed}; allowed: above 0, in nm/s; give a number in that range")
        self.notes += [f"speed = {self.how.speed:g} nm/s as given; the file says {each}." for each in said]
        return self.how.speed


def _said(above):
    """{name: text} of the lines above the columns, as in Velocity = 240 or "speed": 1e-5."""
    found = (SAID.match(line) for line in above)
    pairs = [(match[1].strip(), match[2].strip()) for match in found if match and match[2].strip()]
    return dict(pairs[:MOST_SAID])


def _spring(said):
    """(stiffness, N/m, or None where its unit is unknown; "name = text") of a spring that a file names, "" for none."""
    for name, text in said.items():
        match = re.match(r"(\d[\d.]*(?:[eE][+-]?\d+)?)\s*(\S*)", text) if SPRING.search(name) else None
        if match:
            unit = match[2] or parted(name)[1] or ""
            return float(match[1]) * SPRINGS[unit] if unit in SPRINGS else None, f"{name} = {text}"
    return None, ""


def lever_in(table: Table, k: int) -> float | None:
    """The stiffness, N/m, that a file names of a lever whose deflection is in its k-th column, a height; else None."""
    own = plain(table.columns[k].name)
    return _spring(_said(table.above))[0] if own in (*NAMED["height"], *NAMED["position"]) else None


def quantity_of(role: str, kind: str) -> str:
    """What a column of that role is in a curve of that kind."""
    if role in ("height", "gap", "position") or (role == "displacement" and kind == "load"):
        return "delta"
    if role == "force":
        return "L" if kind == "load" else "F"
    return "U_x" if role == "displacement" else role.removesuffix("_bar")


def _sliding(stages):
    """The stages of a column that move U_x to and fro, in order."""
    words = dict.fromkeys(map(str, stages))
    return [each for each in words if Stage(each).kind in STAGES and Stage(each).moves == "U_x"]


def _part_named(text):
    """The name of a segment, from a cell; None for an unknown word."""
    kind = Stage(text).kind
    return OF_STAGE.get(kind, kind) if kind in STAGES else PART_OF.get(text.strip().lower())
