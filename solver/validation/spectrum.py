"""Whether a frame rests under the paper's motion: the rates of all small disturbances of the whole surface.

The motion is u'' = K (U - u) + T(u) - gamma u', one unit mass for every Fourier mode, gamma = 2 zeta k_min^1/2, with
k_min the least stiffness of any mode and zeta the scene's damping. A disturbance exp(lambda t) of a rest obeys
lambda^2 + gamma lambda = mu, with mu an eigenvalue of dT/du - K (GPa/nm): it grows where mu lies outside the parabola
Im(mu)^2 = -gamma^2 Re(mu), in a fold through mu = 0, in flutter through a complex pair. Overdamped: lambda is mu.
The layer is that of `long_double`, the springs are differentiated here; of the solver only Scene and Frame are used.
"""

from dataclasses import dataclass

import numpy as np

from .extended import LONG, compliance

MOST_NODES = 1024  # of the cell, for dense eigenvalues of the whole surface
AGES, MOST_LOOKS = 40.0, 5  # time over 1/gamma between two looks at what has grown, and how many of them
STEP = 0.6  # over the largest frequency: with longer ones Verlet's scheme makes fast waves grow faster than they do
LOOKS = 24  # displacements, two steps apart, among which the fastest growing disturbance is looked for
SURE = 0.05  # error and change of a growth, over the larger of it and gamma/4, that end the search


@dataclass(frozen=True)
class Critical:
    """The fastest growing, or slowest decaying, disturbance: growth Re(lambda), and the mu it comes from, GPa/nm."""

    growth: float
    mu: complex

    @property
    def kind(self):
        """What it would be the onset of: "fold" or "flutter"."""
        return "flutter" if abs(self.mu.imag) > 1e-9 * abs(self.mu) else "fold"


def growth(scene, frame, held=False, exact=False):
    """Largest Re(lambda) at a Frame, of mu where damping is infinite; arguments as in `critical`."""
    return critical(scene, frame, held, exact).growth


def critical(scene, frame, held=False, exact=False):
    """The Critical disturbance of a Frame; held: at constant normal load, under a top without mass.

    Beyond MOST_NODES (where it takes 4 s), unless exact: what a disturbance at random becomes under the motion itself
    (see `_moving`), less the bound on its error where it grows, so that what is called unstable is. A growth of a few
    hundredths of gamma may be missed, where many others are nearly as fast.
    """
    gamma, J, k = friction(scene), tangent(scene, frame).astype(float), stiffness(scene, held)
    if scene.nodes > MOST_NODES and not (exact or np.isinf(gamma) or _alike(scene, J)):
        return _moving(scene, frame.first, J, k, gamma)
    values = exponents(scene, frame, held)
    rates = rate(values, gamma)
    i = int(np.argmax(rates))
    return Critical(float(rates[i]), complex(values[i]))


def rate(mu, gamma):
    """The larger Re(lambda) of lambda^2 + gamma lambda = mu; Re(mu) for infinite gamma."""
    mu = np.asarray(mu, complex)
    return mu.real if np.isinf(gamma) else np.sqrt(gamma**2 / 4.0 + mu).real - gamma / 2.0


def friction(scene):
    """gamma = 2 zeta k_min^1/2, the same at held delta and held load."""
    k_xx, k_zz, k_c = stiffness(scene)
    least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
    return 2.0 * scene.damping * float(np.sqrt(least.min()))


def stiffness(scene, held=False):
    """(K_xx, K_zz, K_c), GPa/nm, (3, nodes//2 + 1): the compliance of `long_double` inverted, in double.

    held: the uniform normal mode is free, as the layer bears the load at any height of the top.
    """
    xx, zz, c = compliance(scene.nodes, scene.width, scene.height, scene.E, scene.nu)
    k = (np.array([zz, xx, c]) / (xx * zz - c**2)).astype(float)
    k[1, 0] *= not held
    return k


def tangent(scene, frame):
    """dT_c/du_d of every node of the patch, (2, 2, m) GPa/nm, in long double; those of inactive nodes vanish.

    At dn = 0 and dt = 0 an active node carries no traction either: the gap tells.
    """
    m, d_t, d_n = frame.u.shape[1], LONG(scene.delta_t), LONG(scene.delta_n)
    ux, dn = frame.u[0].astype(LONG), (scene.profile[frame.first : frame.first + m] + frame.u[1].astype(LONG)) / d_n
    active = (frame.T != 0.0).any(axis=0) | (dn <= 0.5 * scene.window_n)
    reach = int(np.ceil(scene.window_t * scene.delta_t / scene.spacing)) + 1
    sites = np.rint(ux / scene.spacing) + np.arange(-reach, reach + 1)[:, None]
    dt = (sites * LONG(scene.spacing) - ux) / d_t
    bell = np.where(np.abs(dt) <= scene.window_t, np.exp(-dt * dt), LONG(0))
    press, shear, turn = bell.sum(axis=0), (dt * bell).sum(axis=0), ((2 * dt * dt - 1) * bell).sum(axis=0)
    t, n = (phi / d * np.where(active, np.exp(-dn), LONG(0)) for phi, d in ((scene.phi_t, d_t), (scene.phi_n, d_n)))
    shear, turn = 2 * shear, 2 * turn / d_t
    return np.array([[t * turn, -t * shear / d_n], [-n * dn * shear / d_t, n * (dn - 1) * press / d_n]])


def _alike(scene, J):
    return J.shape[2] == scene.nodes and bool(np.ptp(J, axis=2).max() == 0.0)


def exponents(scene, frame, held=False):
    """All mu of a Frame, GPa/nm, complex, to the accuracy of dense eigenvalues in double."""
    J, k = tangent(scene, frame).astype(float), stiffness(scene, held)
    if _alike(scene, J):  # one block for each wave
        blocks = np.array([[J[0, 0, 0] - k[0], J[0, 1, 0] + 1j * k[2]], [J[1, 0, 0] - 1j * k[2], J[1, 1, 0] - k[1]]])
        return np.linalg.eigvals(np.moveaxis(blocks, 2, 0)).ravel()
    return np.linalg.eigvals(matrix(scene, frame.first, J, k)).astype(complex)


def matrix(scene, first, J, k):
    """dT/du - K of the whole surface in real space, (2 nodes, 2 nodes)."""
    n, m = scene.nodes, J.shape[2]
    columns = np.fft.irfft(np.array([k[0], k[1], -1j * k[2]]), n, axis=1)  # of K_xx, K_zz, K_xz
    xx, zz, xz = columns[:, (np.arange(n)[:, None] - np.arange(n)) % n]
    out = -np.block([[xx, xz], [xz.T, zz]])
    nodes = (first + np.arange(m)) % n
    for c in range(2):
        for d in range(2):
            out[c * n + nodes, d * n + nodes] += J[c, d]
    return out


def _moving(scene, first, J, k, gamma):
    """The Critical disturbance by Verlet's scheme from one at random, and Ritz values of what it has become.

    Some 3000 products with dT/du - K at zeta = 1, each a pair of transforms of the cell, and 1/zeta as many below.
    """
    n, rng = scene.nodes, np.random.default_rng(0)
    here = np.zeros((2, 2, n))
    here[:, :, (first + np.arange(J.shape[2])) % n] = J

    def force(u):
        x, z = np.fft.rfft(u, axis=1)
        layer = np.fft.irfft(np.array([k[0] * x - 1j * k[2] * z, k[1] * z + 1j * k[2] * x]), n, axis=1)
        return (here * u).sum(axis=1) - layer

    dt = STEP / np.sqrt(k[:2].max() + k[2].max() + np.abs(J).sum(axis=1).max())
    u, v = rng.normal(size=(2, 2, n))
    before = np.inf
    for _ in range(MOST_LOOKS):
        seen = []
        for left in range(int(AGES / (gamma * dt)) + 2 * LOOKS, 0, -1):
            v = ((1.0 - 0.5 * gamma * dt) * v + dt * force(u)) / (1.0 + 0.5 * gamma * dt)
            u = u + dt * v
            if left <= 2 * LOOKS and left % 2:
                seen.append(u)
        basis = np.linalg.qr(np.reshape([*seen, v], (LOOKS + 1, -1)).T)[0].T
        images = np.array([force(b.reshape(2, n)).ravel() for b in basis])
        values, vectors = np.linalg.eig(basis @ images.T)
        rates = rate(values, gamma)
        i = int(np.argmax(rates))
        found = Critical(float(rates[i]), complex(values[i]))
        miss = np.linalg.norm(vectors[:, i] @ images - values[i] * (vectors[:, i] @ basis))
        error = float(miss / np.abs(np.sqrt(gamma**2 + 4.0 * values[i] + 0j)))
        if max(error, abs(found.growth - before)) < SURE * max(found.growth, 0.25 * gamma):
            break
        before = found.growth
        u, v = np.array([u, v]) / np.abs(u).max()
    return Critical(found.growth - error, found.mu) if found.growth > 0.0 else found
