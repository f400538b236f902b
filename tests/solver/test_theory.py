"""Closed forms against runs: they are within their error where they apply, and left out where they do not."""

import numpy as np
import pytest
from theory import theory

from solver import Scene, simulate
from solver.run.frame import slides_in


def by_name(scene):
    return {each.name: each for each in theory(scene)}


def error(curve, frames, value, place):
    """Largest error of a closed form on Frames within its range, over the largest value of the run."""
    x, y = (np.array([getattr(frame, name) for frame in frames]) for name in (place, value))
    within = (x >= curve.x[0]) & (x <= curve.x[-1])
    return float(np.abs(np.interp(x[within], curve.x, curve.y) - y[within]).max() / y[within].max())


# A coarse path; the tails of NP1 are wider than Maugis' zone: errors fall as lambda grows (1, 2.3, 3.7 here)
@pytest.mark.once(3)
@pytest.mark.parametrize(
    ("values", "of_maugis", "of_griffith"),
    [
        ({"E": 70.0}, 0.04, 0.04),
        ({"E": 20.0}, 0.02, 0.04),
        ({"E": 70.0, "drive_n": 200.0, "drive_t": 20.0}, 0.04, 0.04),
        ({"E": 20.0, "law": "xu-needleman"}, 0.02, 0.03),
        ({"E": 10.0}, 0.01, 0.02),
        ({"E": 20.0, "hold": "load"}, 0.02, 0.07),
    ],
)
def test_area_of_a_punch_is_that_of_maugis_without_shear_and_of_griffith_up_to_the_first_slip(
    values, of_maugis, of_griffith
):
    scene = Scene(delta_bar=0.4, du_x=0.5, du_z=0.5, u_x_max=30.0, **values)
    curves, frames = by_name(scene), simulate(scene).frames
    pressed = [frame for frame in frames if frame.stage == "approach" and frame.delta >= 0.0]
    first = next((k for k, frame in enumerate(frames) if slides_in(frame)), len(frames))
    shear = [frame for frame in frames[:first] if frame.stage == "shear"]
    assert len(shear) > 15
    assert error(curves["Maugis"], pressed, "A", "delta") < of_maugis
    assert error(curves["Griffith"], shear, "A", "U_x") < of_griffith


def flats():
    rng = np.random.default_rng(7)
    for seed in range(12):
        width = 64 * rng.uniform(1.3, 4.0)
        cell = {"surface": "flat", "nodes": 64, "width": width, "E": 10.0 ** rng.uniform(1.0, 3.0)}
        grip = {"phi_ratio": 10.0 ** rng.uniform(-2.5, 0.0), "law": ("np1", "xu-needleman")[seed % 4 == 0]}
        drive = {"drive_t": (np.inf, 5.0)[seed % 3 == 0], "drive_n": (np.inf, 5.0)[seed % 5 == 0]}
        depth = rng.uniform(0.0, 0.09 if seed % 4 == 0 else 0.8)
        yield Scene(delta_bar=depth, du_z=0.5, u_x_max=20.0, damping=np.inf, **cell, **grip, **drive)


@pytest.mark.parametrize("scene", list(flats()))
def test_flat_follows_prandtl_and_tomlinson_up_to_its_first_slip(scene):
    (curve,) = theory(scene)
    frames = simulate(scene).frames
    first = next((k for k, frame in enumerate(frames) if slides_in(frame)), len(frames))
    shear = [frame for frame in frames[:first] if frame.stage == "shear"]
    assert error(curve, shear, "F", "U_x") < 1e-3
    if first < len(frames):
        event = slides_in(frames[first])[0]
        assert [curve.x[-1], curve.y[-1]] == pytest.approx([event.load, event.F_bar * frames[0].unit], rel=2e-3)
        assert f"{curve.x[-1]:.2f} nm" in curve.limit
    else:
        assert curve.x[-1] > 0.99 * scene.u_x_max


@pytest.mark.parametrize(
    ("values", "names"),
    [
        ({"surface": "wave"}, []),
        ({"surface": "rough"}, []),
        ({"E": 200.0}, []),  # Maugis' number is 0.5
        ({"nu": 0.0}, []),
        ({"phi_ratio": 0.0}, ["Maugis"]),
        ({"delta_bar": -0.8}, ["Maugis"]),  # apart
        ({"path": "unload"}, ["Maugis"]),
        ({"path": "points"}, ["Maugis"]),
        ({"nodes": 2048}, ["Maugis"]),  # sites nearer than 2 delta_t
        ({"path": "loop"}, ["Maugis", "Griffith"]),
        ({"surface": "flat"}, ["Prandtl–Tomlinson"]),
        ({"surface": "flat", "delta_bar": -0.3, "E": 1000.0}, []),  # farther apart than delta_n waves grow
        ({"surface": "flat", "hold": "load"}, []),
        ({"surface": "flat", "phi_ratio": 0.0}, []),
        ({"surface": "flat", "law": "xu-needleman", "delta_bar": 0.8, "E": 700.0}, []),  # sites repel along x
    ],
)
def test_closed_forms_are_left_out_where_they_do_not_apply(values, names):
    found = theory(Scene(**values))
    assert [each.name for each in found] == names
    for each in found:
        assert np.isfinite(each.x).all()
        assert np.isfinite(each.y).all()
        assert (np.diff(each.x) > 0.0).all()
