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
    active = np.arange(108) % 7 > 0
    right = rng.normal(size=problem.size)
    w = problem.preconditioner(v, active)(right)
    assert problem.linearised(v, active).tangent(w) == pytest.approx(-right, abs=1e-3 * np.abs(w).max())


def test_a_singular_tangent_has_no_inverse():
    """Under a held load, with nodes that count as active but are far away: no height of the top changes the load."""
    scene = SCENES["stiff"]
    problem = Equilibrium(Contact(scene, 10, 108), sideways(1.0, 0.0), 0.01)
    v = np.append(np.repeat([0.0, 1e3], 108), 1e3)
    assert problem.preconditioner(v, np.ones(108, bool)) is None


def test_without_active_nodes_there_is_no_preconditioner():
    scene = SCENES["stiff"]
    problem = Equilibrium(Contact(scene, 10, 108), sideways(1.0, -scene.delta))
    assert problem.preconditioner(problem.undeformed(0.0), np.zeros(108, bool)) is None


def test_for_so_many_nodes_that_forming_it_takes_too_long_there_is_no_preconditioner():
    scene = Scene(surface="wave")
    problem = Equilibrium(Contact(scene, 0, scene.nodes), sideways(1.0, -scene.delta))
    for nodes, formed in [(FORMED, True), (FORMED + 1, False)]:
        active = np.arange(scene.nodes) < nodes
        assert (problem.preconditioner(problem.undeformed(0.0), active) is not None) is formed
