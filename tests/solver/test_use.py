"""Use from Python, as bug reports of other libraries describe it."""

from pathlib import Path

import numpy as np
import pytest

from solver import (
    LIMITS,
    Profile,
    Scene,
    SceneError,
    advance,
    certify,
    follow,
    load_path,
    sensitivities,
    simulate,
    skeleton_from,
    skeleton_of,
    sweep,
    unstable_branch,
    whole_surface,
)
from solver.analysis.friction_laws import friction_force
from solver.files import report_of, write_npz
from solver.measured.fit import fit
from solver.measured.measurement import Measurement

SMALL = Scene(nodes=64, width=160.0, radius=0.2, du_z=0.5, du_x=0.5, u_x_max=12.0)
DEEPER = SMALL.changed(delta_bar=0.1)


def test_a_checkpoint_continues_the_run_of_its_scene_and_refuses_any_other_by_the_parameter():
    frames, checkpoint = advance(SMALL, budget=0.0)
    assert advance(Scene(**SMALL.differences()), checkpoint, budget=0.0)[0][0].index == frames[0].index + 1
    for name, value in {"delta_bar": 0.1, "E": 71.0, "u_x_max": 20.0, "tolerance": 1e-7, "path": "loop"}.items():
        with pytest.raises(SceneError, match=f"^{name} = .*: allowed with this checkpoint: .*; give the scene"):
            advance(SMALL.changed(**{name: value}), checkpoint)
    done = advance(SMALL, budget=60.0)[1]
    with pytest.raises(SceneError, match="delta_bar"):
        advance(DEEPER, done)
    with pytest.raises(SceneError, match="delta_bar"):
        skeleton_from(DEEPER, done)


def test_a_checkpoint_of_one_measured_profile_refuses_another():
    def scene(height):
        return SMALL.changed(
            surface="measured", measured=Profile(160.0, height * np.sin(2 * np.pi * np.arange(64) / 64))
        )

    _, checkpoint = advance(scene(1.0), budget=0.0)
    with pytest.raises(SceneError, match=r"^measured = "):
        advance(scene(2.0), checkpoint)


def test_files_laws_and_derivatives_refuse_the_scene_of_another_run(tmp_path: Path):
    frames = list(load_path(SMALL))
    with pytest.raises(SceneError, match=r"delta_bar = 0.1: allowed with this run: 0"):
        write_npz(tmp_path / "run.npz", DEEPER, frames)
    with pytest.raises(SceneError, match="delta_bar"):
        report_of(DEEPER, frames, "fast", 0.0, None)
    with pytest.raises(SceneError, match="delta_bar"):
        friction_force(DEEPER, frames)
    slip = sensitivities(skeleton_of(SMALL), ["E"]).slips[0]
    assert slip.per_cent(SMALL)["E"].shape == (4,)
    with pytest.raises(SceneError, match="delta_bar"):
        slip.per_cent(DEEPER)


def test_a_run_under_a_load_continues_from_its_approach():
    held = simulate(SMALL, load=1.0)
    assert held.failure is None and held.checkpoint.scene == held.scene


def test_a_user_who_lets_numpy_raise_gets_the_same_numbers():
    """Underflow is meant: springs far apart pull with exp(-gap). The setting is the user's again afterwards."""
    expected = simulate(SMALL)
    with np.errstate(all="raise"):
        result = simulate(SMALL)
        assert np.geterr()["under"] == "raise"
        assert repr(result) == repr(expected) and result.table.equals(expected.table)
        followed = follow(skeleton_of(SMALL), SMALL.changed(E=72.0))
        assert (
            sensitivities(followed, ["E"]).slips
            and result.stress(5.0).zz.size
            and whole_surface(result.frames[-1]).size
        )
        assert list(sweep(SMALL, E=[70.0])["outcome"]) == ["slips"] and len(advance(SMALL)[0]) > 0


def test_a_dict_in_place_of_a_scene_is_answered_by_what_to_write():
    with pytest.raises(TypeError, match=r"^scene = \{'E': 60.0\}: allowed: a Scene; write Scene\(E=60.0\)$"):
        simulate({"E": 60.0})
    for entry in (load_path, advance, sweep, skeleton_of, lambda scene: follow(skeleton_of(SMALL), scene)):
        with pytest.raises(TypeError, match="allowed: a Scene; write Scene"):
            list(entry({}))


@pytest.mark.parametrize(
    "use", [certify, sensitivities, unstable_branch, lambda run: follow(run, SMALL.changed(E=72.0))]
)
def test_a_skeleton_is_taken_from_a_result_and_anything_else_refused_by_what_to_write(use):
    result = simulate(SMALL)
    assert type(use(result)) is type(use(result.skeleton))
    with pytest.raises(TypeError, match=r"skeleton = Scene: allowed: a Skeleton; use skeleton_of\(scene\)"):
        use(SMALL)


def test_refusals_of_parameters_are_printed_in_ascii():
    """As results are: `print(error)` into such a file raised another error."""
    for name, parameter in LIMITS.items():
        with pytest.raises(SceneError, match=name) as refused:
            parameter.checked(name, "x")
        assert str(refused.value).isascii()


def test_results_are_printed_in_ascii_whatever_their_cautions_hold():
    """Output to a file on Windows may be cp1252 or cp437; a caution of this soft scene names phi_t and delta_t."""
    result = simulate(SMALL.changed(E=5.0, u_x_max=2.0))
    shown = repr(result)
    assert shown.isascii() and "phi_t/(E delta_t)" in shown and "φ" in "".join(result.cautions)
    shown = repr(fit(SMALL, curve(SMALL), ["delta_bar"]))
    assert shown.isascii() and "delta_0" in shown


def curve(scene):
    U_x = np.linspace(0.1, scene.u_x_max, 60)
    return Measurement.of(U_x, {"F_bar": skeleton_of(scene).curve(U_x)[0]})
