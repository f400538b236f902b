"""Lagrange interpolation over a scalar: load, arc length, or the root of the distance to a fold."""

from collections.abc import Sequence
from math import prod


def lagrange(nodes: Sequence[float], x: float) -> list[float]:
    """Weights of the values at `nodes` in that of their polynomial at x."""
    pairs = list(enumerate(nodes))
    return [prod(((x - other) / (node - other) for j, other in pairs if j != i), start=1.0) for i, node in pairs]
