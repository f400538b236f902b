"""The parameters a visitor may change: three sliders, and a drawer with all others. Reads and checks entries."""

import re
from dataclasses import dataclass
from difflib import get_close_matches
from math import inf
from typing import Any

import numpy as np

from app import interface
from app.limits import DEFAULT, FLAT, INCREMENTS, MOST, NUMBERS, increments_of
from solver import LIMITS, Scene, SceneError
from solver.presets import presets
from solver.scene import PARAMETERS
from solver.schema import RETIRED
from solver.text import number_from_text


@dataclass(frozen=True)
class Control:
    """One slider with its numeric entry. `positions` are the values of the slider."""

    name: str
    label: str
    symbol: str
    unit: str
    meaning: str
    positions: tuple


def _even(low, high, step):
    count = round((high - low) / step)
    return tuple(round(low + step * i, 10) for i in range(count + 1))


def _logarithmic(low, high, count, default):
    """Return values evenly spaced in the logarithm, rounded to three digits, with `default` exactly."""
    values = {float(f"{value:.3g}") for value in np.geomspace(low, high, count)}
    closest = min(values, key=lambda value: abs(np.log(value / default)))
    return tuple(sorted(values - {closest} | {low, high, default}))


CONTROLS = (
    Control(
        "delta_bar",
        "Press depth",
        "δ/δ₀",
        "",
        "Indentation: how far the punch is lowered, over δ₀ = 10 δₙ.",
        _even(-1.0, 1.0, 0.01),
    ),
    Control(
        "phi_ratio",
        "Friction / adhesion",
        "φₜ/φₙ",
        "",
        "Tangential over normal work of separation: how strongly the interface resists sliding compared with opening.",
        _logarithmic(0.002, 2.0, 151, 1.0),
    ),
    Control(
        "E",
        "Stiffness",
        "E",
        "GPa",
        "Young's modulus of the punch. Soft punches stick and stretch, stiff ones hardly deform.",
        _logarithmic(10.0, 3000.0, 121, 70.0),
    ),
)
NAMES = tuple(control.name for control in CONTROLS)
LABELS = {control.name: control.label for control in CONTROLS}
RANGES = LIMITS | {name: LIMITS[name]._replace(high=high) for name, high in MOST.items()}  # in the app
WHOLES = {"w": "width", "δ₀": "delta_0", "δₙ": "delta_n", "δₜ": "delta_t"}  # {unit: name of that length in Scene}
FOR_SERVER: set[str] = {"preset", *PARAMETERS}  # in an address, for the server
# In an address, for the browser; `pin` and `force` are of older links and have no effect
FOR_BROWSER: set[str] = {"v", "theme", "embed", "view", "more", "pin", "force"}
STAYS = " The run on screen stays."
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def read(name: str, text: str, notes: list[str] | None = None, scene: Scene | None = None) -> Any:
    """Return the value of an entry for parameter `name`, checked against its range in the app; raises SceneError.

    scene: if given, lengths may have a unit: '4 nm' then means 0.4 delta_0.
    """
    if name not in LIMITS:
        return PARAMETERS[name].checked(name, text)
    unit = "δ₀" if name == "delta_bar" else RANGES[name].unit
    whole = getattr(scene, WHOLES[unit]) if scene and unit in WHOLES else None
    return RANGES[name].checked(name, number_from_text(name, text, notes, RANGES[name], whole))


def message_of(error: SceneError, text: str | None = None) -> str:
    """Return a SceneError as a message in the page's terms: 'Press depth “-3”: allowed: ...'."""
    value = shown(error.value) if isinstance(error.value, float) else error.value
    message = f"“{str(text or value)[:40]}”: {in_words(f'{error.allowed}; {error.remedy}')}"
    return f"{LABELS.get(error.name, error.name)} {message}"


def in_words(text: str) -> str:
    """Replace parameter names by the labels of sliders, and format numbers: −1 to 10⁶."""
    for name, label in LABELS.items():
        text = re.sub(rf"\b{name}\b", label, text)
    text = re.sub(r"\b1e\+?(-?)0*(\d+)", lambda power: "10" + "".join(power.groups()).translate(RAISED), text)
    return re.sub(r"(?<![\w.])-(?=\d)", "−", text).replace(" .. ", " to ")


def changed_scene(
    scene: Scene, entries: dict[str, Any], notes: list[str] | None = None
) -> tuple[Scene, dict[str, str]]:
    """Return `scene` with every valid value of `entries` {name: text}, and {name: message} of the others.

    notes: a list; messages on how a text was read are added to it.
    """
    values, errors, remarks = {}, {}, []
    for name in PARAMETERS:
        if name in entries:
            try:
                values[name] = read(name, entries[name], remarks, scene)
            except SceneError as error:
                errors[name] = f"{message_of(error, entries[name])}.{STAYS}"
    if notes is not None:
        notes += map(in_words, remarks)
    try:
        if values.get("surface") == "measured" and scene.measured is None:
            raise SceneError("surface", "measured", "it needs a profile", "choose a file under profile")
        if values.get("path", scene.path) == "points":  # they set it
            values.pop("delta_bar", None)
            values.setdefault("points", scene.points)
        changed = scene.changed(**values)
        refuse_large(changed, values)
        return changed, errors
    except SceneError as error:
        where = error.name if error.name in PARAMETERS else next(iter(values), NAMES[0])
        return scene, errors | {where: f"{message_of(error, entries.get(error.name))}.{STAYS}"}


def refuse_large(scene: Scene, values: Any = ()) -> None:
    """Raise SceneError if the run is too large for a browser; values: the parameters that were changed."""
    for name in MOST:
        RANGES[name].checked(name, getattr(scene, name))
    increments = increments_of(scene)
    nodes = min(FLAT, scene.nodes) if scene.surface == "flat" else scene.nodes
    if increments > INCREMENTS or increments * nodes > NUMBERS:
        name = next((name for name in ("nodes", "du_x", "du_z", "u_x_max") if name in values), "u_x_max")
        raise SceneError(
            name,
            getattr(scene, name),
            f"the run would take {increments} increments of {nodes} nodes,"
            f" allowed here: {min(INCREMENTS, NUMBERS // nodes)} increments",
            "shorten it, enlarge du_x or du_z, or use python -m solver run",
        )


def scene_from_address(arguments: Any) -> tuple[Scene, str, list[str]]:
    """Return (scene, preset, notes) of the page's address {name: [bytes]}, with a note per invalid value."""
    entries = {name: values[-1].decode("utf-8", "replace") for name, values in arguments.items() if values}
    notes = [_unknown(name) for name in arguments if name not in FOR_SERVER and name not in FOR_BROWSER]
    name = entries.get("preset", DEFAULT)
    if name not in presets():
        notes.append(f"There is no preset “{name[:40]}”: the list of experiments has all. The default is shown.")
        name = DEFAULT
    base = presets()[name].scene
    for feature in interface.classes().values():
        base = feature.scene_of(base, entries, notes)
    remarks = []
    scene, errors = changed_scene(base, entries, remarks)
    if errors and scene is base:  # the valid values together are refused: check each alone
        errors, remarks = {}, []
        for entry, text in entries.items():
            scene, more = changed_scene(scene, {entry: text}, remarks)
            errors |= {entry: "".join(more.values())} if more else {}
    notes += remarks + [
        f"{entry} in the address: {message.removesuffix(STAYS)} The default {shown(getattr(base, entry))} is used."
        for entry, message in errors.items()
    ]
    return scene, name, notes


def _unknown(name):
    """Return the message about an unknown name in an address."""
    if name in RETIRED:
        return f"“{name}” in the address: {RETIRED[name]}."
    close = " or ".join(get_close_matches(name, PARAMETERS))
    return f"“{name[:40]}” in the address is unknown and has no effect{f'. Use {close}.' if close else '.'}"


def shown(value: Any) -> str:
    """Return a value as the text of an entry."""
    return value if isinstance(value, str) else f"{value:.12g}"


def values_of(scene: Scene) -> dict[str, Any]:
    """Return {name: value} of all parameters for JSON: infinity becomes a text."""
    return {name: "inf" if (value := getattr(scene, name)) == inf else value for name in PARAMETERS}


def address_of(scene: Scene, preset: str) -> dict[str, str]:
    """Return the address {name: text} that restores this scene: the preset, and the differences from it."""
    base = values_of(presets()[preset].scene)
    values = {name: shown(value) for name, value in values_of(scene).items() if value != base[name]}
    for feature in interface.classes().values():
        values |= feature.address(scene)
    return ({} if preset == DEFAULT else {"preset": preset}) | values
