"""Experiments: a row of pictures and a menu of presets, each with what to look for."""

from pathlib import Path
from typing import Any

from app import interface
from solver.presets import presets

ROW = Path(__file__).parent / "row"


class Feature(interface.Feature):
    """Each experiment is a Preset; those with a short title stand in the row."""

    ORDER = 1

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {"looks": {preset.name: preset.look for preset in presets().values()}}

    @classmethod
    def templates(cls) -> dict[str, Any]:
        groups: dict[str, list[Any]] = {}
        for preset in presets().values():
            groups.setdefault(preset.group, []).append(preset)
        return {
            "preset_groups": groups,
            "preset_row": [preset for preset in presets().values() if preset.short],
            "preset_pictures": {path.stem: path.read_text(encoding="utf-8") for path in ROW.glob("*.svg")},
        }
