"""The wavy half-plane against closed forms: without adhesion (Westergaard 1939) and with it (Johnson 1995).

As in `cylinder`: one spring per node, a nearly incompressible layer as thick as the cell is wide, no friction. With
psi = pi a/lambda of the half-width a, p* = pi E* A/lambda of the amplitude A and alpha^2 = 2 lambda w_a/(pi E* A)^2:

    p/p* = sin^2 psi - alpha sqrt(tan psi),  mean pressure p (doi:10.1016/0020-7683(95)00111-9); alpha = 0: Westergaard.
"""

import numpy as np

from ..run.loadpath import load_path
from ..scene import Scene
from .cylinder import raised

E, NU = 7.0, 0.4999  # GPa
STIFF = E / (1.0 - NU**2)
DEEP = 500.0  # delta_n, amplitude of the wave on which the range of the law does not show
WEAK = 0.01  # alpha where adhesion does not show
PSI = np.linspace(0.0, 0.5 * np.pi, 20001)[1:-1]


def johnson(alpha, psi=PSI):
    """p/p* at the half-width psi of the contact, in which the edges are cracks."""
    return np.sin(psi) ** 2 - alpha * np.sqrt(np.tan(psi))


def repulsive(alpha, psi=PSI):
    """The part of the cell, A_bar, in which Johnson's pressure is positive.

    p/p* = 2 cos x (sin^2 psi - sin^2 x - alpha sqrt(tan psi)/2) / sqrt(sin^2 psi - sin^2 x) at x: Westergaard's, less
    that of Koiter's row of cracks.
    """
    return np.arcsin(np.sqrt(np.maximum(np.sin(psi) ** 2 - 0.5 * alpha * np.sqrt(np.tan(psi)), 0.0))) / (0.5 * np.pi)


def pull_off(alpha):
    """(psi, p/p*) of the least load on the branch of partial contact."""
    load = johnson(alpha)
    k = int(np.argmax((load[1:-1] < load[:-2]) & (load[1:-1] <= load[2:]))) + 1
    return PSI[k], load[k]


def reached(alpha, load):
    """A_bar of the stable partial contact at that p/p*."""
    least, _ = pull_off(alpha)
    psi = PSI[least < PSI]
    psi = psi[: int(np.argmax(johnson(alpha, psi))) + 1]
    return np.interp(load, johnson(alpha, psi), repulsive(alpha, psi))


def scene_of(width, amplitude, phi_n, nodes=512, **values):
    """A Scene with one wave in the cell."""
    plain = {"E": E, "nu": NU, "phi_ratio": 0.0, "du_z": 0.5, "du_x": 1.0, "u_x_max": 0.0}
    # a/delta_t = 5: the neighbours' springs act by exp(-25)
    size = {"width": width, "nodes": nodes, "delta_t": width / nodes / 5.0}
    return Scene(surface="wave", waves=1, amplitude=amplitude, phi_n=phi_n, **size, **plain, **values)


def short_ranged(lam, alpha):
    """The Scene of a wave of that alpha whose crest, of radius lambda^2/(4 pi^2 A), is a cylinder of Maugis's lam."""
    phi_n = 2.0
    R = (np.pi * STIFF) ** 2 * phi_n * (lam * np.e / (4.0 * phi_n)) ** 3
    width = (32.0 * np.pi**2 * phi_n * R**2 / (STIFF * alpha**2)) ** (1.0 / 3.0)
    return scene_of(width, width**2 / (4.0 * np.pi**2 * R), phi_n, delta_bar=0.5)


def adhesive(lam, alpha=0.3):
    """(error of the pull-off load, largest error of A_bar over load) while the wave is raised from the flat."""
    scene = short_ranged(lam, alpha)
    pressure, area = raised(scene)
    load, least = pressure * scene.width / (np.pi * STIFF * scene.amplitude), pull_off(alpha)[1]
    firm = (area > 0.0) & (load > 0.5 * least)
    return float(abs(load.min() / least - 1.0)), float(np.abs(area[firm] / reached(alpha, load[firm]) - 1.0).max())


def hard(deep=DEEP, alpha=WEAK):
    """Largest error of A_bar over load, at 0.3 and more, of a wave of `deep` delta_n pressed on with weak adhesion."""
    width = 25.0 * deep
    phi_n = (alpha * np.pi * deep) ** 2 * STIFF / (2.0 * width)
    scene = scene_of(width, deep, phi_n, nodes=256, delta_bar=0.08 * deep).changed(du_z=1.0)
    pressure, area = np.array([(f.L_bar * scene.E, f.A_bar) for f in load_path(scene) if f.delta > 0.0]).T
    firm = area > 0.3
    expected = np.arcsin(np.sqrt(pressure[firm] * width / (np.pi * STIFF * deep))) / (0.5 * np.pi)
    return float(np.abs(area[firm] / expected - 1.0).max())


def wave():
    """[(name, relative error, tolerance, reason, source)]."""
    law = "NP1 pulls over a tail where Johnson pulls at a point; the difference dies out as lambda grows"
    rows = []
    for lam, allowed in ((2.0, 0.05), (4.0, 0.01)):
        load, area = adhesive(lam)
        rows += [
            (f"Johnson's adhesive wave: pull-off at lambda = {lam:g}, alpha = 0.3", load, allowed, law, "Johnson 1995"),
            (f"Johnson's adhesive wave: area over load at lambda = {lam:g}", area, allowed, law, "Johnson 1995"),
        ]
    soft = "the surfaces overlap by 2 delta_n, the amplitude is 500, and alpha = 0.01; 1.3% at 1000 with 512 nodes"
    return [*rows, ("Westergaard's wave: area over load", hard(), 0.03, soft, "Westergaard 1939")]
