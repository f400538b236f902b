"""The smallest residual of an equilibrium that double precision resolves."""

from math import e, hypot, pi, sqrt
from sys import float_info
from typing import Any


def attainable(scene: Any) -> float:
    """Smallest residual of a Scene that double precision resolves, nm: round-off of u, amplified by the interface.

    A displacement u has the error eps u, its traction eps u times the interface's stiffness. These errors are
    independent from node to node. The layer multiplies them by the root mean square of its compliance over all modes,
    ((c^2 + 4 k (h/G)^2)/nodes)^1/2, with k the number of waves longer than h and c the compliance of layer and drive to
    a uniform traction. Flat on flat, all nodes share one error, but at a gap where the interface has a tenth of its
    largest stiffness.
    """
    stiffness = max(scene.phi_n / scene.delta_n**2, 2.0 * scene.phi_t / scene.delta_t**2)
    h, nu = scene.height * scene.width, scene.nu
    long_waves = (3.0 - 4.0 * nu) / (8.0 * pi * (1.0 - nu)) / scene.height
    layer, driven = h / scene.shear_modulus, h / scene.shear_modulus + max(scene.drive_compliance)
    amplified = min(driven, hypot(driven, 2.0 * sqrt(long_waves) * layer) / sqrt(scene.nodes))
    if scene.surface == "flat":
        amplified = 0.1 * driven
    # how far adhesion can draw the surface down: the layer as a whole and a wave as long as the cell
    compliance = (1.0 - 2.0 * nu) / (2.0 * (1.0 - nu)) * h + min(h, long_waves * h)
    drawn = (compliance / scene.shear_modulus + scene.drive_compliance[1]) * scene.phi_n / (e * scene.delta_n)
    largest = scene.farthest + scene.delta_0 + abs(scene.deepest) + min(drawn, 0.5 * float(scene.profile.max()))
    # on soft scenes, the largest measured round-off of a residual is twice the estimate
    return 2.0 * float_info.epsilon * largest * stiffness * amplified
