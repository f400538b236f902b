"""The parameters a visitor may change: three sliders and the drawer of all others; the reading of what was entered."""

from dataclasses import dataclass, fields
from math import inf

import numpy as np

from solver import LIMITS, Scene, SceneError
from solver.presets import presets
from solver.run.load_steps import legs_of
from solver.scene import CHOICES, UNBOUNDED, WHOLE

INCREMENTS, NUMBERS = 5000, 2_500_000  # of one run, and times nodes: what a browser holds and draws with ease
MOST = {"nodes": 4096, "u_x_max": 1000.0}  # in the app; `python -m solver run` goes up to the solver's own limits


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
        _logarithmic(0.002, 2.0, 151, 1.0),
    ),
    Control(
        "E",
        "Stiffness",
        "Ē",
        "GPa",
        "Young's modulus of the punch. Soft punches stick and stretch, stiff ones hardly deform.",
        _logarithmic(10.0, 3000.0, 121, 70.0),
    ),
)
NAMES = tuple(control.name for control in CONTROLS)
ENTERED = tuple(f.name for f in fields(Scene) if f.name in LIMITS or f.name in CHOICES)  # what can be typed
GROUPS = {
    "Load path": ("path", "hold", "u_x_max", "damping", "du_x", "du_z", "tolerance"),
    "Surface": (),  # those named nowhere else
    "Interface": ("phi_n", "delta_n", "delta_t", "window_n", "window_t"),
    "Layer": ("nu", "height", "width", "nodes"),
}


def drawer():
    """{group: names} of the parameters without a slider; those named nowhere else belong to the surface."""
    named = {name for group in GROUPS.values() for name in group} | set(NAMES) | {"surface"}
    return GROUPS | {"Surface": ("surface", *(name for name in ENTERED if name not in named))}


class EntryError(ValueError):
    """A value that cannot be used; the message names parameter, value and range, `name` says where to show it."""

    def __init__(self, name, message):
        self.name = name
        super().__init__(f"{message}. The run on screen stays.")


def limits(name):
    """(lowest, highest) value of parameter `name` in the app."""
    control = next((control for control in CONTROLS if control.name == name), None)
    if control:
        return control.low, control.high
    low, high = LIMITS[name][:2]
    return low, MOST.get(name, high)


def read(name, text):
    """What was entered for parameter `name`, checked against its range; raises EntryError."""
    if name in CHOICES:
        if text not in tuple(CHOICES[name]):
            raise EntryError(name, f"{name} = “{str(text)[:40]}”; allowed: {', '.join(CHOICES[name])}")
        return text
    low, high = limits(name)
    allowed = f"allowed: {low:g} to {high:g}" + (" or inf" if name in UNBOUNDED else "")
    try:
        number = float(text)
    except (TypeError, ValueError):
        raise EntryError(name, f"{name} = “{str(text)[:40]}” is not a number; {allowed}") from None
    if name in UNBOUNDED and number == inf:
        return number
    if low <= number <= high and name in WHOLE and number != int(number):
        raise EntryError(name, f"{name} = {number:g} is not a whole number; {allowed}")
    if not low <= number <= high:  # false for NaN as well
        raise EntryError(name, f"{name} = {number:g} is out of range; {allowed}")
    return number


def changed_scene(scene, entries):
    """`scene` with every usable value of `entries` {name: text}, and {name: message} of the others."""
    values, errors = {}, {}
    for name in ENTERED:
        if name in entries:
            try:
                values[name] = read(name, entries[name])
            except EntryError as error:
                errors[name] = str(error)
    try:
        if values.get("surface") == "measured" and scene.measured is None:
            raise EntryError("surface", "surface = “measured” needs a profile; choose a file under profile")
        changed = scene.changed(**values)
        _of_a_size(changed, values)
        return changed, errors
    except SceneError as error:
        where = error.name if error.name in ENTERED else next(iter(values), NAMES[0])
        return scene, errors | {where: f"{error}. The run on screen stays."}
    except EntryError as error:
        return scene, errors | {error.name: str(error)}


def increments_of(scene):
    """How many increments a run of the scene takes, as far as is known before."""
    return sum(leg.increments + 1 for leg in legs_of(scene))


def _of_a_size(scene, values):
    """Raise EntryError for a run that is more than a browser should have to hold."""
    increments = increments_of(scene)
    nodes = 1 if scene.surface == "flat" else scene.nodes
    if increments > INCREMENTS or increments * nodes > NUMBERS:
        most = min(INCREMENTS, NUMBERS // nodes)
        raise EntryError(
            next((name for name in ("nodes", "du_x", "du_z", "u_x_max") if name in values), "u_x_max"),
            f"The run would take {increments} increments of {nodes} nodes; allowed here: {most} increments; shorten it,"
            " enlarge du_x or du_z, or use python -m solver run",
        )


DEFAULT = next(iter(presets()))


def scene_from_address(arguments):
    """(scene, preset, notes) asked for in the page's address {name: [bytes]}; a note per value that is of no use."""
    entries = {name: values[-1].decode("utf-8", "replace") for name, values in arguments.items() if values}
    known, notes = presets(), []
    name = entries.get("preset", DEFAULT)
    if name not in known:
        notes.append(f"preset = “{name[:40]}” is unknown; allowed: {', '.join(known)}. The default is shown.")
        name = DEFAULT
    base = known[name].scene
    scene, errors = changed_scene(base, entries)
    if errors:
        scene, errors = base, {}
        for entry, text in entries.items():  # each is judged alone
            scene, found = changed_scene(scene, {entry: text})
            errors |= found
    notes += [
        f"{message.removesuffix(' The run on screen stays.')} The default {shown(getattr(base, entry))} is used."
        for entry, message in errors.items()
    ]
    return scene, name, notes


def shown(value):
    """A value as it is written in an entry."""
    return value if isinstance(value, str) else f"{value:.12g}"


def values_of(scene):
    """{name: value} of everything that can be entered, as JSON knows it: infinity is text."""
    values = {name: getattr(scene, name) for name in ENTERED}
    return {name: "inf" if value == inf else value for name, value in values.items()}


def address_of(scene, preset):
    """{name: text} of the page's address that brings this scene back: the preset, and what differs from it."""
    base = values_of(presets()[preset].scene)
    values = {name: shown(value) for name, value in values_of(scene).items() if value != base[name]}
    return ({} if preset == DEFAULT else {"preset": preset}) | values
