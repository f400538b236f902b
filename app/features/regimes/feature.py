"""Map of regimes: the first slip over two parameters. Needs pages."""

from typing import Any

from app import interface
from app.features.regimes.grid import AXES
from app.features.regimes.page import QUANTITIES


class Feature(interface.Feature):
    """See page.py."""

    ORDER = 12

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {
            "axes": {name: axis[0] for name, axis in AXES.items()},
            "quantities": {name: what[0] for name, what in QUANTITIES.items()},
        }
