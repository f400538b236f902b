"""Problems with published solutions, each with the error reached and the one allowed."""

from math import inf

import numpy as np
from adhesion import adhesion
from extended import displacement, springs
from form import Form, relative
from helpers import on_whole_cell
from scipy.linalg import expm
from scipy.optimize import brentq

from solver.mechanics import cohesive_law
from solver.mechanics.layer import Convolution, Modes, compliance, stiffness
from solver.run.loadpath import load_path
from solver.scene import Scene


def closed_forms() -> list[Form]:
    """Every Form."""
    return [form for problem in PROBLEMS for form in problem()]


def prandtl_tomlinson() -> list[Form]:
    """Flat on flat: load U(u) = u - T(u) h/G of one node; its maximum is the fold, where the force drops."""
    cell = {"nodes": 64, "width": 156.25, "height": 16.0}  # the layer of the default; nodes of a flat are all alike
    scene = Scene(surface="flat", phi_ratio=0.1, u_x_max=18.0, damping=inf, tolerance=1e-12, **cell)
    flexibility = scene.height * scene.width / scene.shear_modulus

    def pull(u):
        return -float(springs(scene, np.array([u]), np.zeros(1))[0][0, 0])

    def load(u):
        return u + pull(u) * flexibility

    top = brentq(lambda u: load(u + 1e-5) - load(u - 1e-5), 0.0, 0.5 * scene.spacing, xtol=1e-15)
    shear = [f for f in load_path(scene.changed(du_x=0.01)) if f.stage == "shear"]
    events = [event for f in shear for event in f.slips]
    expected = load(top) + scene.spacing * np.arange(len(events))
    after = next(f for f in shear if f.slip)
    u = brentq(lambda u: after.U_x - load(u), 0.5 * scene.spacing, scene.spacing + top, xtol=1e-15)
    drop = (events[0].F_bar - after.F_bar) * scene.E
    source, level = "Prandtl 1928; Tomlinson 1929", "1e-5 nm differences locate the maximum, where the load is level"
    root = "the force at the fold changes as the square root of the load's error"
    places, force = relative([e.load for e in events], expected), relative(drop, pull(top) - pull(u))
    return [
        Form("Prandtl-Tomlinson: load at every fold", places, 1e-9, level, source),
        Form("Prandtl-Tomlinson: drop of the force at the first fold", force, 1e-6, root, source),
        Form("Prandtl-Tomlinson: where it lands", relative(after.u[0].max(), u), 1e-10, "tolerance 1e-12 nm", source),
    ]


def periodic_series() -> list[Form]:
    """T(x) of springs in registry: 4 pi^1.5 phi_t delta_t/a^2 sum_m m exp(-(pi m delta_t/a)^2) sin(2 pi m x/a)."""
    worst = 0.0
    for a in (1.5, 2.0, 2.44, 3.0, 5.0):
        scene = Scene(nodes=100, width=100 * a, phi_n=1.0, window_t=8.0)
        x, m = np.linspace(0.0, a, 201), np.arange(1, 30)[:, None]
        terms = m * np.exp(-((np.pi * m / a) ** 2)) * np.sin(2 * np.pi * m * x / a)
        series = -4.0 * np.pi**1.5 / a**2 * terms.sum(axis=0)
        worst = max(worst, relative(cohesive_law.traction(scene, x, np.zeros_like(x))[0], series))
    reason = "window_t = 8 cuts springs of exp(-64); at a = 1.5 six digits cancel in the sum's extremes"
    return [Form("springs in registry: periodic series", worst, 1e-12, reason, "Poisson's summation of paper Eq. 2")]


def carbone_mangialardi() -> list[Form]:
    """u_z of a bonded frictionless layer under p cos qx, for q h from 0.03 to 300."""
    E, height, worst = 70.0, 25.0, 0.0
    q = np.geomspace(0.03, 300.0, 80) / height
    for nu in (0.0, 0.3, 0.45, 0.4999):
        y = np.longdouble(1) * q * height
        above = (3 - 4 * nu) * np.sinh(2 * y) - 2 * y
        below = 5 + 2 * y**2 - 4 * nu * (3 - 2 * nu) + (3 - 4 * nu) * np.cosh(2 * y)
        expected = 2 * (1 - nu**2) / (E * q) * above / below
        worst = max(worst, float(np.abs(compliance(q, height, E, nu)[1] / expected - 1).max()))
    source = "Carbone & Mangialardi 2008, J. Mech. Phys. Solids 56"
    return [Form("bonded layer: frictionless compliance", worst, 1e-14, "a few roundings of each factor", source)]


def navier() -> list[Form]:
    """K of the layer from Navier's equations as an initial-value problem over its height: magnitudes, sign of K_c."""
    worst, coupling = 0.0, 0.0
    for nu in (0.0, 0.3, 0.45):
        for q in (0.01, 0.03, 0.1):
            K = _propagated(q, 30.0, 70.0, nu)
            k_xx, k_zz, k_c = (float(k[0]) for k in stiffness(np.array([q]), 30.0, 70.0, nu))
            worst = max(worst, abs(K[0, 0] / k_xx - 1.0), abs(K[1, 1] / k_zz - 1.0))
            coupling = max(coupling, abs(K[0, 1] + 1j * k_c) / k_xx, abs(K[1, 0] - 1j * k_c) / k_xx)
    reason, source = "the propagator grows as exp(q h) = 20 and is inverted", "Navier; signs of solver/__init__.py"
    return [
        Form("layer: K_xx, K_zz from Navier's equations", float(worst), 1e-11, reason, source),
        Form("layer: K_c and its sign from Navier's equations", float(coupling), 1e-11, reason, source),
    ]


def _propagated(q, height, E, nu):
    """K (2, 2) complex, GPa/nm: tractions on the lower surface for unit displacements of it, the top held.

    State (u_x, u_z, s_xz, s_zz) of the mode exp(i q x), plane strain: its derivative along z is a constant matrix, from
    Hooke's law and equilibrium. The traction on the layer's lower side is -(s_xz, s_zz).
    """
    mu = E / (2.0 * (1.0 + nu))
    lam = 2.0 * mu * nu / (1.0 - 2.0 * nu)
    p, iq = lam + 2.0 * mu, 1j * q
    rate = np.array(
        [
            [0.0, -iq, 1.0 / mu, 0.0],
            [-iq * lam / p, 0.0, 0.0, 1.0 / p],
            [-(iq**2) * (p - lam**2 / p), 0.0, 0.0, -iq * lam / p],
            [0.0, 0.0, -iq, 0.0],
        ]
    )
    scale = np.array([1.0, 1.0, mu * q, mu * q])  # numbers of one size
    over = expm(rate * height / scale[:, None] * scale)
    return np.linalg.solve(over[:2, 2:], over[:2, :2]) * mu * q


def force_balance() -> list[Form]:
    """F/w and L/w are what the layer carries at its top: G/h (U_x - mean u_x) and K_zz(0) (mean u_z + delta)."""
    scene = Scene(nodes=256, width=625.0, delta_bar=0.2, nu=0.3, du_z=0.5, du_x=0.5, u_x_max=10.0, tolerance=1e-11)
    G, h = scene.shear_modulus, scene.height * scene.width
    k_z = 2.0 * G * (1.0 - scene.nu) / ((1.0 - 2.0 * scene.nu) * h)
    shear = [f for f in on_whole_cell(scene) if f.stage == "shear"]
    F = [G / h * (f.U_x - f.u[0].mean()) / scene.E for f in shear]
    L = [k_z * (f.u[1].mean() + f.delta) / scene.E for f in shear]
    reason = "tolerance 1e-11 nm over the mean displacement of 0.1 nm and more"
    return [
        Form("force balance: F at the top of the layer", relative([f.F_bar for f in shear], F), 1e-8, reason, "Eq. 6"),
        Form("force balance: L at the top of the layer", relative([f.L_bar for f in shear], L), 1e-8, reason, "Eq. 6"),
    ]


def full_sums() -> list[Form]:
    """C T by pyFFTW in float64, on a patch, against the sum over all modes in long double."""
    worst = 0.0
    for nodes, size in ((128, 40), (127, 127), (131, 60), (4096, 300)):
        scene = Scene(nodes=nodes, width=2.4 * nodes, height=0.05, nu=0.49)
        T = np.zeros((2, nodes))
        T[:, :size] = np.random.default_rng(size).normal(size=(2, size))
        response = Convolution(Modes.of(scene), size)
        response.field[:] = T[:, :size]
        response.apply()
        worst = max(worst, relative(response.product, displacement(scene, T.astype(np.longdouble))[0][:, :size]))
    return [Form("elastic response on a patch: all modes", worst, 1e-13, "transforms of 4096 points", "definition")]


def translated() -> list[Form]:
    """An equilibrium shifted by a lattice site is one at a load shifted as much: forces repeat with the period a."""
    scene = Scene(nodes=64, width=160.0, radius=0.5, du_z=0.5, u_x_max=22.0, tolerance=1e-11)
    scene = scene.changed(du_x=scene.spacing / 10.0)
    F = [f.F_bar for f in load_path(scene, replay=False) if f.stage == "shear"]
    error = relative(F[-11:], F[-21:-10])
    return [
        Form("sliding repeats with the lattice", error, 1e-7, "tolerance 1e-11 nm, amplified near folds", "symmetry")
    ]


PROBLEMS = (
    prandtl_tomlinson,
    periodic_series,
    adhesion,
    carbone_mangialardi,
    navier,
    force_balance,
    full_sums,
    translated,
)
