"""The drawer: all parameters of the scene that have no slider, with their ranges and meanings."""

import re
from typing import Any

from app import interface
from app.session.controls import NAMES, RANGES
from solver import CHOICES, LIMITS
from solver.scene import PARAMETERS
from solver.surfaces import SURFACES


class Feature(interface.Feature):
    """Entries beside those of the sliders; the core sends and describes all of them."""

    ORDER = 20

    @classmethod
    def templates(cls) -> dict[str, Any]:
        functions = {"drawer": drawer(), "meaning": meaning, "also": ALSO, "words": words, "applies": applies}
        return functions | {"choices": CHOICES, "unit_of": lambda name: LIMITS[name].unit if name in LIMITS else ""}


def drawer() -> dict[str, list[str]]:
    """Return {group: names} of the parameters without a slider, in the order of Scene."""
    groups = {}
    for name, parameter in PARAMETERS.items():
        if name not in NAMES:
            groups.setdefault(parameter.group, []).append(name)
    return groups


ALSO = {  # {parameter: further words by which a visitor looks for it}
    "hold": "force load",
    "drive_t": "force spring",
    "drive_n": "force spring",
    "phi_n": "surface energy force",
}


def words(name: str) -> str:
    """Return the label of a parameter in the drawer: its meaning up to the first comma or semicolon."""
    return re.split("[,;]", PARAMETERS[name].meaning)[0]


def meaning(name: str) -> str:
    """Return the hint beside a parameter in the drawer: the rest of its meaning, and its range."""
    if name in CHOICES:
        return ""
    parameter = RANGES.get(name, PARAMETERS[name])
    rest = parameter.meaning.removeprefix(words(name)).lstrip(",; ")
    return f"{rest}; {parameter.span}" if rest else parameter.span


def applies(name: str) -> dict[str, list[str]]:
    """Return {"surface" or "path": choices for which a parameter has an effect}; empty: for all."""
    kinds = [kind for kind, surface in SURFACES.items() if name in surface.parameters]
    if kinds:
        return {"surface": kinds}
    if name == "points":
        return {"path": ["points"]}
    return {"path": ["shear", "loop"]} if name in ("hold", "u_x_max", "du_x", "drive_t") else {}
