"""Surfaces: what profiles are, against their definitions; and that the solver is right on several patches."""

import numpy as np
import pytest
from adhesion import PSI, PULL_OFF_JKR, hard, johnson, pull_off, repulsive
from helpers import on_whole_cell

from solver import LIMITS, SURFACES, Profile, Scene, SceneError, load_path, scene_from_text, whole_surface
from solver.analysis.peeling import edges, peel_asymmetry
from solver.surfaces import averaged

ROUGH = Scene(surface="rough")
SMALL_ROUGH = Scene(surface="rough", nodes=256, width=625.0, rms_slope=0.06, cut_off=0.1, seed=2, du_z=0.2, du_x=0.2)
SMALL_WAVE = Scene(surface="wave", nodes=256, width=625.0, amplitude=6.0, du_z=0.2, du_x=0.2)


def spectrum(scene):
    """(q, amplitude of the cosine at q) of every mode but the mean."""
    q = 2.0 * np.pi * np.arange(1, scene.nodes // 2 + 1) / scene.width
    return q, 2.0 * np.abs(np.fft.rfft(scene.profile))[1:] / scene.nodes


def rms_slope(scene):
    q, amplitude = spectrum(scene)
    return np.sqrt(0.5 * np.sum((q * amplitude) ** 2))


def frames(scene, **options):
    return list(load_path(scene, **options))


def patches(scene, frame):
    return len(edges(frame))


def test_the_same_seed_gives_the_same_profile():
    """Five nodes of the default, from the definition and the bits of Philox; cosines differ in their last bit only."""
    expected = [13.774725130948, 5.3157028465275, 9.733389572039, 5.3212855873914, 11.794239191005]
    assert ROUGH.profile[[1, 200, 400, 600, 1000]] == pytest.approx(expected, abs=1e-12)
    assert not np.allclose(ROUGH.changed(seed=2).profile, ROUGH.profile)


def test_refined_nodes_show_the_same_rough_surface():
    fine = ROUGH.changed(nodes=4096).profile
    shift = np.argmin([np.abs(np.roll(fine, k)[::4] - ROUGH.profile).max() for k in range(-4, 5)]) - 4
    # highest and lowest nodes lie off the true extremes by up to the sagitta over half a spacing, 1e-3 nm
    assert np.roll(fine, shift)[::4] == pytest.approx(ROUGH.profile, abs=2e-3)


@pytest.mark.parametrize("seed", [0, 1, 77, 999999])
@pytest.mark.parametrize(
    "values", [{}, {"rms_slope": 0.1, "hurst": 0.0}, {"nodes": 1023, "hurst": 1.0, "roll_off": 1.0}]
)
def test_the_rms_slope_is_that_of_the_scene(seed, values):
    scene = ROUGH.changed(seed=seed, **values)
    # exact but for rounding: the spectrum is that of the construction
    assert rms_slope(scene) == pytest.approx(scene.rms_slope, rel=1e-12)


@pytest.mark.parametrize("hurst", [0.2, 0.5, 0.8, 1.0])
def test_hurst_exponent_is_measured_back_from_the_spectrum(hurst):
    scene = ROUGH.changed(hurst=hurst, nodes=4096, roll_off=0.1, cut_off=0.002)
    q, amplitude = spectrum(scene)
    affine = (q > 2.0 * np.pi / (0.1 * scene.width)) & (q < 2.0 * np.pi / (0.002 * scene.width))
    slope = np.polyfit(np.log(q[affine]), np.log(amplitude[affine] ** 2), 1)[0]
    # amplitudes are exact, only phases are random
    assert -0.5 * (slope + 1.0) == pytest.approx(hurst, abs=1e-9)


@pytest.mark.parametrize("hurst", [0.3, 0.5, 0.7])
def test_hurst_exponent_is_measured_back_from_height_differences(hurst):
    """Between the cut-offs the rms height difference grows as distance^H, whatever the phases."""
    scene = ROUGH.changed(hurst=hurst, nodes=16384, width=4e4, roll_off=0.5, cut_off=0.0005)
    # two decades from either end, or their bends still show: what remains of them is 0.05
    steps = np.unique(np.geomspace(60, 400, 8).astype(int))
    rms = [np.mean([np.std(np.roll(p, k) - p) for p in profiles(scene, 3)]) for k in steps]
    assert np.polyfit(np.log(steps), np.log(rms), 1)[0] == pytest.approx(hurst, abs=0.06)


def profiles(scene, count):
    return [scene.changed(seed=seed).profile for seed in range(count)]


def test_roll_off_and_cut_off_are_respected():
    scene = ROUGH.changed(roll_off=0.25, cut_off=0.02)
    _, amplitude = spectrum(scene)
    assert np.ptp(amplitude[:4]) < 1e-12 * amplitude[0]  # flat above the roll-off wavelength, w/4
    assert amplitude[4] < 0.9 * amplitude[3]
    assert amplitude[49] > 1e-3 * amplitude[0] > 1e9 * amplitude[50:].max()  # none below the cut-off, w/50


@pytest.mark.parametrize("surface", [name for name in SURFACES if name not in ("measured", "flat")])
@pytest.mark.parametrize("nodes", [1024, 1023])
def test_surfaces_just_touch_at_zero_and_stand_apart_at_the_ends_of_the_cell(surface, nodes):
    scene = Scene(surface=surface, nodes=nodes)
    gap = scene.profile
    # with an odd number of nodes the lowest point may lie between two of them: curvature times a^2/8
    assert 0.0 <= gap.min() <= 2e-3
    assert gap.argmax() == 0
    # periodic: the step across the ends is no larger than elsewhere; the circular punch has its kink there
    assert abs(gap[0] - gap[-1]) <= 1.01 * np.abs(np.diff(gap)).max()


@pytest.mark.parametrize(
    ("values", "off"),
    [
        # the crest lies half a spacing from the nearest node: A (1 - cos(pi waves/nodes / waves))
        ({"surface": "wave", "waves": 3, "amplitude": 7.0}, 7.0 * (1.0 - np.cos(np.pi / 25))),
        ({"surface": "wave", "waves": 3, "amplitude": 7.0, "nodes": 26}, 0.0),
        ({"surface": "circular"}, (0.5 * 500.0 / 25) ** 2 / (2.0 * 2.5 * 500.0)),
        ({"surface": "circular", "nodes": 26}, 0.0),
    ],
)
def test_the_lowest_node_lies_above_zero_unless_a_node_lies_on_a_crest(values, off):
    """The continuous profile's lowest point is at 0, wherever the nodes are."""
    scene = Scene(**{"nodes": 25, "width": 500.0, **values})
    assert scene.profile.min() == pytest.approx(off, abs=1e-12)


def test_fewer_nodes_than_points_do_not_turn_short_waves_of_a_profile_into_long_ones():
    """In every node spacing one wave, and nine over the width: sampled at the nodes, they would be nine waves."""
    turns = 2.0 * np.pi * np.arange(8192) / 8192
    heights = 4.0 * np.cos(2.0 * turns) + 0.02 * np.cos((1024 + 9) * turns)
    scene = Scene(surface="measured", measured=Profile(2500.0, heights), width=2500.0, nodes=1024)
    _, amplitude = spectrum(scene)
    # the mean over 1 + 9/1024 waves is 9/1033 of the amplitude
    assert amplitude[8] == pytest.approx(0.02 * 9 / 1033, rel=0.1)
    # and over 2/1024 of a wave nearly all of it
    assert amplitude[1] == pytest.approx(4.0, rel=1e-5)
    assert scene.profile.min() == 0.0
    # with nodes enough they are shown
    _, amplitude = spectrum(scene.changed(nodes=8192))
    assert amplitude[[1, 1032]] == pytest.approx([4.0, 0.02], rel=1e-9)


@pytest.mark.parametrize("points", [1, 7, 50, 333])
def test_means_over_a_spacing_are_those_of_the_lines_through_the_points(points):
    random = np.random.default_rng(0)
    x, z = np.sort(random.uniform(3.0, 10.0, 100)), random.normal(size=100)
    z[-1] = z[0]
    length, samples = x[-1] - x[0], 4000
    at = (np.arange(points)[:, None] - 0.5 + (np.arange(samples) + 0.5) / samples) * (length / points)
    expected = np.interp(at, x - x[0], z, period=length).mean(axis=1)
    # midpoints: off by steps of up to 1e-3 of the spacing at the kinks of lines some 1e3 steep
    assert averaged(x, z, points) == pytest.approx(expected, abs=1e-3)


def test_changing_a_returned_profile_leaves_the_scene_unchanged():
    ROUGH.profile[:] = 0.0
    assert ROUGH.profile.any()


@pytest.mark.parametrize("waves", [1, 2, 3, 50])
def test_a_wave_is_a_cosine_periodic_to_the_last_bit_and_even(waves):
    scene = Scene(surface="wave", waves=waves, nodes=1000, width=2500.0, amplitude=2.0)
    gap = scene.profile
    expected = 2.0 * (1.0 + np.cos(2.0 * np.pi * waves * scene.x / 2500.0))
    assert gap == pytest.approx(expected, abs=1e-11)  # the cosine of up to 300 rad, rounded
    assert (gap[1:] == gap[:0:-1]).all()
    if 1000 % waves == 0:
        assert (gap == np.roll(gap, 1000 // waves)).all()


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"surface": "wave", "waves": 129}, r"waves = 129: allowed: 1 \.\. 128, 8 nodes to a wavelength"),
        ({"surface": "wave", "waves": 1.5}, "waves = 1.5: allowed: 1 .. 2048; give a whole number"),
        ({"surface": "wave", "amplitude": 60.0}, r"amplitude = 60\.0: allowed: up to 59\.68 nm"),
        ({"surface": "rough", "cut_off": 0.003}, r"cut_off = 0\.003: allowed: 0\.003906 \.\. 1 w, 4 node spacings"),
        ({"surface": "rough", "roll_off": 0.04}, r"cut_off = 0\.05: allowed: up to roll_off = 0\.04"),
        ({"surface": "rough", "seed": -1}, "seed = -1: allowed: 0 .. 999999"),
        ({"surface": "rough", "seed": 2.5}, "seed = 2.5"),
    ],
)
def test_surfaces_that_cannot_be_built_are_refused_with_a_remedy(values, message):
    with pytest.raises(SceneError, match=message):
        Scene(**values)
    # and only where the parameter counts
    if all(LIMITS[name][0] <= value <= LIMITS[name][1] and value == int(value) for name, value in values.items()
           if name in ("waves", "seed")):  # fmt: skip
        Scene(**values | {"surface": "circular"})


def test_text_names_surfaces_as_scenes_do():
    text = {"surface": "rough", "rms_slope": "0.05", "hurst": "0.5", "roll_off": "0.3", "cut_off": "0.1", "seed": "7"}
    assert scene_from_text(text) == Scene(surface="rough", rms_slope=0.05, hurst=0.5, roll_off=0.3, cut_off=0.1, seed=7)
    assert scene_from_text({"surface": "wave", "waves": "3"}).waves == 3
    with pytest.raises(SceneError, match="'measured'"):
        scene_from_text({"measured": "file.csv"})


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("scene", [SMALL_ROUGH, SMALL_WAVE], ids=["rough", "wave"])
def test_both_methods_find_the_same_equilibria_on_several_patches(scene):
    scene = scene.changed(u_x_max=9.0)
    fast, gfmd = frames(scene), frames(scene, method="gfmd")
    assert any(f.slip for f in fast if f.stage == "shear") and max(patches(scene, f) for f in fast) == 2
    for one, other in zip(fast, gfmd, strict=True):
        # two residuals below 1e-8 nm; u moves by some ten times that, more near folds
        assert np.abs(one.u - other.u).max() < 1e-6
        assert patches(scene, one) == patches(scene, other)


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize("scene", [SMALL_ROUGH, SMALL_WAVE], ids=["rough", "wave"])
def test_sliding_repeats_with_the_lattice_on_any_surface(scene):
    """A profile moves with the layer: translation by a site stays exact, and known states may be moved on."""
    scene = scene.changed(u_x_max=25.0)
    spared, full = frames(scene), frames(scene, replay=False)
    assert sum(f.repeated for f in spared) > 50
    for one, other in zip(spared, full, strict=True):
        assert np.abs(one.u - other.u).max() < 1e-6  # as in test_shortcuts.py
        assert one.slip == other.slip


@pytest.mark.once
@pytest.mark.slow
@pytest.mark.parametrize(
    "values",
    [{"surface": "rough", "rms_slope": 0.07, "cut_off": 0.3, "seed": 5}, {"surface": "wave", "amplitude": 25.0}],
)
def test_a_patch_holds_every_contact_and_gives_the_frames_of_the_whole_cell(values):
    scene = Scene(**values, du_z=0.5, du_x=0.5, u_x_max=8.0)
    narrow, wide = frames(scene), on_whole_cell(scene)
    assert narrow[-1].u.shape[1] < wide[-1].u.shape[1] == scene.nodes
    assert max(patches(scene, f) for f in wide) > 1
    for one, other in zip(narrow, wide, strict=True):
        assert (one.F_bar, one.L_bar) == pytest.approx((other.F_bar, other.L_bar), abs=1e-9)
        # an edge moves by more than the residual's 1e-8 nm where the gap opens slowly
        assert one.A_bar == pytest.approx(other.A_bar, abs=2e-8)
        assert edges(one) == pytest.approx(edges(other), abs=1e-5, nan_ok=True)


def test_a_wave_stays_symmetric_until_shear_starts():
    """The crest is at node `nodes / 2`: u_x is odd about it and u_z even, as the mode of the jump-in is."""
    for frame in frames(Scene(surface="wave", waves=1, amplitude=15.0, u_x_max=0.0)):
        u = whole_surface(frame)
        odd, even = u + [[1.0], [-1.0]] * np.roll(u[:, ::-1], 1, axis=1)
        # 2e-8 where the branch is about to end in the jump-in
        assert np.abs(odd).max() < 1e-6 and np.abs(even).max() < 1e-6


@pytest.mark.slow
def test_several_waves_repeat_the_solution_of_one_wave():
    """Three waves in a cell of three wavelengths and the same height in nm: the same pressure, share and force."""
    one = Scene(surface="wave", waves=1, nodes=128, width=312.5, amplitude=4.0, du_z=0.5, du_x=0.5, u_x_max=10.0)
    three = one.changed(waves=3, nodes=384, width=937.5, height=1.0 / 3.0)
    for single, triple in zip(frames(one), frames(three), strict=True):
        assert patches(three, triple) == 3 * patches(one, single)
        # residuals of 1e-8 nm, nearer the fold more
        assert (triple.F_bar, triple.L_bar) == pytest.approx((single.F_bar, single.L_bar), abs=1e-9)
        assert triple.A_bar == pytest.approx(single.A_bar, abs=1e-6)


def test_peel_asymmetry_counts_every_patch():
    """Three waves peel as one does; the outermost edges alone would tell of two different patches."""
    one = Scene(surface="wave", waves=1, nodes=128, width=312.5, amplitude=4.0, delta_bar=0.2, u_x_max=6.0, du_x=0.5)
    three = one.changed(waves=3, nodes=384, width=937.5, height=1.0 / 3.0)
    told = []
    for scene in (one, three):
        shear = [f for f in frames(scene) if f.stage == "shear"]
        assert not any(f.slip for f in shear)
        told.append(peel_asymmetry(shear[0], shear[-1]))
        there = edges(shear[-1])
        assert there.shape == (scene.waves, 2) and (np.diff(there.ravel()) > 0.0).all()
    assert 0.0 < told[0] < 1.0
    assert told[1] == pytest.approx(told[0], abs=1e-6)


def test_johnsons_wave_approaches_jkr_and_full_contact():
    """Small contacts are JKR cylinders of R = lambda^2/(4 pi^2 A); at alpha = 0.57 nothing holds the surfaces apart."""
    alpha = 1e-4
    # P' = p lambda/(pi E* w_a^2 R)^(1/3), here in p* and alpha: (16/alpha^4)^(1/3) p/p*; leading order in psi, 1e-3
    assert pull_off(alpha)[1] * (16.0 / alpha**4) ** (1.0 / 3.0) == pytest.approx(PULL_OFF_JKR, rel=2e-3)
    # Johnson 1995: the load of every partial contact is tensile from alpha = 0.57 on
    assert johnson(0.565).max() > 0.0 and johnson(0.575).max() < 0.0
    assert repulsive(0.0) == pytest.approx(PSI / (0.5 * np.pi))


@pytest.mark.thorough
@pytest.mark.slow
def test_the_range_of_the_law_matters_less_on_a_higher_wave():
    """Towards Westergaard: the error of area over load falls with delta_n over the amplitude."""
    assert hard(50.0) > 1.5 * hard(120.0) > 2.25 * hard(300.0)
