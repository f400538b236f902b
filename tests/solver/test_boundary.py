"""The boundary between stick-slip and smooth sliding, against closed forms and against whole runs."""

from math import ceil, pi

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from solver import Scene, SceneError, boundary, load_path, skeleton_of

BESIDE = 0.003  # of the boundary: runs this far from it slip on one side only
SMALL = {"nodes": 64, "width": 156.25}  # of the default's node spacing


@pytest.fixture(scope="module")
def default():
    return skeleton_of(Scene())


def slips(scene):
    """Whether a run slips before it repeats itself."""
    for frame in load_path(scene):
        if frame.stage == "shear" and frame.slips:
            return True
        if frame.repeated:
            return False
    raise AssertionError("the run does not repeat itself")


def critical_modulus(scene):
    """E at which a flat stops slipping (Prandtl 1928): the steepest softening of its lattice sum is k = E/(2(1+nu)h).

    Poisson's sum converges to round-off within 2 a/delta_t + 6 terms.
    """
    ratio = scene.spacing / scene.delta_t

    def slope(xi):
        orders = np.arange(1, ceil(2 * ratio) + 6)
        weights = 8 * pi**2.5 * orders**2 / ratio**3 * np.exp(-((pi * orders / ratio) ** 2))
        return float(weights @ np.cos(2 * pi * orders * xi))

    least = min(minimize_scalar(slope, bounds=(0.4, 0.6), method="bounded").fun, slope(0.5))
    return -2 * (1 + scene.nu) * scene.height * scene.width * least * scene.phi_t / scene.delta_t**2


@pytest.mark.parametrize(("name", "value"), [("phi_ratio", 0.0170035094), ("E", 2825.6228)])
def test_the_default_stops_slipping_where_bisection_by_whole_runs_found_it(default, name, value):
    """Bisection took 147,476 force evaluations; both numbers are known to 6e-7."""
    found = boundary(default, name)
    assert found.value == pytest.approx(value, rel=1e-6)
    assert found.U_x == pytest.approx(0.5 * Scene().spacing, abs=1e-6)  # by symmetry, between two sites
    assert getattr(found.scene, name) == found.value and found.evaluations < 2000


@pytest.mark.parametrize("E", [60.0, 74.0])
def test_under_tension_slips_end_where_the_surface_no_longer_jumps_into_contact(E):
    """The load before shear then changes from that of a contact to less than half of it, between two runs."""
    scene = Scene(delta_bar=-0.41, E=E)
    found = boundary(scene, "E")
    assert np.isnan(found.U_x)
    assert [slips(scene.changed(E=found.value * part)) for part in (1.0 - BESIDE, 1.0 + BESIDE)] == [True, False]
    drawn, apart = (at_rest(scene.changed(E=found.value * part)) for part in (1.0 - 1e-6, 1.0 + 1e-6))
    assert drawn.L < 2.0 * apart.L < 0.0


def test_a_jump_that_comes_later_for_more_friction_ends_no_slips():
    """It was followed to a larger phi_ratio, where slips remain, without an end."""
    found = boundary(Scene(E=60.0, nu=0.3, delta_bar=-0.4935), "phi_ratio", within=(0.002, 2.0))
    assert found.value is None and "beyond phi_ratio = 0.002 .. 2" in found.why


def at_rest(scene):
    """The Frame at the end of the approach."""
    return next(frame for frame in load_path(scene) if frame.stage == "shear")


@pytest.mark.parametrize("start", [0.9, 1.1])
@pytest.mark.parametrize("own", [{}, {"nu": 0.3, "phi_ratio": 0.5}])
def test_a_flat_stops_slipping_at_its_closed_form_from_either_side(own, start):
    """The error of the value is the square of that of the state, which is solved to 1e-4."""
    flat = Scene(surface="flat", delta_bar=0.0, height=16.0, **SMALL, **own)
    exact = critical_modulus(flat)
    assert boundary(flat.changed(E=start * exact), "E").value == pytest.approx(exact, rel=1e-8)


@pytest.mark.parametrize("ratio", [0.005, 0.0166])
def test_a_scene_that_slides_smoothly_has_the_boundary_of_one_that_slips(default, ratio):
    smooth = boundary(Scene(phi_ratio=ratio), "phi_ratio")
    assert smooth.value == pytest.approx(boundary(default, "phi_ratio").value, rel=1e-7)


SCENES = {
    "punch": ({}, "phi_ratio"),
    "stiff punch": ({}, "E"),
    "pair of cusps": ({"delta_bar": -0.3}, "phi_ratio"),
    "held load": ({"hold": "load"}, "phi_ratio"),
    "wave": ({**SMALL, "surface": "wave", "amplitude": 1.0, "phi_ratio": 0.05, "delta_bar": 0.1}, "phi_ratio"),
    "rough": (
        {**SMALL, "surface": "rough", "seed": 7, "cut_off": 0.1, "rms_slope": 0.005, "delta_bar": 0.3},
        "phi_ratio",
    ),
}


@pytest.mark.once(2)
@pytest.mark.slow
@pytest.mark.parametrize("kind", ["pair of cusps", "rough", *sorted(SCENES.keys() - {"pair of cusps", "rough"})])
def test_runs_slip_on_one_side_of_the_boundary_only(kind):
    values, name = SCENES[kind]
    found = boundary(Scene(**values), name)
    beside = BESIDE if name == "phi_ratio" else -BESIDE
    assert not slips(found.scene.changed(**{name: found.value * (1.0 - beside)}))
    assert slips(found.scene.changed(**{name: found.value * (1.0 + beside)}))


def test_under_tension_the_boundary_is_one_of_a_pair_of_asymmetric_cusps():
    """Above delta_bar -0.136 the last slip begins half-way between two sites, below it does not."""
    found = boundary(Scene(delta_bar=-0.3), "phi_ratio")
    middle = 0.5 * found.scene.spacing
    assert abs(found.U_x - middle) > 0.05 * found.scene.spacing
    assert boundary(Scene(delta_bar=-0.1), "phi_ratio").U_x == pytest.approx(middle, abs=1e-6)


@pytest.mark.parametrize(
    ("scene", "name", "within", "why"),
    [
        (Scene(), "E", (10.0, 2000.0), "the boundary lies beyond E = 10 .. 2000"),
        (Scene(phi_ratio=0.0), "E", None, "nothing resists shear"),
        (Scene(u_x_max=1.0), "E", None, "use a larger u_x_max"),
        (Scene(path="unload"), "E", None, "cannot be followed"),
    ],
)
def test_a_boundary_that_is_not_found_says_why(scene, name, within, why):
    found = boundary(scene, name, within)
    assert found.value is None and why in found.why and why in repr(found)


def test_a_run_too_short_to_slip_has_the_boundary_of_a_longer_one(default):
    """A stiffer layer slips, or slides by a site, within the same displacement: the search begins there."""
    assert boundary(Scene(u_x_max=5.0), "E").value == pytest.approx(boundary(default, "E").value, rel=1e-7)


@pytest.mark.parametrize("name", ["E", "phi_ratio"])
def test_a_run_that_flutters_has_the_boundary_of_a_smoother_one(default, name):
    """The runs at E = 12 end by flutter. That at 100 times the modulus, or at a hundredth of phi_ratio, slips."""
    soft, other = Scene(E=12.0), default if name == "E" else Scene(E=12.0, phi_ratio=0.001)
    assert boundary(soft, name).value == pytest.approx(boundary(other, name).value, rel=1e-6)


def test_a_boundary_by_another_parameter_is_rejected():
    with pytest.raises(SceneError, match="nu"):
        boundary(Scene(), "nu")
