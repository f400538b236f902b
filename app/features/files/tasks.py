"""Reads the file of a visitor as it is chosen, for workers."""

import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from app.features.files.comparing import Curve, curve_of, rounded
from app.service import worker
from app.service.tasks import MEMORY
from solver import DataError, Profile, Scene, read_profile
from solver.measured import profile, roles
from solver.measured.columns import recognised
from solver.measured.curves import read_measurement
from solver.measured.instruments import is_force_curve, is_instruments, read_block
from solver.measured.periodic import proposed
from solver.measured.tables import Block
from solver.measured.units import LENGTH, named_unit, units_above, usual

NEEDED = "columns of numbers: x and z of a surface, or two quantities of a curve"
SURFACE = "surface"
KINDS = {  # {kind: its name in the menu}
    SURFACE: "surface profile",
    "friction": "friction, one pull",
    "loop": "friction loop, forth and back",
    "load": "load over approach",
    "area": "contact area",
}
SIDES = {"": ((), ()), SURFACE: (("x",), ("z",)), **roles.SIDES, "loop": roles.SIDES["friction"]}
BESIDE = dict.fromkeys(("friction", "loop"), ("L", "A"))  # read where they are there
UNITS = {role: usual(of) for role, of in {"x": LENGTH, "z": LENGTH, **roles.UNITS_OF}.items()}
ROLES = tuple(UNITS)
DRAWN = 400  # points of a drawing
FAR = 60.0  # nm: of a longer load, which no run covers, the part from the contact on is proposed
LEFT, STEADY = 6.0, 5  # scatters by which a load has left its line, for so many points
LINE, CUT_OFF = {"line": "line of a map, such as row 12 or column 12"}, {"cut_off": "remove waves shorter than (nm)"}
UNIT = {"unit": f"unit of lengths: {', '.join(UNITS['x'])}"}
IN_WORDS = {  # how a refusal calls an argument: how the page calls it
    r"\bunits\['(\w+)'\]": r"the unit of \1",
    r"\bcolumns\['(\w+)'\]": r"the column of \1",
    r'\bunits=\{"(\w+)": ("[^"]*")\}': r"\2 of \1",
    r"\bunit='([^']*)'": r"\1",
}


@dataclass(frozen=True, eq=False)
class Chosen:
    """What a visitor has chosen of a file.

    columns: {quantity: index of a column}; part: (from, to), fractions of the whole; channel: a number from 1 on,
    or "all"; deflection: 0 for none, None for what the file names.
    """

    kind: str = ""
    columns: dict[str, int] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    sign: dict[str, float] = field(default_factory=dict)
    part: tuple[float, float] | None = None
    cut_off: float | None = None
    channel: str | None = None
    speed: float | None = None
    deflection: float | None = None
    line: str | None = None
    spacing: str | None = None
    unit: str | None = None


def look(scene: Scene, content: bytes, chosen: Chosen) -> tuple[dict[str, Any], Profile | Curve | None]:
    """Return (what the page shows of a file, the Profile or Curve that is used, or None while something is missing).

    The first has kind, kinds, known (units of the quantities of a kind), columns, units, signs, table, drawn, part,
    fields, `says` (what would be used) and `why` (what is missing).
    """
    seen: dict[str, Any] = {"kinds": KINDS, "kind": chosen.kind, "says": "", "why": "", "fields": {}}
    try:
        with worker.bounded_memory(MEMORY):
            if is_instruments(content) and not is_force_curve(content):
                seen |= {"kind": SURFACE, "kinds": {SURFACE: KINDS[SURFACE]}}
                seen["fields"] = LINE | CUT_OFF | (UNIT if chosen.unit else {})
                how = {"unit": chosen.unit, "channel": chosen.channel, "line": chosen.line}
                return seen, _surface(scene, content, how, chosen, seen)
            return seen, _of_table(scene, read_block(content, NEEDED, chosen.channel), chosen, seen)
    except DataError as error:
        other = KINDS.get(f"{error.call.get('kind')}", "")  # which the reader is certain of
        remedy = f"; choose the kind {other!r}" if other and error.call["kind"] != seen["kind"] else ""
        seen |= {"why": f"{_without_table(error)}{remedy}", "cut_off": getattr(error, "cut_off", None)}
        seen |= {"channels": error.choices} if error.choices else {}
        seen["fields"] |= UNIT if error.call.get("unit") is ... else {}
        seen["asked"] = list(error.call.get("sign", {}))
    except MemoryError:
        seen["why"] = "reading it takes too much memory; thin it out, or export it as CSV"
    return seen, None


def _without_table(error):
    """The reason of a DataError in words of the page, which shows the table itself."""
    text = error.brief
    for python, words in IN_WORDS.items():
        text = re.sub(python, words, text)
    return re.sub(f";? {re.escape(str(error.table))}", "", text) if error.table is not None else text


def _of_table(scene, block, chosen, seen):
    """Read a Block; fills `seen`."""
    table = block.table
    kind = chosen.kind or block.kind or _kind(table, chosen.columns)
    meant = [role for side in SIDES[kind] for role in side] + [*BESIDE.get(kind, ())] if kind else ROLES
    columns = {role: k for role, k in chosen.columns.items() if role in meant and 0 <= k < len(table.columns)}
    if not chosen.columns and kind == SURFACE:
        columns = profile.named(table) or ({"z": 0} if len(table.columns) == 1 else {})
    elif not chosen.columns and kind:
        columns = roles.proposed(table, kind)[1]
    above = units_above(table.above) if kind == SURFACE else {}
    units = {role: table.columns[k].unit or above.get(role) or "" for role, k in columns.items()} | chosen.units
    seen |= {"kind": kind, "known": {role: UNITS[role] for role in meant}, "columns": columns, "units": units}
    seen |= {"table": table.to_json(), "drawn": _raw(block, columns, kind)}
    if not kind:
        raise DataError("choose what kind of data this is")
    counted = kind == SURFACE and "z" in columns and "x" not in columns
    if counted:
        seen["fields"] = {"spacing": "distance of the rows, such as 0.5 um, where no column is x"}
    missing = [" or ".join(side) for side in SIDES[kind] if not set(side) & columns.keys()]
    if missing and not (counted and chosen.spacing):
        raise DataError(f"choose the column of {' and of '.join(missing)}")
    if kind != SURFACE:
        return _curve(scene, block, columns, chosen, seen)
    own = {role: unit for role, unit in chosen.units.items() if role in ("x", "z")}
    how = {"columns": {"x": None} | {role: k + 1 for role, k in columns.items()}}
    how["units"] = own | ({"x": chosen.spacing} if counted else {})
    return _surface(scene, block, how, chosen, seen)


def _kind(table, columns):
    """The kind of a table, where names or the chosen columns {role: index} tell it for certain; else ""."""
    if columns:
        complete = (kind for kind, sides in SIDES.items() if kind and all({*side} & {*columns} for side in sides))
        return next(complete, "")
    found, named = roles.proposed(table)[0], any(column.name for column in table.columns)
    profiled = named and {"x", "z"} <= profile.named(table).keys()
    return "" if found and profiled else SURFACE if profiled else found


def _raw(block: Block, columns, kind):
    """A drawing of the chosen columns in the numbers of the file, else of the first two of numbers."""
    numbers = [k for k, cells in enumerate(block.cells) if cells.dtype != object]
    chosen = [next(columns[role] for role in side if role in columns) for side in SIDES[kind] if {*side} & {*columns}]
    drawn = chosen if len(chosen) == 2 else numbers[:2]
    if len(drawn) < 2 or not {*drawn} <= {*numbers}:
        return None
    return _drawn(block.cells[drawn[0]], block.cells[drawn[1]], "")


def _drawn(x, y, unit):
    """Points that are drawn; unit: of x, "" where it is not known: then no part can be chosen."""
    known = np.isfinite(x) & np.isfinite(y)
    if not known.any():
        return None
    x, y, every = x[known], y[known], 1 + int(known.sum()) // DRAWN
    extent = {"low": float(x.min()), "high": float(x.max()), "unit": unit}
    return {"x": x[::every].tolist(), "y": y[::every].tolist()} | extent


def _surface(scene, source, how, chosen, seen):
    """The Profile of a Block, or of the content of an instrument's file; how: arguments of `read_trace`."""
    trace = profile.read_trace(source, **how)
    x = trace.x - trace.x[0]
    part = chosen.part or tuple(float(at / x[-1]) for at in proposed(trace))
    seen |= {"drawn": _drawn(x, trace.z, "nm"), "part": part, "fields": seen["fields"] | CUT_OFF}
    within = None if part == (0.0, 1.0) else (part[0] * x[-1], part[1] * x[-1])
    made = read_profile(source, part=within, cut_off=chosen.cut_off, **how)
    used, apart = f" of {rounded(x[-1], 4)} nm" if within else "", rounded(made.length / scene.nodes)
    seen["says"] = (
        f"{rounded(made.length, 4)} nm{used} long, {rounded(np.ptp(made.z))} nm high, {made.z.size:,} points; "
        f"{scene.nodes:,} nodes lie {apart} nm apart, which is the lattice period"
    )
    return made


def _curve(scene, block, columns, chosen, seen):
    """The Curve of a Block."""
    derived = seen["kind"] if chosen.columns and seen["kind"] != "friction" else None
    options = {"kind": chosen.kind or derived, "speed": chosen.speed, "channel": chosen.channel, "sign": chosen.sign}
    options["units"] = {role: unit for role, unit in chosen.units.items() if role in columns}
    if chosen.columns:
        bars = recognised(block.table, roles.NAMED)[0]
        bars = {role: k for role, k in bars.items() if not named_unit(block.table.columns[k].unit or "")}
        named = {f"{role}_bar" if bars.get(f"{role}_bar") == k else role: k for role, k in columns.items()}
        options["columns"] = dict.fromkeys(("U_x", "time", "F", "L", "A")) | {name: k + 1 for name, k in named.items()}
    seen["fields"] = {"speed": "speed (nm/s)"} if "time" in columns else {}
    seen["signs"] = {role: chosen.sign.get(role, 0) for role in columns if role != "time"}
    read = read_measurement(scene, block, **options)
    if read.kind == "load" and read.units["L"] == "N":
        seen["fields"] = {"deflection": "stiffness of the lever (N/m), to take its deflection off δ"}
        lever = read.lever if chosen.deflection is None else chosen.deflection
        seen["deflection"] = options["deflection"] = lever or None
        read = read_measurement(scene, block, **options)
    main = next(iter(read.segments[0].values))
    x, y = np.hstack([(each.x, each.values[main]) for each in read.segments])
    low, span, unit = float(x.min()), float(np.ptp(x)), read.units[read.over]
    part = chosen.part or _from_contact(read, x)
    kind = read.kind if read.kind in KINDS else "area"
    seen |= {"kind": kind, "drawn": _drawn(x, y, unit), "part": part}
    text = f"{KINDS.get(read.kind, read.kind)}, {rounded(span)} {unit}"
    if part != (0.0, 1.0):
        options["part"] = tuple(low + at * span for at in part)
        read = read_measurement(scene, block, **options)
        text += f", {rounded((part[1] - part[0]) * span)} {unit} of it used"
    made = curve_of(read, {name: value for name, value in options.items() if value})
    seen["says"] = f"{text}, {sum(each.x.size for each in read.segments):,} points"
    return made


def _from_contact(read, x):
    """The part of a long load that is proposed: from the jump, or from the first contact, on."""
    first, span = read.segments[0], float(np.ptp(x))
    if read.kind != "load" or span < FAR or first.x.size < 20 * STEADY:
        return 0.0, 1.0
    order = np.argsort(first.x, kind="stable")
    far, L = first.x[order], first.values["L"][order]
    free = slice(0, far.size // 4)
    off = np.abs(L - np.polyval(np.polyfit(far[free], L[free], 1), far))
    left = off > LEFT * max(float(np.median(off[free])), 1e-12 * float(np.ptp(L)))
    k = int(np.argmax(np.convolve(left, np.ones(STEADY), "valid") == STEADY))  # 0 where it never leaves its line
    low = max(0.0, float((far[k] - x.min()) / span) - 0.005)
    return (0.0, 1.0) if low > 0.98 else (low, 1.0)
