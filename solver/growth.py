"""Whether an equilibrium is stable: the growth rate of the fastest growing mode of the overdamped flow about it."""

import numpy as np
from numba import njit

from . import np1

PRODUCTS = 40  # with the tangent: enough for a mode that stands out of the many at -1 (nodes on which nothing acts)


def growth_rate(contact, u, active):
    """Largest real part of the eigenvalues of C dT/du - 1, per unit of time, by Arnoldi iteration; negative if stable.

    u: (2, size) nm. Each of the products counts as a force evaluation, though it needs no exponentials.
    """
    size, layer = 2 * contact.size, contact.compliance
    tangents = np.empty((4, contact.size))
    np1.tangents(u, contact.profile, active, contact.law, contact.work, tangents)
    steps = min(PRODUCTS, size)
    basis, hessenberg = np.zeros((steps + 1, size)), np.zeros((steps + 1, steps))
    first = np.random.default_rng(0).normal(size=size)
    basis[0] = first / np.linalg.norm(first)
    for k in range(steps):
        _tractions(tangents, basis[k].reshape(2, -1), layer.field)
        layer.apply()
        contact.evaluations += 1
        v = layer.product.reshape(-1) - basis[k]
        for _ in range(2):  # once more against round-off
            share = basis[: k + 1] @ v
            v -= share @ basis[: k + 1]
            hessenberg[: k + 1, k] += share
        norm = np.linalg.norm(v)
        hessenberg[k + 1, k] = norm
        if norm < 1e-12 * np.abs(hessenberg[: k + 1, k]).max():
            steps = k + 1
            break
        basis[k + 1] = v / norm
    return float(np.linalg.eigvals(hessenberg[:steps, :steps]).real.max())


@njit(cache=True, nogil=True)
def _tractions(tangents, v, out):
    for i in range(v.shape[1]):
        out[0, i] = tangents[0, i] * v[0, i] + tangents[1, i] * v[1, i]
        out[1, i] = tangents[2, i] * v[0, i] + tangents[3, i] * v[1, i]
