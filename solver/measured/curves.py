"""Measured curves from text files: which column is what, in which unit, and which way it was measured."""

import re
from dataclasses import replace
from itertools import groupby

import numpy as np

from ..run.frame import STAGES, Stage
from ..scene import Scene
from ..surfaces import DataError
from ..text import UNITS, counted
from .measurement import Measurement
from .recording import FEWEST, Recording, Segment, parts_of
from .tables import LISTED, SHOWN, Column, Source, listed, read_table
from .units import FACTORS

NEEDED = "U_x (nm) and F (N/m), or F_bar; time and F; delta and L; F and A; U_x and A"
# What a heading may say in place of a name, in small letters without blanks and signs
NAMED = {
    "U_x": ("ux", "displacement", "tangentialdisplacement", "lateraldisplacement", "slidingdistance", "shift"),
    "F_bar": ("fbar",),
    "F": ("fx", "ff", "friction", "frictionforce", "tangentialforce", "lateralforce", "shearforce"),
    "force": ("f", "force"),  # F beside U_x, time or an area; L beside a height
    "L_bar": ("lbar",),
    "L": ("l", "fz", "fn", "load", "normalload", "normalforce", "tb", "deflection", "verticaldeflection"),
    "A_bar": ("abar",),
    "A": ("a", "area", "contactarea", "realcontactarea"),
    "delta": ("delta", "indentation", "indentationdepth", "depth", "penetration"),
    "height": ("height", "gap", "separation", "tipsampleseparation"),  # falls as delta grows
    "position": ("z", "zsense", "zsensor", "zposition", "piezo", "position", "normaldisplacement"),  # either way
    "time": ("time", "t", "times", "elapsedtime"),
    "stage": ("stage",),
    "segment": ("segment", "phase"),
}
PARTS = {  # words for a segment, in a cell or before the name of a column
    "approach": ("approach", "extend", "loading", "false", "0"),
    "retract": ("retract", "withdraw", "unloading", "true", "1"),
    "hold": ("hold", "pause", "dwell", "intermediate", "2"),
    "forth": ("forth", "trace", "forward"),
    "back": ("back", "retrace", "backward"),
}
PART_OF = {word: part for part, words in PARTS.items() for word in words}
OF_STAGE = {"unload": "retract", "reload": "approach", "shear": "forth", "move": "forth"}  # others keep their name
NEWTONS = {"kN": 1e3, "N": 1.0, "mN": 1e-3, "µN": 1e-6, "uN": 1e-6, "nN": 1e-9, "pN": 1e-12, "g": 9.80665e-3}
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "seconds": 1.0, "ms": 1e-3, "min": 60.0, "h": 3600.0}
WHICH = ("measured", "piezo", "smoothed", "sensor")  # in brackets behind a name, and no unit
SAID = re.compile(r'[#%{\s"]*([^\W\d][^\d:="]{1,60}?)"?\s*[:=]\s*"?([^",]{1,60})')
SPEED = re.compile(r"([\d.]+(?:[eE][-+]?\d+)?)\s*(?:(nm|um|µm|mm|cm|m)/s(?:ec)?)?\s*$")
SPEED_UNIT = re.compile(r"\b(nm|um|µm|mm|cm|m)/s")
LENGTHS = UNITS["nm"] | {unit: FACTORS[unit] for unit in ("micron", "cm")}
GLUED = re.compile(r"^(time)-?\d[\d.e+-]*$", re.I)  # the last name of a heading, which afmformats once left without end
MOST_SAID = 100


def read_measurement(
    scene: Scene, source: Source, speed: float | None = None, force: float | None = None
) -> Measurement | Recording:
    """Reads a measured curve from a text file with a heading: friction over U_x or time, a loop, a load, an area.

    NAMED lists what headings may say, UNITS and NEWTONS the units that are converted, as in U_x (um). Other columns and
    incomplete rows are left out. Of a file of a run the column `stage` names the segments; one stage of shear is a
    friction curve. L counts beside F, and L_bar beside F_bar, because w E may be a free parameter.

    Parameters: scene: gives w E and w, over which forces in N/m and areas in nm are taken; source: a path, or the
    content of a file: text with line breaks, bytes, or an open file; speed: nm/s, of friction over time, where the file
    does not say it; force: N/m per unit of forces in N or V: the width of the contact across the pull is in it.
    Returns a Measurement of a friction curve in N/m or as F_bar, which `fit` takes, its noise estimated; else a
    Recording, a loop in N/m among them.
    Raises DataError, and TypeError for a scene that is none.

    Example: `read_measurement(Scene(), "measured.csv").noise`
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene = {scene!r:.60}: allowed: a Scene; the order is read_measurement(scene, source)")
    table = read_table(source, NEEDED, lambda columns: bool(_kind(_sides(columns)[0][1])))
    return _Reader(scene, table, speed, force).read()


class _Reader:
    """A Table on its way to a curve: `units` of its columns, and `notes` on how they were read."""

    def __init__(self, scene, table, speed, force):
        self.scene, self.table, self.speed, self.force = scene, table, speed, force
        self.said = _said(table.above)
        self.notes = [f"line {table.end} begins another table: left out."] * bool(table.end)
        glued = [column.name[:SHOWN] for column in table.columns if GLUED.search(column.name)]
        self.notes += [f"the first row stands in the heading, behind {name!r}: left out." for name in glued]
        self.units: dict[str, str] = {}
        self.assumed: dict[str, str] = {}  # units of columns that name none

    def read(self):
        """The Measurement or Recording."""
        sides = _sides(self.table.columns)
        of = sides[0][1]
        self.stages = self._stages(of)
        kind = _kind(of) if self.stages is None or _sliding(self.stages) else "load"
        taken = [(side, self._taken(roles, kind)) for side, roles in sides]
        used = {index for _, columns in taken for _, index in columns.values()}
        used |= {of[role] for role in ("stage", "segment", "L", "L_bar") if role in of}
        names = [column.name for k, column in enumerate(self.table.columns) if k not in used]
        unused = [name for name in names if name[:1].isalpha()]
        # in the file of a run they are
        self.notes += [f"not used: {listed(unused)}."] * bool(unused and not {"residual", "evaluations"} <= set(unused))
        if self.speed is not None and kind != "time":
            raise DataError(f"speed = {self.speed:g}: used with friction over time only; leave it out")
        read = {"friction": self._friction, "time": self._friction, "load": self._load, "area": self._area}
        return read[kind](taken)

    def _taken(self, of, kind):
        """{"U_x", "delta", "time", "F", "L" or "A": (role, index)} of the columns that a curve of that kind takes."""
        force = next((role for role in ("F_bar", "F", "force") if role in of), None)
        area = next((role for role in ("A", "A_bar") if role in of), None)
        load = next((role for role in ("L", "L_bar") if role in of), None)
        if kind == "load":
            across = next(role for role in ("delta", "height", "position", "U_x") if role in of)
            names = {"delta": across, "L": load or force}
        elif kind == "area":
            over = {"U_x": "U_x"} if "U_x" in of else {"F": force} if force else {"L": load}
            names = over | {"A": area}
        else:
            own, other = ("L_bar", "L") if force == "F_bar" else ("L", "L_bar")
            if other in of and own not in of:
                self.notes.append(
                    f"{other} is left out beside {force.replace('force', 'F')}; give {own}: w E may be free."
                )
            names = {"U_x" if kind == "friction" else "time": "U_x" if kind == "friction" else "time", "F": force}
            names |= {"L": own if own in of else None, "A": area}
        return {name: (role, of[role]) for name, role in names.items() if role}

    def _friction(self, taken):
        """Friction over U_x, or over time at a speed: one stroke, or a loop."""
        ((_, columns),) = taken
        slides = _sliding(self.stages) if self.stages is not None else []
        lines, values = self._values(columns, slides[0] if len(slides) == 1 else None)
        if "time" in values:
            time = values.pop("time")
            if np.any(np.diff(time) < 0.0):
                raise DataError("time goes back; keep one stroke, or sort the lines by time")
            values = {"U_x": self._speed() * (time - time[0])} | values
        if len(slides) == 1:
            return self._stroke(values)
        parts = self._named(lines, bool(slides)) or parts_of(values["U_x"], "forth", "back")
        strokes = [part for part in parts if part[0] != "hold"]
        if len(strokes) > 1:
            return self._recording("loop", "U_x", parts, values)
        name, at = strokes[0]
        if name == "back":
            raise DataError("U_x falls from first to last; turn the signs of U_x and F, or sort the lines")
        held = values["U_x"].size - at.size
        self.notes += [f"a hold of {counted(held, 'point')} was left out."] * (held > 0)
        return self._stroke({key: column[at] for key, column in values.items()})

    def _load(self, taken):
        """Load over approach, and retraction."""
        across, parts, size, sides = taken[0][1]["delta"][0], [], 0, []
        for side, columns in taken:
            lines, values = self._values(columns)
            values["delta"] *= _downwards(across, values, side)
            own = self._named(lines, False) or ([(side, np.arange(lines.size))] if side else None)
            parts += [(name, at + size) for name, at in own or parts_of(values["delta"], "approach", "retract")]
            size += lines.size
            sides.append(values)
        values = {name: np.concatenate([each[name] for each in sides]) for name in ("delta", "L")}
        return self._recording("load", "delta", parts, values, across != "delta")

    def _area(self, taken):
        """Area over U_x; or over a force: F, or L where there is no other."""
        ((_, columns),) = taken
        lines, values = self._values(columns)
        over = next(name for name in ("U_x", "F", "L") if name in columns)
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
        return Measurement.of(U_x, bars, None, unit, self._notes(), width, self.said)

    def _recording(self, kind, over, parts, values, free=False):
        """The Recording of parts of columns, over one of them."""
        if values[over].size < FEWEST:
            raise DataError(f"points: {values[over].size}; needed: {FEWEST} or more; measure more densely")
        others = [name for name in values if name != over]
        segments = [Segment(name, values[over][at], {key: values[key][at] for key in others}) for name, at in parts]
        units = {name: self.units[name] for name in values}
        return Recording(kind, tuple(segments), units, free, self.said, self._notes())

    def _notes(self):
        assumed = " and ".join(f"{name} as {unit}" for name, unit in self.assumed.items())
        unknown = [f"no unit found: {assumed} read; if that is wrong, write it in the heading."] if assumed else []
        return tuple(dict.fromkeys([*self.notes, *unknown]))

    def _values(self, columns, stage=None):
        """(numbers of lines (k,), {name: column (k,) in its unit}) of complete rows, of one stage if given."""
        factors = {name: self._factor(name, role, self.table.columns[k]) for name, (role, k) in columns.items()}
        rows = self.stages == stage if stage is not None else slice(None)
        table = replace(self.table, cells=self.table.cells[rows])
        lines, values, left_out = table.numbers({name: k for name, (_, k) in columns.items()})
        if not lines.size:
            raise DataError(f"no row has numbers in all of {', '.join(columns)}; needed: {NEEDED}")
        self.notes += left_out
        self.units.setdefault("U_x", "nm")
        return lines, {name: values[name] * factors[name] for name in columns}

    def _stages(self, of):
        """The column `stage`, as a run writes it; None without one. Raises DataError for one of other words."""
        if "stage" not in of:
            return None
        stages = self.table.cells[of["stage"]]
        known = all(Stage(each).kind in STAGES for each in stages.unique())
        if known and (_sliding(stages) or {"delta", "L"} <= of.keys()):
            return stages
        found = ", ".join(repr(each[:SHOWN]) for each in list(stages.unique())[:LISTED])
        raise DataError(f"stage: {found}; needed: rows of a stage of shear; keep those, or run with path=shear")

    def _named(self, lines, sliding):
        """[(name, indices)] of the rows that a column `stage` or `segment` names; None without one."""
        roles = {_role(column): k for k, column in reversed(list(enumerate(self.table.columns)))}
        k = roles.get("stage", roles.get("segment"))
        if k is None:
            return None
        texts = list(self.table.cells.loc[lines, k])
        if unknown := [text for text in texts if _part(text) is None]:
            self.notes.append(f"not used: {self.table.columns[k].name} = {unknown[0][:SHOWN]!r}.")
            return None
        parts, first = [], 0
        for text, group in groupby(texts):
            count = len(list(group))
            moves = not sliding or Stage(text).moves == "U_x"
            parts += [(_part(text), np.arange(first, first + count))] * moves
            first += count
        return parts

    def _speed(self):
        """nm/s, given or said in the file; raises DataError."""
        said = {key: value for key, value in self.said.items() if re.search("speed|velocity|rate", key, re.I)}
        if self.speed is not None:
            if not 0.0 < self.speed < np.inf:
                raise DataError(f"speed = {self.speed}; allowed: above 0, in nm/s; give a number in that range")
            self.notes += [f"speed = {self.speed:g} nm/s as given; the file says {key} = {said[key]}." for key in said]
            return self.speed
        for key, value in said.items():
            if (number := SPEED.match(value)) and (unit := number[2] or SPEED_UNIT.search(key)):
                self.notes.append(f"speed: {key} = {value}.")
                return float(number[1]) * FACTORS[unit if isinstance(unit, str) else unit[1]]
        found = "; ".join(f"the file says {key} = {value}, without a unit" for key, value in said.items())
        raise DataError(f"friction over time needs a speed{': ' + found if found else ''}; give speed= (nm/s)")

    def _factor(self, name, role, column):
        """What numbers of a column are multiplied by; its unit is then that in `units`."""
        unit = "" if column.unit in WHICH else column.unit
        si = "afmformats" in self.table.above  # writes m and N, and names neither
        if role.endswith("_bar"):
            self.units[name], allowed = "w" if name == "A" else "w E", {"": 1.0}
        elif name == "time":
            allowed = SECONDS
        elif name in "FL":
            return self._force_factor(name, column.name, "N" if si and not unit else unit)
        else:
            self.units[name] = "A_0" if unit == "A_0" else "nm"
            allowed = LENGTHS | ({"A_0": 1.0} if name == "A" else {})
            unit = "m" if si and not unit else unit
            if not unit:
                self.assumed[name] = "nm"
                return 1.0
        if unit in allowed:
            return allowed[unit]
        surface = name == "A" and re.search("[²2]", unit)
        remedy = "divide it by its value without shear, and write A/A_0" if surface else "correct it"
        raise DataError(_unknown(column.name, unit, allowed, f"{remedy} in the heading"))

    def _force_factor(self, name, heading, unit):
        """As `_factor`, of a force."""
        per_width, self.units[name] = UNITS["N/m"], "N/m"
        if (unit in per_width or unit == "F_s") and self.force is not None:
            raise DataError(f"force = {self.force:g}, but {heading} is in {unit}; leave force out")
        if self.force is not None:
            return self.force
        if unit == "F_s":
            self.units[name] = unit
            return 1.0
        if not unit:
            self.assumed[name] = "N/m"
            return 1.0
        if unit in per_width:
            return per_width[unit]
        self.units[name] = "N"
        if unit in NEWTONS:
            return NEWTONS[unit]
        gain, spring = (self._number(key) for key in ("gain, mv/nm", "force constant, nn/nm"))
        if unit == "V" and gain and spring:
            self.notes.append(f"{heading} in V: over a gain of {gain:g} mV/nm, times {spring:g} N/m.")
            return 1e3 / gain * spring * 1e-9
        remedy = "give force= (N/m per unit), or correct it in the heading"
        raise DataError(_unknown(heading, unit, per_width | NEWTONS, remedy))

    def _number(self, key):
        """A number that the file says above its columns, by the end of its name; None without."""
        text = next((value for name, value in self.said.items() if name.lower().endswith(key)), "")
        return float(text) if re.fullmatch(r"[\d.]+(?:[eE][-+]?\d+)?", text) else None


def _downwards(across, values, side):
    """1, or -1 where a coordinate falls as the surfaces approach: a height, or what falls up to the largest load."""
    if across != "position":
        return -1.0 if across == "height" else 1.0
    delta = values["delta"]
    far = delta[-1] if side == "retract" else delta[0]
    return -1.0 if delta[np.argmax(values["L"])] < far else 1.0


def _said(above):
    """{name: text} of the lines above the columns, as in Velocity = 240 or "speed": 1e-5."""
    found = (SAID.match(line) for line in above.split("\n"))
    pairs = [(match[1].strip(), match[2].strip()) for match in found if match and match[2].strip()]
    return dict(pairs[:MOST_SAID])


def _sides(columns):
    """[(name of a segment or "", {role: index})]: two where headings name segments side by side."""
    sides: dict[str, dict[str, int]] = {}
    for k, column in enumerate(columns):
        first, _, rest = column.name.lower().partition(" ")
        side = PART_OF.get(first, "") if rest else ""
        role = _role(Column(rest if side else column.name, column.unit))
        if role:
            sides.setdefault(side, {}).setdefault(role, k)
    plain = sides.pop("", {})
    named = [(side, plain | of) for side, of in sides.items() if _kind(plain | of)]
    return named or [("", plain)]


def _role(column):
    plain = re.sub(r"[\W_]", "", GLUED.sub(r"\1", column.name.lower()))
    return next((role for role, words in NAMED.items() if plain in words), None)


def _kind(of):
    """The kind of a curve with columns of these roles; None for none."""
    tangential = {"F", "F_bar"} & of.keys()
    if "U_x" in of and (tangential or "force" in of):
        return "friction"
    deep = {"delta", "height", "position"} & of.keys()
    if (deep and {"L", "L_bar", "force"} & of.keys() and not tangential) or ("U_x" in of and "L" in of):
        return "load"
    if "time" in of and (tangential or "force" in of):
        return "time"
    if {"A", "A_bar"} & of.keys() and {"U_x", "F", "force", "L", "F_bar", "L_bar"} & of.keys():
        return "area"
    return None


def _sliding(stages):
    """The stages of a column that move U_x to and fro, in order."""
    return [each for each in stages.unique() if Stage(each).kind in STAGES and Stage(each).moves == "U_x"]


def _part(text):
    """The name of a segment, from a cell; None for an unknown word."""
    kind = Stage(text).kind
    return OF_STAGE.get(kind, kind) if kind in STAGES else PART_OF.get(text.strip().lower())


def _unknown(name, unit, allowed, remedy):
    units = ", ".join(filter(None, allowed)) or "none"
    return f"heading: {name} in {unit[:SHOWN]!r}; allowed units: {units}; {remedy}"
