"""Whether an equilibrium is one that rests: the growth rate of small disturbances of it under u' = U + C T(u) - u."""

import numpy as np

from .extended import LONG, displacement, springs

STEP = 1e-6  # of delta_n and delta_t, for central differences in long double
MOST_NODES = 64  # of a patch: the matrix is dense


def growth(scene, frame):
    """Largest real part of the eigenvalues of C dT/du - 1 at a Frame: positive where it is a saddle or worse."""
    m = frame.u.shape[1]
    tangent = _tangent(scene, frame)
    response = np.empty((2 * m, 2 * m))
    for column in range(2 * m):
        T = np.zeros((2, scene.nodes), LONG)
        T[column // m, frame.first + column % m] = 1
        u, _ = displacement(scene, T)
        response[:, column] = u[:, frame.first : frame.first + m].ravel()
    rows = np.block([[np.diag(tangent[c, d]) for d in range(2)] for c in range(2)])
    return float(np.linalg.eigvals(response @ rows - np.eye(2 * m)).real.max())


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
