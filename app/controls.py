"""The three parameters a visitor may change: meaning, ranges, slider positions, and the reading of what was entered."""

from dataclasses import dataclass

import numpy as np

from solver import Scene, SceneError


@dataclass(frozen=True)
class Control:
    """One slider with its numeric entry; `positions` are the values the slider stops at."""

    name: str
    label: str
    symbol: str
    unit: str
    meaning: str
    positions: tuple

    @property
    def low(self):
        return self.positions[0]

    @property
    def high(self):
        return self.positions[-1]

    @property
    def default(self):
        return getattr(Scene(), self.name)


def _even(low, high, step):
    count = round((high - low) / step)
    return tuple(round(low + step * i, 10) for i in range(count + 1))


def _logarithmic(low, high, count, default):
    """Values evenly spaced in the logarithm, rounded to three digits; holds `default` exactly."""
    values = {float(f"{value:.3g}") for value in np.geomspace(low, high, count)}
    closest = min(values, key=lambda value: abs(np.log(value / default)))
    return tuple(sorted(values - {closest} | {low, high, default}))


CONTROLS = (
    Control(
        "delta_bar",
        "Indentation",
        "δ̄",
        "× 10 nm",
        "How far the punch is pressed down, over δ₀ = 10 δₙ = 10 nm. Below about 0.2 the load pulls, above it pushes.",
        _even(-1.0, 1.0, 0.01),
    ),
    Control(
        "phi_ratio",
        "Friction / adhesion",
        "φₜ/φₙ",
        "ratio",
        "Tangential over normal work of separation: how strongly the interface resists sliding compared with opening.",
        _logarithmic(0.05, 2.0, 101, 1.0),
    ),
    Control(
        "E",
        "Stiffness",
        "Ē",
        "GPa",
        "Young's modulus of the punch. Soft punches stick and stretch, stiff ones hardly deform.",
        _logarithmic(10.0, 1000.0, 101, 70.0),
    ),
)
NAMES = tuple(control.name for control in CONTROLS)


class EntryError(ValueError):
    """A value that cannot be used; the message names parameter, value and range, `name` says where to show it."""

    def __init__(self, name, message):
        self.name = name
        super().__init__(message)


def read(name, text):
    """The number entered for parameter `name`, checked against the range of its slider; raises EntryError."""
    control = next(control for control in CONTROLS if control.name == name)
    allowed = f"allowed: {control.low:g} to {control.high:g}"
    try:
        number = float(text)
    except (TypeError, ValueError):
        shown = str(text)[:40]
        raise EntryError(name, f"{name} = “{shown}” is not a number; {allowed}. The run on screen stays.") from None
    if not control.low <= number <= control.high:  # false for NaN as well
        raise EntryError(name, f"{name} = {number:g} is out of range; {allowed}. The run on screen stays.")
    return number


def changed_scene(scene, entries):
    """`scene` with every usable value of `entries` {name: text}, and {name: message} of the others."""
    values, errors = {}, {}
    for name in NAMES:
        if name in entries:
            try:
                values[name] = read(name, entries[name])
            except EntryError as error:
                errors[name] = str(error)
    try:
        return scene.changed(**values), errors
    except SceneError as error:
        return scene, errors | {error.name if error.name in NAMES else NAMES[0]: str(error)}


def scene_from_address(arguments):
    """The scene asked for in the page's address {name: [bytes]}, and one note per value that could not be used."""
    entries = {name: values[-1].decode("utf-8", "replace") for name, values in arguments.items() if values}
    scene, errors = changed_scene(Scene(), entries)
    notes = [
        f"{message.removesuffix(' The run on screen stays.')} The default {getattr(scene, name):g} is used."
        for name, message in errors.items()
    ]
    return scene, notes


def values_of(scene):
    """{name: value} of the three parameters."""
    return {name: getattr(scene, name) for name in NAMES}
