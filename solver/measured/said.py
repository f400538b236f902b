"""What a file says above its columns: names with texts, and the stiffness of a lever among them."""

import re
from collections.abc import Iterable

from .columns import plain
from .roles import NAMED, SECOND
from .tables import Table
from .units import PER_WIDTH, parted

SAID = re.compile(r'[#%{\s"]*([^\W\d][^\d:="]{1,60}?)"?\s*[:=]\s*"?((?:[^",]|,(?=\d)){1,60})')
SPRING = re.compile(r"spring[ _-]?const|force[ _-]?constant|lever.*stiffn|stiffn.*lever", re.I)
NUMBER = re.compile(r"(\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)(?![\d.])\s*(\S*)")
SPRINGS = PER_WIDTH | {"nN/nm": 1.0, "pN/nm": 1e-3}  # units of its stiffness
MOST_SAID = 100


def said_in(above: Iterable[str]) -> dict[str, str]:
    """{name: text} of the lines above the columns, as in Velocity = 240 or "speed": 1e-5."""
    found = (SAID.match(line) for line in above)
    pairs = [(match[1].strip(), match[2].strip()) for match in found if match and match[2].strip()]
    return dict(pairs[:MOST_SAID])


def spring_in(said: dict[str, str]) -> tuple[float | None, str]:
    """(stiffness, N/m, or None without a known unit; "name = text") of a spring that a file names, "" for none."""
    unknown = ""
    for name, text in said.items():
        match = NUMBER.match(text) if SPRING.search(name) else None
        if match:
            unit = match[2] or parted(name)[1] or ""
            if unit in SPRINGS:
                return float(match[1]) * SPRINGS[unit], f"{name} = {text}"
            unknown = unknown or f"{name} = {text}"
    return None, unknown


def lever_in(table: Table, k: int) -> float | None:
    """The stiffness, N/m, that a file names of a lever whose deflection is in its k-th column, a height; else None."""
    own = plain(table.columns[k].name)
    return (
        spring_in(said_in(table.above))[0] if own in (*NAMED["height"], *SECOND["height"], *NAMED["position"]) else None
    )
