"""Pictures of the inside of the layer: as accurate as they say, and fringes that count."""

import numpy as np
import pytest
from exact_interior import inside, mean_stress, principal_difference
from helpers import tractions

from solver import Scene, load_path
from solver.analysis.raster import ACCURACY, QUANTITIES, fringes, mesh, picture

ORIGIN = (0.0, 0.0)


def middles(window, size):
    (x_low, x_high, depth), (columns, rows) = window, size
    return x_low + (np.arange(columns) + 0.5) / columns * (x_high - x_low), (np.arange(rows) + 0.5) / rows * depth


PICTURES = [
    (Scene(nodes=1024), (1000.0, 1500.0, 250.0), (61, 40)),
    (Scene(nodes=1024), (-700.0, 1900.0, 2500.0), (40, 30)),  # more than the cell, down to the top
    (Scene(nodes=1024, height=0.01), (1200.0, 1300.0, 25.0), (40, 30)),
    (Scene(nodes=777, width=1900.0, nu=0.2), (900.0, 930.0, 3.0), (40, 30)),  # closer than the nodes
    (Scene(nodes=4, width=10.0), (0.0, 10.0, 10.0), (20, 20)),
]


@pytest.mark.parametrize("scene, window, size", PICTURES)
def test_picture_is_the_sum_over_all_modes_at_every_pixel(scene, window, size):
    """To the accuracy stated, of the largest traction; random tractions have all waves the nodes can carry."""
    T, first = tractions(min(300, scene.nodes)), (scene.nodes - min(300, scene.nodes)) // 2
    stress = inside(scene, first, T, ORIGIN, *middles(window, size)).stress
    expected = stress[1], stress[2], mean_stress(stress, scene.nu), principal_difference(stress)
    for quantity, field in zip(QUANTITIES, expected, strict=True):
        image = picture(scene, first, T, quantity, window, size)
        assert image.dtype == np.float32 and image.shape == size[::-1]
        assert np.abs(image - field).max() <= ACCURACY * np.abs(T).max()


def test_picture_of_a_single_loaded_node_is_as_accurate():
    """The worst case for modes left out: all of equal amplitude and in phase below that node."""
    scene, T = Scene(nodes=1024), np.array([[0.0], [1.0]])
    window, size = (1240.0, 1260.0, 40.0), (20, 80)
    stress = inside(scene, 512, T, ORIGIN, *middles(window, size)).stress
    assert np.abs(picture(scene, 512, T, "normal", window, size) - stress[1]).max() <= ACCURACY


def test_picture_of_a_frame_slides_with_it(frame):
    """Periodic and homogeneous: tractions moved by ten nodes cause the stress moved by ten nodes."""
    scene, last = frame
    low, high, shift = 200.0, 400.0, 10 * scene.spacing
    here = picture(scene, last.first, last.T, "difference", (low, high, 100.0), (50, 20))
    there = picture(scene, last.first + 10, last.T, "difference", (low + shift, high + shift, 100.0), (50, 20))
    assert np.abs(here).max() > 0.1
    assert there == pytest.approx(here, abs=2 * ACCURACY * np.abs(last.T).max())


def test_picture_of_a_flat_contact_is_uniform():
    scene = Scene(surface="flat")
    last = next(iter(load_path(scene)))
    image = picture(scene, last.first, np.full(last.T.shape, 0.5), "shear", (0.0, 500.0, 250.0), (8, 5))
    assert image == pytest.approx(-0.5, rel=ACCURACY)


def test_mesh_is_the_displacement_at_its_points(frame):
    scene, last = frame
    load = last.U_x, -last.delta
    lines = mesh(scene, last.first, last.T, load, (200.0, 400.0, 150.0))
    u = inside(scene, last.first, last.T, load, lines.x, lines.z).u
    below_the_top = np.abs(u - np.array(load)[:, None, None]).max()
    assert np.abs(lines.u - u).max() <= ACCURACY * below_the_top
    assert (lines.x[0], lines.x[-1], lines.z[0], lines.z[-1]) == (200.0, 400.0, 0.0, 150.0)
    assert lines.x[:: lines.stride].size == 20 and lines.z[:: lines.stride].size == 8


def test_fringe_order_counts_the_dark_lines(pressed):
    """From the most sheared point up the axis sigma_1 - sigma_2 falls from 0.60 p0 as p0 a/z: dark at whole orders.

    With 0.05 p0 per fringe these are the orders 12 to 2, down to p0/12 = 1.7 fringes at z = 12 a.
    """
    scene, first, T, a, middle = pressed
    image = picture(scene, first, T, "difference", (middle - 0.01 * a, middle + 0.01 * a, 12.0 * a), (1, 3000))[:, 0]
    below = image[image.argmax() :]
    brightness = fringes(below, 0.05)
    dark = (brightness[1:-1] < brightness[:-2]) & (brightness[1:-1] <= brightness[2:])
    assert below[1:-1][dark] / 0.05 == pytest.approx(np.arange(12.0, 1.0, -1.0), abs=0.02)  # a pixel's worth
    assert brightness.max() > 0.999 and brightness.min() >= 0.0 and brightness[1:-1][dark].max() < 1e-2


def test_whole_orders_are_dark_and_half_orders_bright():
    assert fringes(np.array([0.0, 0.2, 0.4, 2.0]), 0.2) == pytest.approx(0.0, abs=1e-28)
    assert fringes(np.float32([0.1, 0.3, 0.5]), 0.2) == pytest.approx(1.0, abs=1e-12)
    assert fringes(np.float32([0.1]), 0.2).dtype == np.float32


def test_what_cannot_be_shown_is_said_with_a_remedy():
    scene, T = Scene(nodes=16, width=40.0), np.ones((2, 16))
    with pytest.raises(ValueError, match="quantity = 'speed'; allowed: normal, shear, mean, difference"):
        picture(scene, 0, T, "speed", (0.0, 1.0, 1.0), (2, 2))
    with pytest.raises(ValueError, match=r"depth = 41: allowed: above 0 to 40 nm"):
        picture(scene, 0, T, "normal", (0.0, 1.0, 41.0), (2, 2))
    with pytest.raises(ValueError, match=r"x_low < x_high"):
        mesh(scene, 0, T, ORIGIN, (1.0, 1.0, 1.0))
    for low, high in ((-np.inf, 1.0), (0.0, np.inf), (np.nan, 1.0), (0.0, np.nan)):
        with pytest.raises(ValueError, match=r"window = .*: allowed: finite x_low < x_high"):
            picture(scene, 0, T, "normal", (low, high, 1.0), (2, 2))
    for depth in (np.inf, np.nan):
        with pytest.raises(ValueError, match=r"depth = .*: allowed: above 0 to 40 nm"):
            picture(scene, 0, T, "normal", (0.0, 1.0, depth), (2, 2))
    for size in ((0, 4), (4, 0), (-1, 4), (2.5, 4), (np.inf, 4), (np.nan, 4)):
        with pytest.raises(ValueError, match=r"size = .*: allowed: whole numbers \(columns, rows\) from 1 on"):
            picture(scene, 0, T, "normal", (0.0, 1.0, 1.0), size)
    with pytest.raises(ValueError, match=r"z = -1 .. 3: allowed: 0 .. 40 nm"):
        inside(scene, 0, T, ORIGIN, [0.0], [-1.0, 3.0])
    with pytest.raises(ValueError, match="per_fringe = 0"):
        fringes(np.ones(3), 0)
