"""Measured files: one dialog reads a profile, which becomes the surface, or a curve, which is drawn over the run."""

import hashlib
import secrets
from collections.abc import Callable
from typing import Any

from cachetools import LRUCache

from app import interface
from app.features.files import comparing, tasks
from app.service.requests import Requests
from app.service.tasks import READING
from app.session import orders
from app.session.controls import refuse_large
from app.session.orders import order
from solver import DataError, Profile, Scene, SceneError
from solver.measured.content import MOST_BYTES

Kept = tuple[bytes, dict[str, Any]]  # content of a file, and the arguments of `read_measurement` that read it
SLOW = 3 * READING  # s for a file of MOST_BYTES, which is read three times
_kept: dict[str, Kept] = {}  # one per visitor at most
_profiles = LRUCache(32)  # those in use, by the name in an address, the latest used


def kept(key: str) -> Kept | None:
    """Return (content, arguments) of a friction curve, for a fit, by its key; None if its visitor has left."""
    return _kept.get(key)


def of_roles(test: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """Return the test for {quantity: value that passes a test}."""
    roles = {*tasks.ROLES}
    return lambda values: isinstance(values, dict) and values.keys() <= roles and all(map(test, values.values()))


is_kind, are_columns = ("", *tasks.KINDS).__contains__, of_roles(orders.is_whole)
are_units, are_signs = of_roles(orders.is_text), of_roles((-1, 1).__contains__)


def is_part(values: Any) -> bool:
    numbers = isinstance(values, list) and len(values) == 2 and all(map(orders.is_number, values))
    return numbers and 0.0 <= values[0] < values[1] <= 1.0


def are_stages(names: Any) -> bool:
    return isinstance(names, list) and all(map(orders.is_text, names))


class Feature(interface.Feature):
    """The file of one visitor. `key`: an unguessable name of what is kept of it, "" for nothing."""

    ORDER = 60
    PARAMS = {
        "piece": "a piece of a file: at (bytes before it), of (bytes in all), content",
        "choice": "what a visitor has chosen of the file: turn, use, and the fields of tasks.Chosen",
        "seen": "got (bytes), or turn and file: what `tasks.look` returns, and used (its kind)",
        "laid": "a measured curve: curve, key",
        "compare": "compares the curve: content (curves of the run), stages, force, width",
        "compared": "what `comparing.compare` returns",
        "forget": "keep no measured curve",
    }
    READS = frozenset({"profile"})
    kept = staticmethod(kept)

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.comparing = Requests(session)
        self.pieces: list[bytes] = []
        self.content, self.key = b"", ""
        self.curve: comparing.Curve | None = None

    @classmethod
    def scene_of(cls, scene: Scene, entries: dict[str, str], notes: list[str]) -> Scene:
        if "profile" in entries:
            try:
                return scene.changed(measured=profile_of(entries["profile"]))
            except DataError as error:
                notes.append(f"profile: {error}.")
        return scene

    @classmethod
    def address(cls, scene: Scene) -> dict[str, str]:
        measured = scene.surface == "measured" and scene.measured
        return {"profile": name_of(measured)} if measured else {}

    def replaced(self) -> None:
        """Read no file any more."""
        self.cancel()

    def close(self) -> None:
        self.forget()

    @order("piece", at=orders.is_whole, of=orders.is_whole, content=orders.is_content)
    def take_piece(self, at: int, of: int, content: bytes) -> None:
        """Add a piece of a file; the first one drops the file before. The answer asks for the next one."""
        if at == 0:
            self.cancel()
            self.pieces, self.content = [], b""
        got = sum(map(len, self.pieces)) + len(content)
        if got == at + len(content) <= of <= MOST_BYTES:
            self.pieces.append(content)
            if got == of:
                self.content, self.pieces = b"".join(self.pieces), []
            self.session.send("seen", got=got)

    @order(
        "choice",
        turn=orders.is_whole,
        use=orders.is_flag,
        kind=is_kind,
        columns=are_columns,
        units=are_units,
        sign=are_signs,
        part=is_part,
        **dict.fromkeys(("channel", "line", "spacing", "unit"), orders.is_text),
        **dict.fromkeys(("cut_off", "speed", "deflection"), orders.is_number),
    )
    def choose(self, turn: int, use: bool = False, **chosen: Any) -> None:
        """Read the file as chosen; use: put it on screen, if nothing is missing."""
        call = tasks.look, self.session.scene, self.content, tasks.Chosen(**chosen)
        self.ask(call, lambda made: self._looked(made, turn, use), private=True, seconds=SLOW)

    def _looked(self, made, turn, use):
        seen, found = made or ({"why": "it could not be read in time; thin it out"}, None)
        if use and isinstance(found, Profile):
            seen |= self._surface(found)
        elif use and found is not None:
            self._lay(found)
            seen |= {"used": found.kind}
        self.session.send("seen", turn=turn, file=seen)

    def _surface(self, profile):
        """Give the scene the surface of a Profile; sliders may have moved since it was asked for."""
        try:
            scene = with_profile(self.session.scene, profile)
        except SceneError as error:
            return {"why": f"{error}", "says": ""}
        self.content = b""
        self.session.show(scene, self.session.preset, [f"Profile: {' '.join(profile.notes)}"])
        return {"used": tasks.SURFACE}

    def _lay(self, curve):
        """Draw a Curve, and keep the file of one that can be fitted."""
        content = self.content
        self.forget()
        self.curve = curve
        if curve.kind in ("friction", "loop") and curve.units.get("F") != "N":
            self.key = secrets.token_urlsafe(9)
            _kept[self.key] = content, curve.options
        self.session.send("laid", curve=comparing.shown(curve), key=self.key)

    @order(
        "compare",
        content=orders.is_content,
        stages=are_stages,
        force=orders.is_number,
        width=orders.is_number,
    )
    def compare(self, content: bytes, stages: list[str], force: float, width: float) -> None:
        """Compare the curve with the run whose curves these are."""
        if self.curve is None:
            return
        call = comparing.compare, self.curve, content, tuple(stages), force, width
        failed = {"why": "the curve could not be compared with this run"}
        self.comparing.ask(call, lambda made: self.session.send("compared", **(made or failed)), private=True)

    @order("forget")
    def forget(self) -> None:
        """Keep no file, and read none."""
        self.cancel()
        self.comparing.cancel()
        _kept.pop(self.key, None)
        self.key, self.content, self.pieces, self.curve = "", b"", [], None


def with_profile(scene: Scene, profile: Profile) -> Scene:
    """Return `scene` with the surface of a Profile; raises SceneError."""
    changed = scene.changed(surface="measured", measured=profile, width=profile.length)
    refuse_large(changed)
    return changed


def name_of(profile: Profile) -> str:
    """Keep a Profile, and return its name."""
    heights: Any = profile.heights  # bytes, once it is made
    name = hashlib.sha256(heights + f" {profile.length!r}".encode()).hexdigest()[:12]
    _profiles[name] = profile
    return name


def profile_of(name: str) -> Profile:
    """Return the Profile of a name; raises DataError."""
    profile = _profiles.get(name)
    if profile is None:
        raise DataError("this server does not have the profile of this address. Choose the file again")
    return profile
