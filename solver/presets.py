"""Named experiments, from presets.toml: those of the paper's figures and some that it leaves open."""

import tomllib
from dataclasses import dataclass, fields
from functools import cache
from importlib import resources
from types import MappingProxyType

from .scene import Scene, SceneError

FILE = "presets.toml"
TEXTS = ("title", "group", "look")
WORDS = (*TEXTS, "figure", "short")


class PresetError(ValueError):
    """A preset that does not exist or cannot be used; the message names preset and key, and says what is allowed."""


@dataclass(frozen=True)
class Preset:
    """A named Scene: `title` for menus, under `group`; `look` says in a sentence what to look for.

    figure: of the paper, or ""; short: its phenomenon in two words, where it is among the first to be shown, or "".
    """

    name: str
    title: str
    group: str
    figure: str
    look: str
    scene: Scene
    short: str = ""

    @property
    def label(self):
        """Title and figure in a line."""
        return self.title + (f" ({self.figure})" if self.figure else "")

    @property
    def differences(self):
        """{parameter: value} where the scene differs from the default one."""
        default = Scene()
        values = {f.name: getattr(self.scene, f.name) for f in fields(Scene)}
        return {name: value for name, value in values.items() if value != getattr(default, name)}


@cache
def presets():
    """{name: Preset} in the order of the file, read-only. Raises PresetError."""
    text = resources.files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return MappingProxyType(read(text))


def preset(name):
    """The Preset of that name; raises PresetError."""
    known = presets()
    if name not in known:
        raise PresetError(f"preset {name!r}: allowed: {', '.join(known)}; use one of these names")
    return known[name]


def read(text):
    """{name: Preset} from TOML: a table per preset, with its texts and parameters of Scene. Raises PresetError."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise PresetError(f"{FILE}: {error}; correct the line") from None
    return {name: _preset(name, table) for name, table in tables.items()}


def _preset(name, table):
    where = f"{FILE}, preset {name!r}"
    if not isinstance(table, dict):
        raise PresetError(f"{where}: {table!r} is not a table; write [{name}] above its keys")
    for key in TEXTS:
        if not (isinstance(table.get(key), str) and table[key].strip()):
            raise PresetError(f"{where}, key {key!r}: {table.get(key)!r}; give a text")
    values = {key: value for key, value in table.items() if key not in WORDS}
    allowed = [f.name for f in fields(Scene)]
    for key in values:
        if key not in allowed:
            raise PresetError(f"{where}, key {key!r}: allowed: {', '.join((*WORDS, *allowed))}; use one of these")
    try:
        texts = [table["title"], table["group"], table.get("figure", ""), table["look"]]
        return Preset(name, *texts, Scene(**values), table.get("short", ""))
    except SceneError as error:
        raise PresetError(f"{where}, key {error.name!r}: {error}") from None
