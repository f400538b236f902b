"""Lagrange interpolation of states over a scalar: load, arc length, or the root of the distance to a fold."""

import numpy as np
from numba import njit


def lagrange(nodes, x):
    """Weights of the values at `nodes` in that of their polynomial at x, a list."""
    weights = []
    for i, here in enumerate(nodes):
        weight = 1.0
        for j, other in enumerate(nodes):
            if i != j:
                weight *= (x - other) / (here - other)
        weights.append(weight)
    return weights


def combine(weights, states):
    """sum of weights[i] * states[i], arrays of one shape; a new one."""
    total = np.zeros_like(states[0])
    for weight, state in zip(weights, states, strict=True):
        _add(total.reshape(-1), weight, state.reshape(-1))
    return total


@njit(cache=True, nogil=True, fastmath={"contract"})
def _add(total, weight, state):
    for i in range(total.size):
        total[i] += weight * state[i]
