"""Adhesion without friction against closed forms: a cylinder and a wave, lowered and raised until they are free.

One spring per node (a >> delta_t), a thick and nearly incompressible layer (K_c ~ 0: no node moves sideways), a cell
much wider than the contact of the cylinder. The least load while the punch is raised is the pull-off.

Cylinder, JKR (Barquins 1988) and Maugis-Dugdale (Baney & Hui 1997): a' = a/[2 (w_a R^2/(pi E*))^(1/3)],
P' = P/(pi E* w_a^2 R)^(1/3), lambda = 4 s0/(pi^2 E*^2 w_a/R)^(1/3), s0 the largest pull.
Wave of amplitude A, Westergaard (1939) and Johnson (1995, doi:10.1016/0020-7683(95)00111-9): psi = pi a/lambda of the
half-width a, p* = pi E* A/lambda, alpha^2 = 2 lambda w_a/(pi E* A)^2, p/p* = sin^2 psi - alpha sqrt(tan psi).
"""

from typing import NamedTuple

import numpy as np
from form import Form

from solver.run.loadpath import load_path
from solver.scene import Scene

E, NU, PHI_N = 7.0, 0.4999, 2.0  # GPa, 1, N/m
STIFF = E / (1.0 - NU**2)
PULL_OFF_JKR = -3.0 / 16.0 ** (1.0 / 3.0)  # P'
PSI = np.linspace(0.0, 0.5 * np.pi, 20001)[1:-1]
DEEP = 500.0  # delta_n, amplitude of the wave at which the range of the law is negligible
WEAK = 0.01  # alpha at which adhesion is negligible


class Raised(NamedTuple):
    """The curve of a punch while it is raised, a point per increment of du_z: mean pressure (GPa) and A_bar."""

    pressure: np.ndarray
    area: np.ndarray


def adhesion() -> list[Form]:
    """Every Form of the cylinder and the wave."""
    return [*cylinder(), *wave()]


def cylinder() -> list[Form]:
    """Pull-off and width over load of the cylinder."""
    forms = []
    law = "NP1 pulls over a tail where Maugis-Dugdale pulls evenly; the difference vanishes as lambda grows"
    for lam, allowed in ((1.0, 0.08), (2.0, 0.03), (4.0, 0.01)):
        load, half = retraction(lam)
        error = abs(load.min() / pull_off_maugis(lam) - 1.0)
        name = f"Maugis-Dugdale cylinder: pull-off at lambda = {lam:g}"
        forms.append(Form(name, error, allowed, law, "Baney & Hui 1997"))
    error, reason = abs(load.min() / PULL_OFF_JKR - 1.0), "lambda is finite: Maugis-Dugdale lies 0.1% off"
    forms.append(Form("JKR cylinder: pull-off at lambda = 4", error, 0.01, reason, "Barquins 1988"))
    firm = (load > -0.8) & (half > 0.0)
    error = float(np.abs(half[firm] / repulsive_jkr(load[firm]) - 1.0).max())
    reason = "lambda is finite; the cell is 14 contacts wide, (pi a/w)^2/3 = 2%"
    return [
        *forms,
        Form("JKR cylinder: repulsive width over load at lambda = 4", error, 0.03, reason, "Barquins 1988"),
    ]


def wave() -> list[Form]:
    """Pull-off and area over load of the wave, with adhesion and without."""
    law = "NP1 pulls over a tail where Johnson pulls at a point; the difference vanishes as lambda grows"
    forms, source = [], "Johnson 1995"
    for lam, allowed in ((2.0, 0.05), (4.0, 0.01)):
        load, area = adhesive(lam)
        name = f"Johnson's adhesive wave: pull-off at lambda = {lam:g}, alpha = 0.3"
        forms.append(Form(name, load, allowed, law, source))
        forms.append(Form(f"Johnson's adhesive wave: area over load at lambda = {lam:g}", area, allowed, law, source))
    soft = "the surfaces overlap by 2 delta_n, the amplitude is 500, and alpha = 0.01; 1.3% at 1000 with 512 nodes"
    return [*forms, Form("Westergaard's wave: area over load", hard(), 0.03, soft, "Westergaard 1939")]


def load_maugis(lam, m) -> tuple[np.ndarray, np.ndarray]:
    """(a', P') where the cohesive zone reaches to m times the half-width of the contact (Baney & Hui 1997)."""
    mu = np.sqrt(m * m - 1.0)
    square = lam / 2.0 * (m * mu - np.log(m + mu))
    linear = lam**2 / 2.0 * (mu * np.log(m + mu) - m * np.log(m))
    a = 2.0 / (linear + np.sqrt(linear * linear + 4.0 * square))  # the positive root of square a'^2 + linear a' = 1
    return a, a * a - lam * a * mu


def pull_off_maugis(lam: float) -> float:
    """The least P' at that lambda."""
    return float(load_maugis(lam, 1.0 + np.geomspace(1e-5, 1e4, 4000))[1].min())


def repulsive_jkr(load) -> np.ndarray:
    """Half-width under repulsion, scaled as a', at P' = a'^2 - 2 sqrt(a'): where JKR's pressure passes through zero."""
    a = np.linspace(1.0, 3.0, 4001)
    return np.interp(load, a * a - 2.0 * np.sqrt(a), np.sqrt(np.maximum(a * a - np.sqrt(a), 0.0)))


def johnson(alpha, psi=PSI) -> np.ndarray:
    """p/p* at the half-width psi of the contact, whose edges are cracks; alpha = 0: Westergaard."""
    return np.sin(psi) ** 2 - alpha * np.sqrt(np.tan(psi))


def repulsive(alpha, psi=PSI) -> np.ndarray:
    """The part of the cell, A_bar, in which Johnson's pressure is positive.

    p/p* = 2 cos x (sin^2 psi - sin^2 x - alpha sqrt(tan psi)/2) / sqrt(sin^2 psi - sin^2 x) at x: Westergaard's, less
    that of Koiter's row of cracks.
    """
    return np.arcsin(np.sqrt(np.maximum(np.sin(psi) ** 2 - 0.5 * alpha * np.sqrt(np.tan(psi)), 0.0))) / (0.5 * np.pi)


def pull_off(alpha) -> tuple[float, float]:
    """(psi, p/p*) of the least load on the branch of partial contact."""
    load = johnson(alpha)
    k = int(np.argmax((load[1:-1] < load[:-2]) & (load[1:-1] <= load[2:]))) + 1
    return PSI[k], load[k]


def _scene(width, nodes, **values):
    """A Scene of that width (nm) without friction; a/delta_t = 5: the neighbours' springs act by exp(-25)."""
    plain = {"E": E, "nu": NU, "phi_n": PHI_N, "phi_ratio": 0.0, "du_x": 1.0, "u_x_max": 0.0}
    return Scene(width=width, nodes=nodes, delta_t=width / nodes / 5.0, **(plain | values))


def _radius(lam):
    """nm, of the cylinder of that lambda, where s0 = phi_n/(e delta_n) is NP1's largest pull."""
    return (np.pi * STIFF) ** 2 * PHI_N * (lam * np.e / (4.0 * PHI_N)) ** 3


def retraction(lam: float) -> tuple[np.ndarray, np.ndarray]:
    """(P', half-width under repulsion as a') of a cylinder of that lambda while it is raised."""
    R = _radius(lam)
    half = 2.0 * (PHI_N * R**2 / (np.pi * STIFF)) ** (1.0 / 3.0)
    scene = _scene(20.0 * half, 1024, radius=R / (20.0 * half), delta_bar=0.4, du_z=0.2)
    pressure, area = raised(scene)
    unit = (np.pi * STIFF * PHI_N**2 * R) ** (1.0 / 3.0)
    return pressure * scene.width / unit, 0.5 * area * scene.width / half


def raised(scene: Scene) -> Raised:
    """The Raised punch of a scene, until it is free."""
    curve = []
    for frame in load_path(scene.changed(path="unload")):
        if frame.stage == "unload":
            curve.append((frame.L_bar * scene.E, frame.A_bar))
            if frame.A_bar == 0.0 and curve[-1][0] > 0.5 * min(curve)[0]:
                break
    return Raised(*np.array(curve).T)


def adhesive(lam: float, alpha: float = 0.3) -> tuple[float, float]:
    """(error of the pull-off load, largest error of A_bar over load) of a wave while it is raised from the flat.

    Its crest, of radius lambda^2/(4 pi^2 A), is a cylinder of Maugis's `lam`.
    """
    R = _radius(lam)
    width = (32.0 * np.pi**2 * PHI_N * R**2 / (STIFF * alpha**2)) ** (1.0 / 3.0)
    amplitude = width**2 / (4.0 * np.pi**2 * R)
    scene = _scene(width, 512, surface="wave", waves=1, amplitude=amplitude, delta_bar=0.5, du_z=0.5)
    pressure, area = raised(scene)
    edge, least = pull_off(alpha)
    load = pressure * width / (np.pi * STIFF * amplitude)
    firm, psi = (area > 0.0) & (load > 0.5 * least), PSI[edge < PSI]
    psi = psi[: int(np.argmax(johnson(alpha, psi))) + 1]  # the stable partial contact
    expected = np.interp(load[firm], johnson(alpha, psi), repulsive(alpha, psi))
    return float(abs(load.min() / least - 1.0)), float(np.abs(area[firm] / expected - 1.0).max())


def hard(deep: float = DEEP, alpha: float = WEAK) -> float:
    """Largest error of A_bar over load, at 0.3 and more, of a wave of `deep` delta_n pressed on with weak adhesion."""
    width = 25.0 * deep
    phi_n = (alpha * np.pi * deep) ** 2 * STIFF / (2.0 * width)
    shape = {"surface": "wave", "waves": 1, "amplitude": deep}
    scene = _scene(width, 256, phi_n=phi_n, delta_bar=0.08 * deep, du_z=1.0, **shape)
    pressure, area = np.array([(f.L_bar * scene.E, f.A_bar) for f in load_path(scene) if f.delta > 0.0]).T
    firm = area > 0.3
    expected = np.arcsin(np.sqrt(pressure[firm] * width / (np.pi * STIFF * deep))) / (0.5 * np.pi)
    return float(np.abs(area[firm] / expected - 1.0).max())
