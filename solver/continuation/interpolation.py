"""Lagrange interpolation over a scalar: load, arc length, or the root of the distance to a fold."""

from collections.abc import Sequence


def lagrange(nodes: Sequence[float], x: float) -> list[float]:
    """Weights of the values at `nodes` in that of their polynomial at x."""
    weights = []
    for i, node in enumerate(nodes):
        weight = 1.0
        for j, other in enumerate(nodes):
            if i != j:
                weight *= (x - other) / (node - other)
        weights.append(weight)
    return weights
