"""Whether an equilibrium is stable: the growth rate of the fastest growing mode of the overdamped flow about it."""

import numpy as np
from numba import njit

PRODUCTS = 16  # with the tangent: enough for a mode that stands out of the many at -1 (nodes on which nothing acts)
MOST_PRODUCTS = 160  # where the first leave it open, as in stiff contacts
SURE = 4.0  # times the bound on the error, as the matrix is not symmetric: below zero by less may yet be a saddle


def growth_rate(contact, u, active):
    """Largest real part of the eigenvalues of C dT/du - 1, per unit of time, by Arnoldi iteration; negative if stable.

    Where it would be positive, the bound on its error is taken off, so that no rest is taken for a saddle by mistake.
    u: (2, size) nm. Each of the products counts as a force evaluation, though it needs no exponentials.
    """
    size = 2 * contact.size
    tangents = contact.tangents(u, active)
    most = min(MOST_PRODUCTS, size)
    basis, hessenberg = np.zeros((most + 1, size)), np.zeros((most + 1, most))
    first = np.random.default_rng(0).normal(size=size)
    basis[0] = first / np.linalg.norm(first)
    for k in range(most):
        ended = _extend(contact, tangents, basis, hessenberg, k)
        if ended or k + 1 == most or (k + 1) % PRODUCTS == 0:
            rate, error = _rightmost(hessenberg, k + 1)
            if ended or rate + SURE * error < 0.0 or rate > 2.0 * error:
                break
    return rate - error if rate > 0.0 else rate


def _extend(contact, tangents, basis, hessenberg, k):
    """One Arnoldi step; True if the basis spans all that there is."""
    layer = contact.compliance
    _tractions(tangents, basis[k].reshape(2, -1), layer.field)
    layer.apply()
    contact.evaluations += 1
    v = layer.product.reshape(-1) - basis[k]
    for _ in range(2):  # once more against round-off
        share = basis[: k + 1] @ v
        v -= share @ basis[: k + 1]
        hessenberg[: k + 1, k] += share
    norm = np.linalg.norm(v)
    if norm < 1e-12 * np.abs(hessenberg[: k + 1, k]).max():
        return True
    hessenberg[k + 1, k] = norm
    basis[k + 1] = v / norm
    return False


def _rightmost(hessenberg, k):
    """(real part, bound on its error) of the rightmost Ritz value after k steps."""
    values, vectors = np.linalg.eig(hessenberg[:k, :k])
    i = int(np.argmax(values.real))
    return float(values[i].real), float(abs(hessenberg[k, k - 1] * vectors[-1, i]) / np.linalg.norm(vectors[:, i]))


@njit(cache=True, nogil=True)
def _tractions(tangents, v, out):
    for i in range(v.shape[1]):
        out[0, i] = tangents[0, i] * v[0, i] + tangents[1, i] * v[1, i]
        out[1, i] = tangents[2, i] * v[0, i] + tangents[3, i] * v[1, i]
