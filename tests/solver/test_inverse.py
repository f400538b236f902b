"""Iterative solves: their accuracy, and the memory of the pairs that they keep."""

import tracemalloc

import numpy as np

from solver.continuation.inverse import Inverse


def test_pairs_beyond_the_first_memory_are_kept_for_the_next_solve():
    stiffness = np.linspace(1.0, 50.0, 400)
    solver = Inverse(lambda w: stiffness * w, 400)
    right = np.random.default_rng(1).normal(size=400)
    solution = solver.solve(right, accuracy=1e-8)
    np.testing.assert_allclose(stiffness * solution, right, atol=1e-8 * np.linalg.norm(right))
    pairs = solver.rows
    assert pairs > 16  # more than it begins with, so that memory grew under way
    np.testing.assert_allclose(solver.solve(2.0 * right, accuracy=1e-7), 2.0 * solution, rtol=1e-5)
    assert solver.rows == pairs  # the same direction again costs no product


def test_a_solver_of_many_unknowns_takes_memory_for_the_pairs_it_has_only():
    tracemalloc.start()
    try:
        Inverse(np.copy, 2 * 16_384)
        reserved = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert reserved < 20e6  # bytes; all pairs a solve may make take 126 MB
