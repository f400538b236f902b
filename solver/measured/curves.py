"""Measured curves from text files: which column is what, in which unit, and which way it was measured."""

import re
from collections.abc import Mapping
from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from ..run.frame import STAGES, Stage
from ..scene import Scene
from ..surfaces import DataError
from ..text import counted
from .columns import Given, for_user, not_used
from .content import Source
from .instruments import read_block
from .measurement import CODES, FEWEST, Measurement, Recording, Segment, goes, part_named, parts_of, sliding
from .roles import KINDS, NEEDED, Roles
from .tables import SHOWN, Block, left_out
from .units import SIZES, parted

MOST_PULLS = 0.95  # of the points: a load that is negative at more is likely counted downwards
SAID = re.compile(r'[#%{\s"]*([^\W\d][^\d:="]{1,60}?)"?\s*[:=]\s*"?((?:[^",]|,(?=\d)){1,60})')
MOST_SAID = 100
SPRING = re.compile(r"spring[ _-]?const|force[ _-]?constant|lever.*stiffn|stiffn.*lever", re.I)
NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?![\d.])\s*(\S*)")
SPRINGS = SIZES["N/m"] | {"nN/nm": 1.0, "pN/nm": 1e-3}  # units of its stiffness
OF_LEVER = "above 0, N/m, of a load in N"
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

    `roles.NAMED` lists what headings may say. Other columns and incomplete rows are left out.

    Parameters: scene: gives w E and w, over which forces in N/m and areas in nm are taken; source: a path, text with
    line breaks, bytes, an open file, or a Block. kind: one of KINDS, where columns do not tell. columns: {"U_x",
    "delta", "time", "F", "L", "A": name or number of a column, None for none}. units: {the same: unit}, also "0.5 nN"
    for what 1 in the file is. sign: {"L": -1} turns a column. part: only from .. to, nm of U_x or delta, or in the
    unit of a force. deflection: stiffness of the lever, N/m: L over it is taken off delta. speed: nm/s, of friction
    over time. force: N/m per unit of the forces, with the width of the contact across the pull in it. channel: the
    number of a table or force curve, from 1 on, where there are several.
    Returns a Measurement of a friction curve in N/m or as F_bar, which `fit` takes; else a Recording, such as a loop.
    Raises TypeError for no Scene, and DataError, which shows the table and the call that reads the file.

    Example: `read_measurement(Scene(), "measured.csv").noise`
    """
    if not isinstance(scene, Scene):
        raise TypeError(f"scene = {scene!r:.60}: allowed: a Scene; the order is read_measurement(scene, source)")
    how = SimpleNamespace(speed=speed, force=force, kind=kind, columns=columns, units=units, part=part, sign=sign,
                          deflection=deflection, channel=channel)  # fmt: skip
    try:
        if kind is not None and kind not in KINDS:
            raise DataError(f"kind = {kind!r}: allowed: {', '.join(KINDS)}; give one of these")
        return _Reader(scene, source if isinstance(source, Block) else read_block(source, NEEDED, channel), how).read()
    except DataError as error:
        raise for_user(error, "read_measurement(scene, ", source, vars(how)) from None


class _Reader:
    """A Block on its way to a curve. how: the arguments; units: {quantity: unit}; notes: how it was read."""

    def __init__(self, scene, block, how):
        self.scene, self.block, self.how, self.table = scene, block, how, block.table
        found = (SAID.match(line) for line in block.table.above)
        said = [(match[1].strip(), match[2].strip()) for match in found if match and match[2].strip()]
        self.said = dict(said[:MOST_SAID])
        how.kind = how.kind or block.kind or None
        self.roles = Roles(block.table, how)
        self.stages = self._stages()
        self.slides = sliding(self.stages) if self.stages is not None else []
        self.kind = self.roles.find(None if self.stages is None else bool(self.slides))
        self.units = {name: unit for name, (_, unit) in self.roles.scaled.items()}
        self.notes = self.roles.notes

    def read(self):
        """The Measurement or Recording."""
        values, lines = self._values()
        values = self._changing(self._turned(self._timed(values)))
        over = next(iter(values))
        kept = self._part(over, values[over])
        lines, values = lines[kept], {name: column[kept] for name, column in values.items()}
        if self.kind == "friction":
            return self._friction(lines, values)
        if over == "delta":
            parts = self._named(lines, values[over]) or parts_of(values[over], "approach", "retract")
            return self._recording("load", parts, values, self.roles.heading(over) != over)
        if over == "U_x":
            parts = self._named(lines, values[over]) or parts_of(values[over], "forth", "back")
            return self._recording("area over displacement", parts, values)
        return self._recording(f"area over {'load' if over == 'L' else 'force'}", [("", slice(None))], values)

    def _values(self):
        """({quantity: (k,)} of complete rows in `units`, numbers of their lines (k,)). Raises DataError."""
        of, scaled = self.roles.of, self.roles.scaled
        values = np.column_stack([self.block.numbers(name, k) * scaled[name][0] for name, k in of.items()])
        slides = self.slides if self.kind == "friction" else []
        meant = np.isin(self.stages, slides) if slides else np.ones(len(values), bool)
        complete = np.isfinite(values).all(axis=1)
        self.notes += left_out(self.block.lines[meant & ~complete])
        rows = np.flatnonzero(meant & complete)
        if not rows.size:
            raise DataError(f"no row has numbers in all of {', '.join(of)}; needed: {NEEDED}")
        if self.stages is None:
            beside = [self.roles.known[role] for role in (*self.roles.noted, "segment") if role in self.roles.known]
            self.notes += not_used(self.block, [*of.values(), *beside])
        self.notes += self.block.notes
        return dict(zip(of, values[rows].T, strict=True)), rows

    def _changing(self, values):
        """The quantities without those that are 0 throughout, as a column that was not measured."""
        _, main, *others = values
        if not np.any(values[main]):
            raise DataError(f"{main} is 0 at every point; needed: a {main} that changes; check the column")
        still = [name for name in others if not np.any(values[name])]
        self.notes += [f"{name} is 0 at every point: not used." for name in still]
        return {name: column for name, column in values.items() if name not in still}

    def _timed(self, values):
        """Quantities over U_x in place of time."""
        speed = self.how.speed
        if "time" not in values:
            if speed is not None:
                raise DataError(f"speed = {speed:g}: used with friction over time only; leave it out")
            return values
        time = values.pop("time")
        if np.any(np.diff(time) < 0.0):
            raise DataError("time goes back; keep one stroke, with its lines in order of time")
        said = [f"{key} = {text}" for key, text in self.said.items() if re.search("speed|velocity|rate", key, re.I)]
        if speed is None:
            beside = f"; the file says {', '.join(said[:3])}" if said else ""
            raise DataError(f"friction over time needs the speed in nm/s{beside}", call={"speed": ...})
        if not 0.0 < speed < np.inf:
            raise DataError(f"speed = {speed}; allowed: above 0, in nm/s; give a number in that range")
        self.notes += [f"speed = {speed:g} nm/s as given; the file says {each}." for each in said]
        self.units["U_x"] = "nm"
        return {"U_x": speed * (time - time[0])} | values

    def _turned(self, values):
        """The quantities with their signs, without the deflection of the lever; asks for a sign that may be wrong."""
        sign = dict(self.how.sign or {})
        for name, by in sign.items():
            if name not in values or by not in (1, -1):
                raise DataError(f"sign has {name!r}: {by!r}; allowed: 1 or -1 of {', '.join(values)}; give such a sign")
            values[name] = by * values[name]
        if self.kind == "load":
            self._approaching(values, sign)
            self._without_lever(values)
        elif self.how.deflection is not None:
            raise DataError(f"deflection = {self.how.deflection!r}: allowed: {OF_LEVER}; leave it out, or give units")
        elif "L" in values and "L" not in sign and self.stages is None and (values["L"] < 0.0).mean() > MOST_PULLS:
            raise self._asked_sign({"L": ...}, f"L is negative: {PULL}")
        return values

    def _approaching(self, values, sign):
        """Gives delta the sign with which it grows as the surfaces approach; asks where it may be either."""
        delta, L, role, own = values["delta"], values["L"], self.roles.role["delta"], self.roles.heading("delta")
        if role in ("height", "gap") and "delta" not in sign:
            delta = values["delta"] = -delta
        if role == "position" and "delta" not in sign:
            name = repr(self.table.columns[self.roles.of["delta"]].name[:SHOWN])
            likely = -1 if delta[np.argmax(L)] < delta[0] else 1
            raise self._asked_sign({"delta": likely}, f"does {name} grow (1) or fall (-1) to contact?")
        if self.stages is not None:  # of a run of this package
            return
        deep, edge = np.argsort(delta), max(1, delta.size // 20)
        falls = np.median(L[deep[-edge:]]) < np.median(L[deep[:edge]])
        unsure = own not in ("delta", "height", "gap")
        if "L" not in sign and (falls or (unsure and -L.min() > L.max())):
            either = {} if own == "delta" or "delta" in sign else {"delta": ...}
            why = "falls as the surfaces approach" if falls else "is negative where it is largest"
            raise self._asked_sign({"L": ...} | either, f"L {why}: {PULL}{DEPTH * bool(either)}")

    def _without_lever(self, values):
        """Takes the deflection of a lever of given stiffness off delta, or notes the stiffness that the file says."""
        k, (stiffness, said) = self.how.deflection, self._lever()
        if k is None:
            value = f"={stiffness:g}" if stiffness else ""
            self.notes += [f"The file says {said}: the lever is in delta; deflection{value} takes it off."] * bool(said)
            return
        if self.roles.heading("delta") == "gap":
            raise DataError(f"deflection = {k!r}, but a separation has no lever in it; leave it out")
        if self.units["L"] != "N" or not k > 0.0:
            raise DataError(f"deflection = {k!r}: allowed: {OF_LEVER}; leave it out, or give units")
        values["delta"] = values["delta"] - 1e9 * values["L"] / k
        whose = "as the file says" if k == stiffness else f"as given; the file says {said}"
        self.notes += [f"deflection = {k:g} N/m, {whose}."] * bool(said)

    def _lever(self):
        """(stiffness, N/m, or None; how the file says it, or "") of a lever whose deflection may be in delta."""
        unknown = ""
        if self.kind == "load" and self.units["L"] == "N" and self.roles.heading("delta") not in ("delta", "gap"):
            for name, text in self.said.items():
                match = NUMBER.match(text) if SPRING.search(name) else None
                unit = match and (match[2] or parted(name)[1] or "")
                if unit in SPRINGS:
                    return float(match[1]) * SPRINGS[unit], f"{name} = {text}"
                unknown = unknown or (f"{name} = {text}" if match else "")
        return None, unknown

    def _asked_sign(self, sign, reason):
        k, said = self._lever() if self.how.deflection is None else (None, "")
        beside = f" The file says {said}: deflection takes the lever off." if said else ""
        call = {"sign": sign} | ({"deflection": k} if k else {})
        return DataError(f"{reason}{beside} {self.table}", table=self.table, call=call)

    def _part(self, name, x):
        """Which points (k,) of x (k,) are in the part that is asked for."""
        if self.how.part is None:
            return slice(None)
        start, end = map(float, self.how.part)
        inside = (x >= start) & (x <= end)
        count = int(inside.sum())
        if count < FEWEST:
            found = f"{counted(count, 'point')} of {x.min():.6g} .. {x.max():.6g} {self.units[name]}"
            raise DataError(f"part = {self.how.part}: {found}; give a part of that")
        self.notes.append(f"{count} of {x.size} points are used, from {start:g} to {end:g}.")
        return inside

    def _friction(self, lines, values):
        """Friction over U_x: one stroke, or a loop."""
        parts = self._named(lines, values["U_x"]) or parts_of(values["U_x"], "forth", "back")
        strokes = [part for part in parts if part[0] != "hold"]
        if self.how.kind == "loop" or (len(strokes) > 1 and self.how.kind is None):
            return self._recording("loop", parts, values)
        if len(strokes) > 1:
            raise DataError(f"U_x goes to and fro in {len(strokes)} strokes", call={"kind": "loop"})
        name, at = strokes[0]
        if name == "back":
            reason = "U_x falls from first to last; turn the signs of U_x and F, or sort the lines"
            raise DataError(reason, call={"sign": {"U_x": -1, "F": -1}})
        held = values["U_x"].size - at.size
        self.notes += [f"a hold of {counted(held, 'point')} was left out."] * (held > 0)
        return self._stroke({key: column[at] for key, column in values.items()})

    def _stroke(self, values):
        """A Measurement of one stroke; a Recording where the force is not in N/m."""
        back = int((np.diff(values["U_x"]) < 0.0).sum())
        if back > values["U_x"].size // 3:
            raise DataError("U_x goes to and fro; sort the lines by U_x")
        self.notes += [f"U_x goes back at {counted(back, 'point')}: put in order."] * (back > 0)
        order = np.argsort(values["U_x"], kind="stable")
        values = {name: column[order] for name, column in values.items()}
        if not {self.units[name] for name in values} <= {"nm", "N/m", "w E", "w"}:
            return self._recording("friction", [("forth", slice(None))], values)
        over = {"N/m": self.scene.width * self.scene.E, "nm": self.scene.width}
        bars = {f"{name}_bar": values[name] / over.get(self.units[name], 1.0) for name in "FLA" if name in values}
        unit, width = (over[own] if self.units.get(name) == own else None for name, own in (("F", "N/m"), ("A", "nm")))
        return Measurement.of(values["U_x"], bars, None, unit, tuple(self.notes), width, self.said)

    def _recording(self, kind, parts, values, free=False):
        """The Recording of parts of columns, over the first of them."""
        (over, x), *others = values.items()
        if x.size < FEWEST:
            raise DataError(f"points: {x.size}; needed: {FEWEST} or more; measure more densely")
        segments = tuple(Segment(name, x[at], {key: y[at] for key, y in others}) for name, at in parts)
        lever = self._lever()[0] if self.roles.heading(over) in ("height", "position") else None
        units, notes = {name: self.units[name] for name in values}, tuple(dict.fromkeys(self.notes))
        return Recording(kind, segments, units, free, self.said, notes, lever)

    def _stages(self):
        """The column `stage`, as a run writes it; None without one. Raises DataError for one of other words."""
        known = self.roles.known
        if "stage" not in known:
            return None
        stages = self.block.cells[known["stage"]]
        words = list(dict.fromkeys(map(str, stages)))
        of_run = all(Stage(each).kind in STAGES for each in words)
        if of_run and (sliding(stages) or {"delta", "L"} <= known.keys()):
            return stages
        found = ", ".join(repr(each[:SHOWN]) for each in words[:3])
        raise DataError(f"stage: {found}; needed: rows of a stage of shear; keep those, or run with path=shear")

    def _named(self, lines, x):
        """[(name, indices)] of the rows that a column `stage` or `segment` names; None without one.

        Numbers are names only where x goes that way: other machines count cycles, or begin with 1.
        """
        k = self.roles.known.get("stage", self.roles.known.get("segment"))
        if k is None:
            return None
        texts = [each if isinstance(each, str) else f"{each:g}" for each in self.block.cells[k][lines]]
        if unknown := [text for text in texts if part_named(text) is None]:
            self.notes.append(f"Not used: {self.table.columns[k].name} = {unknown[0][:SHOWN]!r}.")
            return None
        changes = [j for j, pair in enumerate(pairwise(texts), 1) if pair[0] != pair[1]]
        parts = [(part_named(texts[at[0]]), at) for at in np.split(np.arange(len(texts)), changes)]
        if texts[0].lower() in CODES and not all(goes(name, x, at) for name, at in parts):
            column = self.table.columns[k].name
            self.notes.append(
                f"Not used: the numbers of {column}; the turns of {next(iter(self.roles.of))} part the curve."
            )
            return None
        return parts
