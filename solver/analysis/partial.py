"""Derivatives of a state's equations by the parameters of its Scene at fixed displacements, and of its outputs.

The first are central differences of the law and of the layer's compliance, which are smooth; right to some ten digits.
"""

from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..mechanics import cohesive_law
from ..mechanics.layer import Modes, multiply
from ..run.frame import least_repulsion
from ..scene import LIMITS, SURFACES, Scene, SceneError

Floats = NDArray[np.float64]
NAMES = ("F_bar", "L_bar", "A_bar")  # of outputs
DIFFERENCE = (
    1e-5  # of a parameter, over its value: truncation and round-off of a central difference are both about 1e-10
)
PHYSICS = ("delta_bar", "phi_n", "phi_ratio", "delta_n", "delta_t", "E", "nu", "height", "width")
DRIVE = ("drive_t", "drive_n")  # that of a rigid drive, inf, has no values beside it
OF_THE_LAYER = ("E", "nu", "height", "width", *DRIVE)  # parameters of the compliance of layer and drive
NOT_OF_THE_LAW = ("E", "nu", "height", "delta_bar", *DRIVE)  # without effect on the law and on the profile
IN_STEPS = ("cut_off",)  # the profile depends on them in steps


def continuous(scene: Scene) -> tuple[str, ...]:
    """Names of the parameters on which a run of the scene depends smoothly.

    Left out: choices, whole numbers, cut_off, and parameters without effect on the branches (u_x_max, du_x, du_z,
    tolerance, damping), and the stiffness of a rigid drive.
    """
    own = [name for name in SURFACES[scene.surface].parameters if name in LIMITS and not LIMITS[name].whole]
    driven = [name for name in DRIVE if isfinite(getattr(scene, name))]
    names = [*PHYSICS, *driven, *(name for name in own if name not in IN_STEPS)]
    return tuple(name for name in names if not (name == "width" and scene.surface == "measured"))


@dataclass(frozen=True)
class Change:
    """The change by a parameter: the Scenes on both sides of its value, `span` apart, and what they change.

    part: the nodes of the patch; profiles: of both Scenes on it, (2, m) nm, or None where the law is the same.
    compliance: the change of C per unit, (3, nodes//2 + 1) nm/GPa as of `layer.Modes`, or None.
    """

    name: str
    low: Scene
    high: Scene
    span: float
    part: slice
    profiles: np.ndarray | None
    compliance: np.ndarray | None

    @staticmethod
    def of(scene: Scene, name: str, part: slice) -> "Change":
        """The Change by one of the `continuous` parameters, on the nodes `part`; raises SceneError."""
        value = getattr(scene, name)
        size = abs(value) or min(1.0, LIMITS[name].high)
        # at the end of a range truncation is of first order, and as large as round-off at 1e-7: both are some 1e-8
        for parts in ((-DIFFERENCE, DIFFERENCE), (0.0, 1e-7), (-1e-7, 0.0)):
            try:
                low, high = (scene.changed(**{name: value + part * size}) for part in parts)
            except SceneError:
                continue
            span = getattr(high, name) - getattr(low, name)
            profiles = None if name in NOT_OF_THE_LAW else np.array([low.profile[part], high.profile[part]])
            change = (Modes.of(high).compliance - Modes.of(low).compliance) / span if name in OF_THE_LAYER else None
            return Change(name, low, high, span, part, profiles, change)
        raise SceneError(name, value, "allowed: a value with others beside it", "change it a little")

    def by(self, quantity: Callable[[Scene], Any]) -> Any:
        """The derivative of quantity(Scene), a number or an array."""
        return (quantity(self.high) - quantity(self.low)) / self.span

    def law(self, kernel: Callable[..., Floats], rows: int, u: Floats) -> Floats:
        """The derivative of the law (`cohesive_law.traction` or `.tangent`), (k, rows, m), at u (k, 2, m), nm."""
        if self.profiles is None:
            return np.zeros((len(u), rows, u.shape[2]))
        x, z = u.swapaxes(0, 1)
        low, high = self.profiles[:, None] + z
        change = kernel(self.high, x, high) - kernel(self.low, x, low)
        return (change / self.span).swapaxes(0, 1)

    def complied(self, spectra: NDArray[np.complex128]) -> Floats | float:
        """dC T on the patch, (k, 2, m) nm per unit, of the `spectra` of tractions; 0.0 where C does not change."""
        if self.compliance is None:
            return 0.0
        spectra = spectra.copy()
        for spectrum in spectra:
            multiply(spectrum, self.compliance)
        return np.fft.irfft(spectra, self.low.nodes)[..., self.part]

    def traction(self, u: Floats) -> Floats:
        """dT (k, 2, m), GPa per unit, at fixed displacements u (k, 2, m), nm."""
        return self.law(cohesive_law.traction, 2, u)

    def stiffness(self, u: Floats) -> Floats:
        """dJ (k, 4, m), GPa/nm per unit, at fixed displacements u (k, 2, m), nm."""
        return self.law(cohesive_law.tangent, 4, u)


def spectra(T: Floats, part: slice, nodes: int) -> NDArray[np.complex128]:
    """Spectra over a cell of so many nodes of tractions T (k, 2, m), GPa, on its patch `part`."""
    whole = np.zeros((*T.shape[:2], nodes))
    whole[..., part] = T
    return np.fft.rfft(whole)


def gradients(scene: Scene, T: Floats) -> Floats:
    """Derivatives of F_bar, L_bar and A_bar by T (2, m), (3, 2, m) per GPa."""
    m, out = T.shape[1], np.zeros((3, 2, T.shape[1]))
    scale = 1.0 / (scene.nodes * scene.E) if m > 1 else 1.0 / scene.E
    out[0, 0], out[1, 1] = -scale, scale
    if m > 1:
        out[2, 1] = _area(scene, T[1])
    return out


def _area(scene, T_z):
    """d A_bar/d T_z (m,), per GPa; nonzero for the two nodes at each edge, between which the area is interpolated."""
    m, n, out = T_z.size, scene.nodes, np.zeros(T_z.size + 2)
    T = np.concatenate([[0.0], T_z, [0.0]]) if m < n else np.concatenate([T_z[-1:], T_z, T_z[:1]])
    T -= least_repulsion(scene)
    i = np.arange(m + 1 if m < n else m)
    # where T_z is repulsive at p and not at q, the share T_p/(T_p - T_q) of the spacing between them is in contact
    for p, q in ((i, i + 1), (i + 1, i)):
        edge = (T[p] > 0.0) & (T[q] <= 0.0)
        p, q = p[edge], q[edge]
        square = (T[p] - T[q]) ** 2
        np.add.at(out, p, -T[q] / square)
        np.add.at(out, q, T[p] / square)
    if m == n:
        out[-2] += out[0]
    return out[1:-1] / n


def over_own(scene: Scene, name: str, outputs: Floats, by: Floats) -> Floats:
    """Derivatives of U_x, forces and area by a parameter, from those `by` (4, ...) of U_x, F_bar, L_bar and A_bar.

    outputs (4, ...): the values. The results refer to forces over the present w E, and to the area over the present w.
    """
    per_unit = {"E": np.array([0.0, 1.0, 1.0, 0.0]) / scene.E, "width": np.array([0.0, 1.0, 1.0, 1.0]) / scene.width}
    return by + (outputs.T * per_unit[name]).T if name in per_unit else by


def explicit(scene: Scene, outputs: Floats, change: Change) -> Floats:
    """Derivatives of F_bar, L_bar and A_bar, `outputs` (3, ...), at fixed tractions, as the forces are over w E."""
    return (-outputs.T / scene.E * [1.0, 1.0, 0.0]).T if change.name == "E" else np.zeros_like(outputs)
