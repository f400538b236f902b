"""A measured profile: a file becomes the surface, after questions about what it does not say. Needs drawer."""

import hashlib
from typing import Any

from cachetools import LRUCache

from app import interface
from app.features.profile import tasks
from app.service.tasks import READING
from app.session import controls, orders
from app.session.controls import refuse_large
from app.session.orders import order
from app.session.run import Request
from solver import DataError, Profile, Scene, SceneError

_profiles = LRUCache(32)  # uploaded ones of this server by the name in an address, the latest used


class Feature(interface.Feature):
    """The file of one visitor."""

    PARAMS = {
        "profile": "the file of a profile: content (bytes), unit, begin, end, cut_off, sure",
        "trace": "the profile in a file, with a question: trace, why",
    }
    READS = frozenset({"profile"})

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

    @order(
        "profile",
        content=orders.is_content,
        unit=orders.is_text,
        sure=orders.is_flag,
        **dict.fromkeys(("begin", "end", "cut_off"), orders.is_number),
    )
    def read_file(self, content: bytes, **chosen: Any) -> None:
        """Read the file of a profile, whose surface is then on screen; or draw it with a question.

        chosen: what a visitor has chosen of it, see `tasks.Chosen`.
        """
        call = tasks.measured, content, tasks.Chosen(**chosen)
        self.ask(call, self._read, private=True, seconds=READING)

    def _read(self, made):
        profile, why, trace = made or (None, "it could not be read in time; thin it out", None)
        self.session.send("trace", trace=trace, why=why and f"{why}.")
        if trace is not None:
            return self.session.publish()
        if profile is not None:  # sliders may have moved since
            try:
                scene = with_profile(self.session.scene, profile)
            except SceneError as error:
                profile, why = None, error
        if profile is None:
            self.session.errors = {"profile": f"profile: {why}.{controls.STAYS}"}
            return self.session.publish()
        self.session.scene, self.session.errors, self.session.notes = scene, {}, [f"Profile: {' '.join(profile.notes)}"]
        self.session.pursuit.request(Request(scene))


def with_profile(scene: Scene, profile: Profile) -> Scene:
    """Return `scene` with the surface of a Profile; raises SceneError."""
    changed = scene.changed(surface="measured", measured=profile, width=profile.length)
    refuse_large(changed, ())
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
