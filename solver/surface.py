"""The undeformed surface of the layer: every kind is a function from a Scene to its nodes' gap g0 (nm) at delta = 0.

Every gap is periodic over w. Its lowest point is at 0, so that at delta = 0 the surfaces just touch if nothing deforms;
its highest is at the ends of the cell, so that a contact lies across them last of all, and edges come in order.
"""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

STEEPEST = 0.3  # slope of a wave or a measured profile: 1 - cos is 5 % there, beyond it slopes are not small
FEWEST_NODES = 8  # to a wavelength of a wave
SHORTEST = 4  # node spacings to the cut-off wavelength


@dataclass(frozen=True)
class Profile:
    """A measured profile: heights z (nm) at equal distances over one period (nm), kept as bytes of float64.

    heights: any sequence of numbers, or those bytes; cheap to hash and to send. notes: what was done to the data.
    """

    length: float
    heights: bytes = field(repr=False)
    notes: tuple = field(default=(), compare=False)

    def __post_init__(self):
        if not isinstance(self.heights, bytes):
            object.__setattr__(self, "heights", np.asarray(self.heights, "<f8").tobytes())
        object.__setattr__(self, "notes", tuple(self.notes))

    @property
    def z(self):
        """Heights, nm, (points,); read-only."""
        return np.frombuffer(self.heights, "<f8")


def circular(scene):
    """(x - w/2)^2 / (2R), the protrusion of the paper."""
    from_middle = (np.arange(scene.nodes) - scene.nodes / 2) * scene.spacing  # even to the last bit
    return from_middle**2 / (2.0 * scene.radius * scene.width)


def flat(scene):
    """No gap at all."""
    return np.zeros(scene.nodes)


def wave(scene):
    """amplitude (1 + cos(2 pi waves x/w)), twice the amplitude from crest to trough."""
    k = (np.arange(scene.nodes) * scene.waves) % scene.nodes
    k = np.minimum(k, scene.nodes - k)  # even to the last bit
    return scene.amplitude * (1.0 + np.cos(2.0 * np.pi * k / scene.nodes))


def rough(scene):
    """Self-affine: C(q) ~ q^(-1-2H) from roll-off to cut-off, flat below, none above; random phases.

    The sum of cosines with amplitudes sqrt(C) at q = 2 pi k/w, scaled to the exact rms slope. Mode k has the same phase
    at any cut-off and number of nodes.
    """
    phases = 2.0 * np.pi * _uniform(scene.seed, _modes(scene))
    k = np.arange(1, phases.size + 1)
    amplitude = np.maximum(k, 1.0 / scene.roll_off) ** (-0.5 - scene.hurst)
    slope = np.sqrt(0.5 * np.sum((2.0 * np.pi * k / scene.width * amplitude) ** 2))
    spectrum = np.zeros(scene.nodes // 2 + 1, complex)
    spectrum[k] = 0.5 * scene.nodes * scene.rms_slope / slope * amplitude * np.exp(1j * phases)
    gap = np.fft.irfft(spectrum, scene.nodes)
    return np.roll(gap - gap.min(), -int(np.argmax(gap)))


def measured(scene):
    """The profile's summits face the substrate: highest z less z, linearly between its points."""
    z = scene.measured.z
    at = np.arange(scene.nodes) * (z.size / scene.nodes)
    height = np.interp(at, np.arange(z.size + 1), np.append(z, z[0]))
    return height.max() - height


SURFACES = {"circular": circular, "flat": flat, "wave": wave, "rough": rough, "measured": measured}


def undeformed_gap(scene):
    """g0 of every node, nm, (nodes,); a new array."""
    return _kept(scene).copy()


@lru_cache(maxsize=8)
def _kept(scene):
    return SURFACES[scene.surface](scene)


def _uniform(seed, count):
    """The first `count` of a stream of numbers in [0, 1), from the generator's bits: the same with every NumPy."""
    return (np.random.Philox(key=seed).random_raw(count) >> np.uint64(11)) * 2.0**-53


def _modes(scene):
    """Number of the cut-off's mode: the shortest wave of a rough profile fits so often into the cell."""
    return int(1.0 / scene.cut_off + 1e-9)


def refusal(scene):
    """(parameter, what is allowed, remedy) where the scene's surface cannot be built from its parameters, or None."""
    if scene.surface == "wave":
        return _wave_refused(scene)
    if scene.surface == "rough":
        return _rough_refused(scene)
    return _measured_refused(scene) if scene.surface == "measured" else None


def _wave_refused(scene):
    most = scene.nodes // FEWEST_NODES
    if scene.waves > most:
        return "waves", f"allowed: 1 .. {most}, {FEWEST_NODES} nodes to a wavelength", "lower it, or enlarge nodes"
    highest = STEEPEST * scene.width / (2.0 * np.pi * scene.waves)
    if scene.amplitude > highest:
        return "amplitude", f"allowed: up to {highest:.4g} nm, where the slope is {STEEPEST:g}", "lower it, or waves"
    return None


def _rough_refused(scene):
    least = SHORTEST / scene.nodes
    if scene.cut_off < least:
        return "cut_off", f"allowed: {least:.4g} .. 1 w, {SHORTEST} node spacings or more", "enlarge it, or nodes"
    if scene.cut_off > scene.roll_off:
        return "cut_off", f"allowed: up to roll_off = {scene.roll_off:g}", "lower it, or enlarge roll_off"
    return None


def _measured_refused(scene):
    if scene.measured is None:
        return (
            "surface",
            "it needs a profile",
            "give one: profile=FILE after --set, measured=read_profile(...) in Python",
        )
    length = scene.measured.length
    if abs(scene.width - length) > 1e-9 * length:
        return "width", f"allowed: the profile's {length!r} nm", "set that width, or read the profile with yours"
    return None
