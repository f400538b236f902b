"""The paper's GFMD, written as plainly as possible: a reference that shares nothing with the solver but Scene.

The whole surface of the layer, every node, moves in Fourier space with unit mass for every mode,
u'' = K (U - u) + T(u) - gamma u', gamma = 2 damping sqrt(k_min), by the Verlet scheme, from rest to rest, increment by
increment. With damping = inf it moves by u' = K (U - u) + T(u): the layer's part is exact, T(u) is kept over a step.
Under a held load the top is massless: the uniform normal mode has no stiffness and bears the mean pressure p0 at the
end of the approach. At rest means max |U + C T(u) - u| <= tolerance at two looks in a row.

    for record in run(Scene(nodes=256, width=625.0)): print(record.stage, record.load, record.F_bar)
"""

from collections import namedtuple
from math import ceil, exp, floor

import numpy as np
import pyfftw
from numba import njit

LOOK_EVERY = 25  # steps between two looks at the residual
BUDGET = 400_000  # force evaluations from rest to rest; 40 times what a usual slip takes
POTENTIAL = {
    "np1": False,
    "xu-needleman": True,
}  # {law: whether T_x has the factor 1 + dn/delta_n}, as `springs` has it
OVERDAMPED = 0.25  # of the stability limit: the scheme is of first order, and accuracy asks for less than stability
Record = namedtuple("Record", "stage index load F_bar L_bar A_bar u delta residual evaluations")  # load: delta or U_x
Rest = namedtuple("Rest", "u U_z T residual")  # (2, nodes) nm, nm, (2, nodes) GPa, nm


class NoRest(Exception):
    """The motion does not come to rest: it continues, diverges, or the contact has pulled off."""


class Plain:
    """The motion of one scene; fraction: of the largest stable time step. Counts its force evaluations.

    restless: accept a state that still moves when the budget is spent (it flutters); its residual shows it.
    """

    def __init__(self, scene, fraction=0.5, tolerance=None, budget=BUDGET, restless=False):
        self.scene, self.fraction, self.tolerance = scene, fraction, tolerance or scene.tolerance
        self.budget, self.restless, self.evaluations = budget, restless, 0
        self.n, self.gap = scene.nodes, scene.profile
        xx, zz, c = self.K = stiffness(scene)
        self.C = np.array([zz, xx, -c]) / (xx * zz - c * c)
        mean, spread = 0.5 * (xx + zz), np.hypot(0.5 * (xx - zz), c)
        self.k_min, self.k_max = float((mean - spread).min()), float((mean + spread).max())
        lengths = scene.delta_n, scene.delta_t, scene.spacing, scene.window_t * scene.delta_t
        self.law = scene.phi_n / scene.delta_n, 2.0 * scene.phi_t / scene.delta_t, *lengths, POTENTIAL[scene.law]
        self.u, self.T = pyfftw.zeros_aligned((2, self.n)), pyfftw.zeros_aligned((2, self.n))
        self.spectrum = pyfftw.zeros_aligned((2, self.n // 2 + 1), dtype=complex)
        plan = {"axes": (1,), "flags": ("FFTW_ESTIMATE",)}  # measured plans, hence round-off, differ from run to run
        self._forward = pyfftw.FFTW(self.T, self.spectrum, **plan).execute
        self._backward = pyfftw.FFTW(self.spectrum, self.u, direction="FFTW_BACKWARD", **plan).execute

    def rest(self, u, U_x, U_z, p0=None):
        """The Rest reached from rest at u (2, nodes); p0 (GPa) holds the load, U_z follows. Raises NoRest."""
        for finer in (1, 4, 16):  # finer where surfaces clash so that it diverges
            if reached := self._moved(u, U_x, U_z, p0, self.fraction / finer):
                return reached
        raise NoRest(f"the motion diverges at U_x = {U_x:.6g}, U_z = {U_z:.6g}")

    def _moved(self, u, U_x, U_z, p0, fraction):
        """The Rest; None if the motion diverges."""
        modes, K, last, step, steepest = np.fft.rfft(u, norm="forward"), self.K.copy(), np.inf, None, 0.0
        K[1, 0] *= p0 is None
        motion, p0 = np.zeros_like(modes), p0 or 0.0
        for count in range(self.budget):
            self.spectrum[:] = modes
            self._backward()
            steep = springs(self.u, self.gap, self.law, self.T)
            self._forward()
            self.spectrum /= self.n
            self.spectrum[1, 0] -= p0
            self.evaluations += 1
            if count % LOOK_EVERY == 0:
                here, top = self.u.copy(), U_z if K[1, 0] else modes[1, 0].real
                residual = self._residual(modes, U_x, top)
                if not residual < 1e9:
                    return None
                if max(residual, last) <= self.tolerance or (self.restless and count + LOOK_EVERY >= self.budget):
                    return Rest(here, top - self.C[1, 0] * p0, self.T.copy(), residual)
                if p0 < 0.0 and (self.gap + here[1]).min() > self.scene.delta_0:
                    raise NoRest(f"pulled off at U_x = {U_x:.6g}")
                last = residual
            if count % LOOK_EVERY == 0 or steep > 1.2 * steepest:
                before, steepest = step, max(steep, 1e-3)
                step, keep, push = self._step(K, steepest, fraction)
                motion *= step / (before or step)
            move(modes, motion, self.spectrum, K, push, keep, U_x, U_z)
        raise NoRest(f"still moving at U_x = {U_x:.6g}, U_z = {U_z:.6g}: residual {residual:.2g} nm")

    def _step(self, K, steepest, fraction):
        """(step, keep, push): the next change of u is keep times the last one plus the matrix push times the force."""
        if np.isinf(self.scene.damping):
            step = fraction * OVERDAMPED * 2.0 / steepest
            value, vector = np.linalg.eigh(np.array([[K[0], K[2]], [K[2], K[1]]]).transpose(2, 0, 1))
            share = np.where(value > 0.0, -np.expm1(-step * value) / np.where(value > 0.0, value, 1.0), step)
            push = np.einsum("qik,qk,qjk->ijq", vector, share, vector)
            return step, 0.0, np.array([push[0, 0], push[1, 1], push[0, 1]])
        step = fraction * 2.0 / np.sqrt(self.k_max + steepest)
        half = self.scene.damping * np.sqrt(self.k_min) * step  # gamma step / 2
        return step, (1.0 - half) / (1.0 + half), np.array([[1.0], [1.0], [0.0]]) * step**2 / (1.0 + half) + 0.0 * K

    def _residual(self, modes, U_x, top):
        """max |U + C T(u) - u|, the mean of T_z less p0; spoils self.u and nothing else."""
        traction, (xx, zz, c) = self.spectrum.copy(), self.C
        self.spectrum[0] = xx * traction[0] - 1j * c * traction[1] - modes[0]
        self.spectrum[1] = zz * traction[1] + 1j * c * traction[0] - modes[1]
        self.spectrum[:, 0] += U_x, top
        self._backward()
        self.spectrum[:] = traction
        return float(np.abs(self.u).max())


def rest(scene, u, U_x, U_z=0.0, p0=None, fraction=0.5, tolerance=None):
    """The Rest that the motion reaches from u (2, nodes) at rest; p0 (GPa): the load is held."""
    return Plain(scene, fraction, tolerance).rest(u, U_x, U_z, p0)


def run(scene, fraction=0.5, tolerance=None, increment=Plain.rest, restless=False):
    """Yield the Records of the path (shear or loop) in order; raises NoRest.

    increment(plain, u, U_x, U_z, p0) returns a Rest; callers that study slips replace it. Under a held load U_z is that
    of the last Rest.
    """
    plain, p0 = Plain(scene, fraction, tolerance, restless=restless), None
    n, area, U_z = scene.shear_increments, 1.0 / (scene.nodes * scene.E), scene.delta_0
    far = [scene.shear_at(k) for k in range(-n, n + 1)]
    steps = range(scene.approach_increments + 1)
    approach = [min(scene.delta, k * scene.du_z * scene.delta_n - scene.delta_0) for k in steps]
    legs = [("approach", approach), ("shear", far[n:]), ("back", far[::-1]), ("forth", far)]
    u = np.array([[0.0], [U_z]]) * np.ones(plain.n)
    for stage, loads in legs if scene.path == "loop" else legs[:2]:
        for k, load in enumerate(loads):
            before, top = plain.evaluations, (0.0, -load) if stage == "approach" else (load, U_z)
            u, U_z, T, residual = increment(plain, u, *top, p0)
            F_bar, L_bar, spent = -T[0].sum() * area, T[1].sum() * area, plain.evaluations - before
            yield Record(stage, k, load, F_bar, L_bar, contact(T[1]), u, 0.0 - U_z, residual, spent)
        p0 = float(T[1].mean()) if scene.hold == "load" and p0 is None else p0


def contact(T_z):
    """Share of the interface under repulsion; its edges are where T_z, linear between nodes, changes its sign."""
    high, low = np.maximum(np.maximum(T_z, np.roll(T_z, -1)), 0.0), np.minimum(np.minimum(T_z, np.roll(T_z, -1)), 0.0)
    return float((high / np.maximum(high - low, 1e-300)).mean())


def stiffness(scene):
    """K of every mode, rows K_xx, K_zz, K_c with K_xz = -i K_c and K_zx = i K_c, (3, nodes // 2 + 1) GPa/nm."""
    h, nu, G = scene.height * scene.width, scene.nu, scene.shear_modulus
    q = 2.0 * np.pi * np.arange(1, scene.nodes // 2 + 1) / scene.width
    x, kappa, K = q * h, 3.0 - 4.0 * nu, np.zeros((3, q.size + 1))
    t, inverse = np.tanh(x), 4.0 * np.exp(-2.0 * x) / (1.0 + np.exp(-2.0 * x)) ** 2  # sinh / cosh, 1 / cosh^2
    D = kappa**2 * t * t - x * x * inverse
    K[0, 1:] = 4.0 * G * (1.0 - nu) * q * (kappa * t - x * inverse) / D
    K[1, 1:] = 4.0 * G * (1.0 - nu) * q * (kappa * t + x * inverse) / D
    K[2, 1:] = 2.0 * G * q * (kappa * (1.0 - 2.0 * nu) * t * t - x * x * inverse) / D
    K[:, 0] = G / h, 2.0 * G * (1.0 - nu) / ((1.0 - 2.0 * nu) * h), 0.0
    K[:2, 0] = 1.0 / (1.0 / K[:2, 0] + 1e3 / np.array([scene.drive_t, scene.drive_n]))  # springs in series, MPa/nm
    K[2, -1] *= scene.nodes % 2  # no coupling at the Nyquist mode
    return K


@njit(cache=True)
def springs(u, gap, law, T):
    """Fill T (2, nodes) with the NP1 tractions; the largest row sum of |dT/du| of a node, GPa/nm."""
    normal, sideways, delta_n, delta_t, a, reach, potential = law
    steepest, T[:] = 0.0, 0.0
    for i in range(gap.size):
        dn, s0, s1, s2 = (gap[i] + u[1, i]) / delta_n, 0.0, 0.0, 0.0
        for j in range(ceil((u[0, i] - reach) / a), floor((u[0, i] + reach) / a) + 1):
            dt = (j * a - u[0, i]) / delta_t
            g = exp(-dt * dt)
            s0, s1, s2 = s0 + g, s1 + dt * g, s2 + dt * dt * g
        e = exp(-dn)
        open_x, open_z = (1.0 + dn, dn) if potential else (1.0, 1.0)
        T[0, i], T[1, i] = sideways * s1 * open_x * e, -normal * dn * s0 * e
        x_stiff = sideways * e * (abs((s0 - 2.0 * s2) * open_x) / delta_t + abs(s1 * open_z) / delta_n)
        z_stiff = normal * e * (abs(2.0 * dn * s1) / delta_t + abs((1.0 - dn) * s0) / delta_n)
        steepest = max(steepest, x_stiff, z_stiff)
    return steepest


@njit(cache=True)
def move(modes, motion, spectrum, K, push, keep, U_x, U_z):
    """One step of all modes; spectrum: of T."""
    for q in range(modes.shape[1]):
        x, z = (modes[0, q] - U_x, modes[1, q] - U_z) if q == 0 else (modes[0, q], modes[1, q])
        f_x = spectrum[0, q] - K[0, q] * x + 1j * K[2, q] * z
        f_z = spectrum[1, q] - K[1, q] * z - 1j * K[2, q] * x
        motion[0, q] = keep * motion[0, q] + push[0, q] * f_x - 1j * push[2, q] * f_z
        motion[1, q] = keep * motion[1, q] + push[1, q] * f_z + 1j * push[2, q] * f_x
        modes[0, q], modes[1, q] = modes[0, q] + motion[0, q], modes[1, q] + motion[1, q]
