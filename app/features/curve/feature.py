"""A measured curve over the run: a worker reads it, the browser draws and compares it.

This server keeps its content for the page *Fit* until the visitor drops another one or leaves.
"""

import secrets
from typing import Any

from app import interface
from app.features.curve import tasks
from app.service.tasks import READING
from app.session import orders
from app.session.orders import order

Kept = tuple[bytes, float | None, float | None]  # content of a file, speed and force as the visitor gave them
_kept: dict[str, Kept] = {}  # one per visitor at most


def kept(key: str) -> Kept | None:
    """Return (content, speed nm/s or None, force N/m per unit or None) of a key; None if its visitor has left."""
    return _kept.get(key)


class Feature(interface.Feature):
    """The file of one visitor. `key`: an unguessable name of what is kept of it, "" for nothing."""

    ORDER = 60
    PARAMS = {
        "curve": "the file of a measured curve: content (bytes), speed (nm/s), force (N/m per unit)",
        "forget": "keep no measured curve",
        "measured": "a measured curve: curve, key; or why the file has none",
    }
    key = ""
    kept = staticmethod(kept)

    def close(self) -> None:
        self.forget()

    @order("curve", content=orders.is_content, speed=orders.is_number, force=orders.is_number)
    def read(self, content: bytes, speed: float | None = None, force: float | None = None) -> None:
        """Read a measured curve; speed, force: as of `read_measurement`.

        The message `curve` has it, or why the file is not usable: then the last one stays.
        """
        call = tasks.read_curve, self.session.scene, content, speed, force
        self.ask(call, lambda made: self._made(made, (content, speed, force)), private=True, seconds=READING)

    def _made(self, made: Any, given: Kept) -> None:
        curve, why = made or (None, "it could not be read in time; thin it out")
        if curve is not None:
            self.forget()
            self.key = secrets.token_urlsafe(9)
            _kept[self.key] = given
        self.session.send("measured", curve=curve, why=why, key=self.key)

    @order("forget")
    def forget(self) -> None:
        """Keep no file, and read none."""
        self.cancel()
        _kept.pop(self.key, None)
        self.key = ""
