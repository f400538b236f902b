"""Named experiments, from presets.toml: those of the paper's figures, and some that the paper leaves open."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import resources
from types import MappingProxyType

from .scene import Scene, SceneError
from .schema import name_remedy

FILE = "presets.toml"
WORDS = ("title", "group", "look", "figure", "short")  # keys of a table that are no parameters


@dataclass(frozen=True)
class Preset:
    """A named Scene: `title` for menus, under `group`; `look` is a sentence on what to look for.

    figure: of the paper, or "". short: the phenomenon in two words if the app shows it in its first row, or "".
    """

    name: str
    title: str
    group: str
    look: str
    scene: Scene
    figure: str = ""
    short: str = ""

    @property
    def label(self) -> str:
        """Title and figure in a line."""
        return self.title + (f" ({self.figure})" if self.figure else "")


@cache
def presets() -> Mapping[str, Preset]:
    """{name: Preset} in the order of the file, read-only. Raises SceneError."""
    text = resources.files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return MappingProxyType(read(text))


def preset(name: str) -> Preset:
    """The Preset of that name; raises SceneError."""
    named = presets()
    if name not in named:
        raise SceneError("preset", name, f"allowed: {', '.join(named)}", name_remedy(name, named))
    return named[name]


def read(text: str) -> dict[str, Preset]:
    """{name: Preset} from TOML: a table per preset, with its texts and parameters of Scene. Raises SceneError."""
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise SceneError("preset", FILE, str(error), "correct the line") from None
    presets = {}
    for name, table in tables.items():
        try:
            scene = Scene(**{key: value for key, value in table.items() if key not in WORDS})
            presets[name] = Preset(name, scene=scene, **{key: table[key] for key in WORDS if key in table})
        except (AttributeError, TypeError, SceneError) as error:
            raise SceneError("preset", name, str(error), f"correct this table of {FILE}") from None
    return presets
