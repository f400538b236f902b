"""Whether an equilibrium is one that rests: the growth rate of small disturbances of it under u' = U + C T(u) - u."""

import numpy as np

from .extended import LONG, compliance, displacement, springs

STEP = 1e-6  # of delta_n and delta_t, for central differences in long double
MOST_NODES = 64  # of a patch, for a dense matrix
MOST_PRODUCTS = 60  # with the tangent, beyond that


def growth(scene, frame):
    """Largest real part of the eigenvalues of C dT/du - 1 at a Frame: positive where it is a saddle or worse.

    Patches of more than MOST_NODES: by Arnoldi iteration in float64, less the bound on its error where positive, so
    that what is called a saddle is one; a growth that MOST_PRODUCTS products do not bring out is missed.
    """
    m = frame.u.shape[1]
    tangent = _tangent(scene, frame)
    if m > MOST_NODES:
        return _arnoldi(scene, frame.first, tangent.astype(float))
    response = np.empty((2 * m, 2 * m))
    for column in range(2 * m):
        T = np.zeros((2, scene.nodes), LONG)
        T[column // m, frame.first + column % m] = 1
        u, _ = displacement(scene, T)
        response[:, column] = u[:, frame.first : frame.first + m].ravel()
    rows = np.block([[np.diag(tangent[c, d]) for d in range(2)] for c in range(2)])
    return float(np.linalg.eigvals(response @ rows - np.eye(2 * m)).real.max())


def _arnoldi(scene, first, tangent):
    """The rightmost Ritz value of v -> C dT/du v - v after MOST_PRODUCTS products, as in `growth`."""
    m, T = tangent.shape[2], np.zeros((2, scene.nodes))
    c = compliance(scene.nodes, scene.width, scene.height, scene.E, scene.nu).astype(float)
    basis, found = np.zeros((MOST_PRODUCTS + 1, 2 * m)), np.zeros((MOST_PRODUCTS + 1, MOST_PRODUCTS))
    v = np.random.default_rng(1).normal(size=2 * m)
    basis[0] = v / np.linalg.norm(v)
    for k in range(MOST_PRODUCTS):
        T[:, first : first + m] = np.einsum("cdi,di->ci", tangent, basis[k].reshape(2, m))
        x, z = np.fft.rfft(T, axis=1)
        u = np.fft.irfft(np.array([c[0] * x + 1j * c[2] * z, c[1] * z - 1j * c[2] * x]), scene.nodes, axis=1)
        v = u[:, first : first + m].ravel() - basis[k]
        for _ in range(2):  # once more against round-off
            share = basis[: k + 1] @ v
            v -= share @ basis[: k + 1]
            found[: k + 1, k] += share
        found[k + 1, k] = np.linalg.norm(v)
        if found[k + 1, k] < 1e-12 * np.abs(found).max():
            break
        basis[k + 1] = v / found[k + 1, k]
    values, vectors = np.linalg.eig(found[: k + 1, : k + 1])
    i = int(np.argmax(values.real))
    rate, error = float(values[i].real), float(abs(found[k + 1, k] * vectors[-1, i]))
    return rate - error if rate > 0.0 else rate


def _tangent(scene, frame):
    """dT_c/du_d of every node, (2, 2, m) GPa/nm, the active nodes held."""
    profile = scene.profile[frame.first : frame.first + frame.u.shape[1]]
    active = (frame.T != 0.0).any(axis=0)
    tangent = np.empty((2, 2, active.size))
    for d, step in enumerate((STEP * scene.delta_t, STEP * scene.delta_n)):
        there = frame.u.astype(LONG), frame.u.astype(LONG)
        for sign, u in zip((1, -1), there, strict=True):
            u[d] += sign * step
        ahead, behind = (springs(scene, u[0], profile + u[1], active)[0] for u in there)
        tangent[:, d] = (ahead - behind) / (2 * LONG(step))
    return tangent
