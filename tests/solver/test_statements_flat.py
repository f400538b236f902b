"""The paper's statements on flat on flat (section 3.1, Figs. 4 and 5), one test each, named after it.

The drop at a slip, and every frame against one node, is in test_flat.py.
"""

import numpy as np
import pytest

from solver import Scene, load_path
from solver.analysis.friction_laws import critical_modulus, friction, onset, tau_max
from solver.mechanics import cohesive_law
from solver.presets import preset


def flat(name, **values):
    """A preset's scene, a sixteenth as wide on the same layer: nodes of a flat are all alike (test_flat.py)."""
    scene = preset(name).scene
    return scene.changed(nodes=64, width=scene.width / 16, height=16 * values.pop("height", scene.height), **values)


def shear(scene):
    return [f for f in load_path(scene) if f.stage == "shear"]


def slips(frames):
    return [i for i, f in enumerate(frames) if f.slip]


@pytest.mark.slow
@pytest.mark.parametrize("values", [{}, {"E": 140.0}, {"height": 0.5}])
def test_stick_is_linear_with_a_slope_set_by_modulus_and_height(values):
    """F/w over U_x is G/h, in series with the interface, which is 20 to 40 times stiffer in registry."""
    scene = flat("fig4a-blue", **values)
    frames = shear(scene)
    frames = frames[: slips(frames)[0]]
    stress = np.array([f.F_bar for f in frames[1:]]) * scene.E
    slope = stress / [f.U_x for f in frames[1:]]
    layer = scene.shear_modulus / (scene.height * scene.width)
    interface = -cohesive_law.tangent(scene, 0.0, 0.0)[0]
    assert slope[0] == pytest.approx(1.0 / (1.0 / layer + 1.0 / interface), rel=1e-4)  # the first increment, 0.1 nm
    assert slope[0] == pytest.approx(layer, rel=0.05)
    # the interface softens as it yields: the slope is the first one's to 3 % up to the slip
    assert slope == pytest.approx(slope[0], rel=0.03)


def test_drop_at_a_slip_is_larger_for_a_stiffer_layer():
    """Over E = 70 throughout, as in Fig. 4."""
    found = [friction(flat("fig4a-blue", E=E), reference=70.0) for E in (35.0, 70.0, 140.0, 280.0)]
    drops = [f.F_s - f.F_k for f in found]
    assert np.all(np.diff(drops) > 0.7 * np.array(drops[:-1]))  # nearly twice the drop for twice the modulus


def test_onset_comes_earlier_for_a_weaker_interface():
    blue, green = (onset(flat(f"fig4a-{colour}")) for colour in ("blue", "green"))
    # half the strength, so half the force and, for a layer so soft, half the displacement
    assert green.F_s / blue.F_s == pytest.approx(0.5, abs=0.01)
    assert green.U_s / blue.U_s == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("name", ["E", "phi_ratio"])
def test_sliding_turns_continuous_at_the_exact_boundary(name):
    """By a higher E or a lower phi_t. Three per cent to either side: nearer, slips are so short that some get lost."""
    scene = flat("fig4a-blue", u_x_max=10.0, tolerance=1e-11)
    over = critical_modulus(scene) / scene.E
    at = {"E": scene.E * over, "phi_ratio": scene.phi_ratio / over}[name]
    sticking, sliding = (0.97, 1.03) if name == "E" else (1.03, 0.97)
    frames = shear(scene.changed(**{name: at * sticking}))
    # u_z stays 0 at delta_bar = 0, so that max dT_x/du_x = G/h is the boundary with both degrees of freedom
    assert slips(frames) and max(np.abs(f.u[1]).max() for f in frames) < scene.tolerance
    assert not slips(shear(scene.changed(**{name: at * sliding})))


@pytest.mark.parametrize("name", ["fig4b-weak", "fig4b-stiff"])
def test_continuous_sliding_oscillates_around_zero_without_sticking(name):
    frames = shear(flat(name))
    force = np.array([f.F_bar for f in frames])
    assert not slips(frames)
    assert force.mean() == pytest.approx(0.0, abs=0.02 * force.max())
    assert force.min() == pytest.approx(-force.max(), rel=0.01)
    # within the first lattice period already, as far as increments of 0.1 nm meet the extremes
    first = force[: int(Scene().spacing / 0.1) + 2]
    assert (first.min(), first.max()) == pytest.approx((force.min(), force.max()), rel=0.01)


def test_mean_friction_falls_monotonically_with_modulus_over_strength():
    """Eq. 7 over tau_max: falls, then stays at zero, where the force turns from tau to -tau within a period."""
    scene = flat("fig4a-blue")
    moduli = np.geomspace(20.0, 20_000.0, 120)
    curve = np.array([friction(scene.changed(E=E), reference=tau_max(scene)).mean for E in moduli])
    falling = curve > 1e-9
    assert np.all(np.diff(curve[falling]) < 0.0) and np.all(curve[~falling] < 1e-9)
    assert falling[0] and not falling[-1]
    # ours: the mean of the extremes is zero from 0.73 E_c on already, although slips, and their losses, end at E_c
    assert moduli[falling][-1] / critical_modulus(scene) == pytest.approx(0.73, abs=0.04)


def test_mean_friction_depends_on_modulus_over_strength_alone():
    scene = flat("fig4a-blue")
    for factor in (0.1, 10.0):
        other = scene.changed(E=scene.E * factor, phi_ratio=scene.phi_ratio * factor)
        assert friction(other).mean == pytest.approx(friction(scene).mean, rel=1e-12)
