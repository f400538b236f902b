"""Whether a frame is stable: the growth rates of all small disturbances of the whole surface, by dense eigenvalues.

The transient obeys u'' = K (U - u) + T(u) - gamma u' with one unit mass for every Fourier mode. The friction is
gamma = 2 zeta k_min^1/2, where k_min is the least stiffness of any mode and zeta the scene's damping. A disturbance
exp(lambda t) of an equilibrium obeys lambda^2 + gamma lambda = mu, with mu an eigenvalue of dT/du - K (GPa/nm). It
grows where mu lies outside the parabola Im(mu)^2 = -gamma^2 Re(mu): in a fold through mu = 0, in flutter through a
complex pair. Overdamped: lambda is mu. Layer and springs are those of `extended`.
"""

import extended
import numpy as np

from solver.run.frame import Frame
from solver.scene import Scene

# relative differences of nodes that are all alike, to the round-off of transforms of a prime length: dense eigenvalues
# of 4,099 nodes would take minutes
ALIKE = 1e-9


def growth(scene: Scene, frame: Frame, held: bool = False) -> float:
    """The largest Re(lambda) at a Frame, of mu where damping is infinite.

    held: at constant normal load, under a top without mass. Eigenvalues of many nodes are expensive, but for
    a uniform surface.
    """
    return float(rate(exponents(scene, frame, held), friction(scene)).max())


def needed_damping(scene: Scene, mu: np.ndarray) -> float:
    """The damping over critical above which every wave decays, of all mu of a Frame; 0.0 without any that would not.

    Waves are the modes with |mu| beyond 20 k_min: those nearer to zero are searched for in every run.
    """
    critical = friction(scene) / scene.damping
    waves = mu[(np.abs(mu) > 5.0 * critical**2) & (mu.real < 0.0)]
    return float((np.abs(waves.imag) / np.sqrt(-waves.real)).max(initial=0.0)) / critical


def rate(mu, gamma: float) -> np.ndarray:
    """The larger Re(lambda) of lambda^2 + gamma lambda = mu; Re(mu) for infinite gamma."""
    mu = np.asarray(mu, complex)
    return mu.real if np.isinf(gamma) else np.sqrt(gamma**2 / 4.0 + mu).real - gamma / 2.0


def friction(scene: Scene) -> float:
    """gamma = 2 zeta k_min^1/2, the same at held delta and held load."""
    k_xx, k_zz, k_c = stiffness(scene)
    least = 0.5 * (k_xx + k_zz) - np.hypot(0.5 * (k_xx - k_zz), k_c)
    return 2.0 * scene.damping * float(np.sqrt(least.min()))


def stiffness(scene: Scene, held: bool = False) -> np.ndarray:
    """(K_xx, K_zz, K_c), GPa/nm, (3, nodes//2 + 1), in double.

    held: the uniform normal mode is free, as the layer bears the load at any height of the top.
    """
    k = extended.layer(scene).stiffness.astype(float)
    k[1, 0] *= not held
    return k


def tangent(scene: Scene, frame: Frame) -> np.ndarray:
    """dT_c/du_d of every node of the patch, (2, 2, m) GPa/nm, in double."""
    _, u, gap = extended.patch_of(scene, frame)
    return extended.tangent(scene, u[0], gap).astype(float)


def exponents(scene: Scene, frame: Frame, held: bool = False) -> np.ndarray:
    """All mu of a Frame, GPa/nm, complex, to the accuracy of dense eigenvalues in double."""
    J, k = tangent(scene, frame), stiffness(scene, held)
    if J.shape[2] < scene.nodes or np.ptp(J, axis=2).max() > ALIKE * np.abs(J).max():
        return np.linalg.eigvals(matrix(scene, frame.first, J, k)).astype(complex)
    (xx, xz), (zx, zz) = J[:, :, 0]  # all nodes alike: one block for each mode
    blocks = np.array([[xx - k[0], xz + 1j * k[2]], [zx - 1j * k[2], zz - k[1]]])
    return np.linalg.eigvals(np.moveaxis(blocks, 2, 0)).ravel()


def matrix(scene: Scene, first: int, J: np.ndarray, k: np.ndarray) -> np.ndarray:
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
