"""The adhesive cylinder: pull-off and load over contact width, held against Maugis-Dugdale (Baney & Hui 1997) and JKR.

One spring per node (a >> delta_t, no friction), a thick and nearly incompressible layer (then K_c ~ 0 and no node moves
sideways), a cell much wider than the contact. The punch is lowered, then raised: the least load is the pull-off.
Scaled: a' = a/[2 (w_a R^2/(pi E*))^(1/3)], P' = P/(pi E* w_a^2 R)^(1/3), lambda = 4 s0/(pi^2 E*^2 w_a/R)^(1/3).
"""

import numpy as np

from ..run.loadpath import load_path
from ..scene import Scene

PULL_OFF_JKR = -3.0 / 16.0 ** (1.0 / 3.0)  # P'


def load_maugis(lam, m):
    """(a', P') where the cohesive zone reaches to m times the half-width of the contact (Baney & Hui 1997)."""
    mu = np.sqrt(m * m - 1.0)
    one = lam / 2.0 * (m * mu - np.log(m + mu))
    two = lam**2 / 2.0 * (mu * np.log(m + mu) - m * np.log(m))
    a = 2.0 / (two + np.sqrt(two * two + 4.0 * one))  # the positive root of one a'^2 + two a' = 1
    return a, a * a - lam * a * mu


def pull_off_maugis(lam):
    """The least P' at that lambda."""
    return float(load_maugis(lam, 1.0 + np.geomspace(1e-5, 1e4, 4000))[1].min())


def repulsive_jkr(load):
    """Half-width under repulsion, scaled as a', at P' = a'^2 - 2 sqrt(a'): where JKR's pressure passes through zero."""
    a = np.linspace(1.0, 3.0, 4001)
    return np.interp(load, a * a - 2.0 * np.sqrt(a), np.sqrt(np.maximum(a * a - np.sqrt(a), 0.0)))


def scene_of(lam, nodes):
    """A Scene of that lambda, where s0 = phi_n/(e delta_n) is NP1's largest pull; 20 units of half-width wide."""
    E, nu, phi_n = 7.0, 0.4999, 2.0
    stiff, s0 = E / (1.0 - nu**2), phi_n / np.e
    R = (np.pi * stiff) ** 2 * phi_n * (lam / (4.0 * s0)) ** 3
    width = 40.0 * (phi_n * R**2 / (np.pi * stiff)) ** (1.0 / 3.0)
    values = {"E": E, "nu": nu, "phi_n": phi_n, "phi_ratio": 0.0, "width": width, "nodes": nodes, "radius": R / width}
    # a/delta_t = 5: the neighbours' springs act by exp(-25)
    return Scene(delta_t=width / nodes / 5.0, delta_bar=0.4, du_z=0.2, du_x=1.0, u_x_max=0.0, **values)


def retraction(lam, nodes=1024):
    """(P', half-width under repulsion as a') of every increment while the punch is raised again, until it is free."""
    scene = scene_of(lam, nodes)
    stiff, R = scene.E / (1.0 - scene.nu**2), scene.radius * scene.width
    unit_P = (np.pi * stiff * scene.phi_n**2 * R) ** (1.0 / 3.0)
    unit_a = 2.0 * (scene.phi_n * R**2 / (np.pi * stiff)) ** (1.0 / 3.0)
    pressure, area = raised(scene)
    return pressure * scene.width / unit_P, 0.5 * area * scene.width / unit_a


def raised(scene):
    """(mean pressure GPa, A_bar) of every increment, of du_z, while the punch is raised until it is free."""
    curve = []
    for frame in load_path(scene.changed(path="unload")):
        if frame.stage == "unload":
            curve.append((frame.L_bar * scene.E, frame.A_bar))
            if frame.A_bar == 0.0 and curve[-1][0] > 0.5 * min(curve)[0]:
                break
    return np.array(curve).T


def cylinder():
    """[(name, relative error, tolerance, reason, source)]."""
    rows, baney = [], "Baney & Hui 1997"
    law = "NP1 pulls over a tail where Maugis-Dugdale pulls evenly; the difference dies out as lambda grows"
    for lam, allowed in ((1.0, 0.08), (2.0, 0.03), (4.0, 0.01)):
        load, half = retraction(lam)
        error = abs(load.min() / pull_off_maugis(lam) - 1.0)
        rows.append((f"Maugis-Dugdale cylinder: pull-off at lambda = {lam:g}", error, allowed, law, baney))
    error = abs(load.min() / PULL_OFF_JKR - 1.0)
    rows.append(("JKR cylinder: pull-off at lambda = 4", error, 0.01, "lambda is finite: Maugis-Dugdale lies 0.1% off",
                 "Barquins 1988"))  # fmt: skip
    firm = (load > -0.8) & (half > 0.0)
    error = np.abs(half[firm] / repulsive_jkr(load[firm]) - 1.0).max()
    rows.append(("JKR cylinder: repulsive width over load at lambda = 4", float(error), 0.03,
                 "lambda is finite; the cell is 14 contacts wide, (pi a/w)^2/3 = 2%", "Barquins 1988"))  # fmt: skip
    return rows
