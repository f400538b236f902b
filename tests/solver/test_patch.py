"""One patch, chosen before the run: springs outside it do not act in any state."""

import numpy as np
import pytest
from helpers import on_whole_cell

from solver import Profile, Scene, load_path, whole_surface
from solver.mechanics.contact import REACH, patch

PUNCH = Scene(nodes=256, width=625.0, radius=0.4, du_x=0.5, du_z=0.5, tolerance=1e-6, u_x_max=8.0)
SOFT = PUNCH.changed(radius=0.1)
STEEP = {"surface": "wave", "waves": 1, "amplitude": 25.0}
SCENES = {
    **{
        f"E {E:g}, depth {delta_bar:g}": PUNCH.changed(E=E, delta_bar=delta_bar)
        for E in (20.0, 70.0, 1000.0)
        for delta_bar in (-0.6, 0.0, 1.0)
    },
    "soft": SOFT.changed(E=10.0, delta_bar=0.2),
    "strong friction": PUNCH.changed(phi_ratio=2.0, nu=0.2),
    "held load": PUNCH.changed(hold="load", delta_bar=0.4),
    "held load in tension": PUNCH.changed(hold="load", delta_bar=-0.1, u_x_max=0.5),
    "rough": PUNCH.changed(surface="rough", rms_slope=0.1, cut_off=0.3, delta_n=0.3, phi_n=0.6),
    "wave": PUNCH.changed(**STEEP),
    "wave, nearly incompressible": PUNCH.changed(**STEEP, nu=0.49, height=0.3, delta_bar=0.5),
    "thin": PUNCH.changed(height=0.1, delta_bar=0.2),
    "drive": PUNCH.changed(drive_n=5.0, drive_t=5.0),
    "unload": PUNCH.changed(path="unload"),
    "points": PUNCH.changed(path="points", points="0,-1; 0,0.2; 4,0.2; 4,1; 8,-0.5"),
}


@pytest.mark.parametrize("name", SCENES)
def test_springs_outside_the_patch_are_out_of_reach_in_every_frame(name):
    """Beyond REACH a spring pulls with less than 4e-10 of phi_n/delta_n."""
    scene = SCENES[name]
    first, size = patch(scene)
    assert 1 < size < scene.nodes
    outside = np.ones(scene.nodes, bool)
    outside[first : first + size] = False
    for frame in load_path(scene):
        assert (frame.first, frame.u.shape) == (first, (2, size))
        assert np.abs(frame.T[:, [0, -1]]).max() < 1e-9 * scene.phi_n / scene.delta_n
        gap = scene.profile + whole_surface(frame)[1]
        assert gap[outside].min() > REACH * scene.delta_n


@pytest.mark.parametrize("values", [{"surface": "flat"}, {"E": 0.5}, {"drive_n": 1e-6, "tolerance": 1e-3}])
def test_the_patch_is_the_whole_cell_where_every_node_may_interact(values):
    assert patch(PUNCH.changed(**values)) == (0, PUNCH.nodes)


def test_a_summit_apart_belongs_to_the_patch():
    """A broad contact pressed into a nearly incompressible layer drives the free surface down, far from it as well."""
    x = (np.arange(256) + 0.5) / 256 * 625.0
    hills = [d * np.clip(1.0 - ((x - at) / half) ** 2, 0.0, None) for at, half, d in ((220, 150, 12), (520, 30, 3.2))]
    size = {"surface": "measured", "measured": Profile(625.0, np.maximum(*hills)), "width": 625.0, "nodes": 256}
    scene = Scene(**size, nu=0.4999, height=0.3, delta_n=0.2, delta_bar=3.0, du_z=1.0, u_x_max=0.0)
    for narrow, wide in zip(load_path(scene), on_whole_cell(scene), strict=True):
        assert narrow.L_bar == pytest.approx(wide.L_bar, abs=1e-9)  # without the summit: 2e-3
