"""The dense inverse of a tangent against the tangent itself."""

import numpy as np
import pytest

from solver import Scene
from solver.mechanics.contact import Contact
from solver.mechanics.equilibrium import FORMED, Equilibrium
from solver.run.load_steps import sideways

SCENES = {
    "stiff": Scene(nodes=128, width=312.5, delta_bar=0.3),
    "soft": Scene(nodes=128, width=312.5, delta_bar=0.3, E=0.3),
    "frictionless": Scene(nodes=128, width=312.5, delta_bar=0.3, phi_ratio=0.0),
}


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("name", SCENES)
def test_dense_inverse_times_tangent_is_the_identity(name, held):
    """To single precision times what a soft layer loses; off-registry contact, so that all four tangents count."""
    scene, rng = SCENES[name], np.random.default_rng(1)
    problem = Equilibrium(Contact(scene, 10, 108), sideways(1.0, -scene.delta))
    u = np.array([rng.uniform(-0.3, 0.3, 108), rng.uniform(-0.2, 0.5, 108) - scene.profile[10:118]])
    v = u.reshape(-1)
    if held:
        problem, v = Equilibrium(problem.contact, problem.loading, 0.01), np.append(v, -scene.delta)
    right = rng.normal(size=problem.size)
    w = problem.preconditioner(v)(right)
    assert problem.linearised(v).tangent(w) == pytest.approx(-right, abs=1e-3 * np.abs(w).max())


def test_for_so_many_nodes_that_forming_it_takes_too_long_there_is_no_preconditioner():
    for nodes, formed in [(FORMED, True), (FORMED + 1, False)]:
        scene = Scene(surface="wave", width=2.5 * nodes, nodes=nodes)
        problem = Equilibrium(Contact(scene, 0, nodes), sideways(1.0, -scene.delta))
        assert (problem.preconditioner(problem.undeformed(0.0)) is not None) is formed
