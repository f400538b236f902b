"""A run that the browser computes from its skeleton, against the solver's own increments."""

import base64
from functools import cache
from itertools import chain

import numpy as np
import pytest

from app.service.packing import ORDER
from app.service.skeletons import packed
from solver import Scene, certify, simulate, skeleton_of
from solver.presets import presets

SCENES = {name: preset.scene for name, preset in presets().items() if preset.scene.path == "shear"} | {
    "stiff": Scene(E=300.0),
    "weak": Scene(E=30.0, phi_ratio=0.5, delta_bar=0.3),
    "xu-needleman": Scene(law="xu-needleman", u_x_max=12.0),
    "held": Scene(hold="load"),
    "wave": Scene(surface="wave"),
    "flat": Scene(surface="flat", phi_ratio=0.05),
}
SHOWN = "fig6", "rough", "fig4a-blue", "soft-drive", "xu-needleman"
OTHERS = [name for name in SCENES if name not in SHOWN]
CHECKED = "fig6", "rough", "held", "wave", "flat"
CASES = [*SHOWN, *(pytest.param(name, marks=pytest.mark.thorough) for name in OTHERS)]
IN_TAB = """async (text) => {
    const { skeletonLater, chunkFrom } = await import("http://scripts/static/js/skeleton.js")
    const { buffer } = Uint8Array.from(atob(text), (c) => c.charCodeAt(0))
    const { skeleton } = await skeletonLater({ body: buffer }), whole = chunkFrom(skeleton)
    const few = chunkFrom(skeleton, true, 3)
    const lists = (of) => Object.fromEntries(Object.entries(of).map(([name, list]) => [name, [...list]]))
    const { first, frames } = whole.head, rows = [0, 70, 200, 300].filter((row) => row < frames)
    const u = rows.map((row) => [...whole.fieldsAt(row).u_x])
    return { first, u, whole: lists(whole.columns), few: lists(few.columns) }
}"""


@cache
def result_of(name):
    return simulate(SCENES[name])


@pytest.mark.parametrize("name", CASES)
def test_increments_of_a_skeleton_are_those_of_its_run(tab, name):
    """F and L to 1e-4, A to 1e-3 or a fifth of a spacing, and displacements to 1e-3 nm.

    F, L and A are also those of the exact run, but for the error of the skeleton itself.
    """
    scene = SCENES[name]
    skeleton, frames = result_of(name).skeleton, [frame for frame in result_of(name).frames if frame.stage == "shear"]
    made = tab.evaluate(IN_TAB, base64.b64encode(packed(skeleton)).decode())
    whole = {column: np.array(values) for column, values in made["whole"].items()}
    assert whole["index"].tolist() == [frame.index for frame in frames]
    loads = np.array([frame.U_x for frame in frames])
    np.testing.assert_allclose(whole["U_x"], loads, atol=1e-5)
    own = dict(zip(("F_bar", "L_bar", "A_bar"), skeleton.curve(loads), strict=True))
    force = max(np.abs(own["F_bar"]).max(), np.abs(own["L_bar"]).max())
    touches = (
        own["A_bar"] > 2.0 / scene.nodes
    )  # with two nodes left, A ends like a root: no bound of its error is small
    everywhere = np.full_like(touches, True)
    tests = ("F_bar", 1e-4 * force, everywhere), ("L_bar", 1e-4 * force, everywhere)
    for column, within, where in (*tests, ("A_bar", max(1e-3 * own["A_bar"].max(), 0.2 / scene.nodes), touches)):
        exact = np.array([getattr(frame, column) for frame in frames])
        error = np.abs(own[column] - exact).max()
        np.testing.assert_allclose(whole[column][where], own[column][where], atol=within)
        np.testing.assert_allclose(whole[column][where], exact[where], atol=within + error)
    assert whole["slip"].tolist() == [len(frame.slips) for frame in frames]
    slips = list(chain.from_iterable(frame.slips[:1] for frame in frames))
    np.testing.assert_allclose(whole["slip_at"][whole["slip"] > 0], [slip.load for slip in slips], atol=1e-4)
    np.testing.assert_allclose(whole["delta"], [frame.delta for frame in frames], atol=2e-3)
    for k, u in zip((0, 70, 200, 300), made["u"], strict=False):
        ours, theirs = common(made["first"], np.array(u), frames[k])
        np.testing.assert_allclose(ours, theirs, atol=1e-3)


@pytest.mark.parametrize("name", CHECKED)
def test_increments_of_a_checked_run_are_those_of_its_frames(tab, name):
    """The approach, too: F and L to 3e-3 of the largest, A to a fifth of a spacing, displacements to 5e-3 nm."""
    scene = SCENES[name].changed(u_x_max=6.0)
    frames = simulate(scene).frames
    checked = certify(skeleton_of(scene))
    assert checked.holds
    made = tab.evaluate(IN_TAB, base64.b64encode(packed(checked.skeleton, checked.approach)).decode())
    whole = {column: np.array(values) for column, values in made["whole"].items()}
    assert [ORDER[int(k)] for k in whole["stage"]] == [frame.stage for frame in frames]
    force = max(max(abs(frame.F_bar), abs(frame.L_bar)) for frame in frames)
    for column, within in ("F_bar", 3e-3 * force), ("L_bar", 3e-3 * force), ("A_bar", 0.2 / scene.nodes):
        np.testing.assert_allclose(whole[column], [getattr(frame, column) for frame in frames], atol=within)
    for column in "index", "U_x", "delta":
        np.testing.assert_allclose(whole[column], [getattr(frame, column) for frame in frames], atol=2e-3)
    assert whole["slip"].tolist() == [len(frame.slips) for frame in frames]
    slips = list(chain.from_iterable(frame.slips[:1] for frame in frames))
    np.testing.assert_allclose(whole["slip_at"][whole["slip"] > 0], [slip.load for slip in slips], atol=1e-4)
    for k, u in zip((0, 70, 200, 300), made["u"], strict=False):
        ours, theirs = common(made["first"], np.array(u), frames[k])
        np.testing.assert_allclose(ours, theirs, atol=5e-3)


def common(first, u, frame):
    """The displacements of nodes that both have."""
    begin, end = max(first, frame.first), min(first + len(u), frame.first + frame.u.shape[1])
    return u[begin - first : end - first], frame.u[0, begin - frame.first : end - frame.first]


def test_a_picture_has_few_increments_and_those_beside_slips(tab):
    skeleton = result_of("fig6").skeleton
    made = tab.evaluate(IN_TAB, base64.b64encode(packed(skeleton)).decode())
    whole, few = made["whole"], made["few"]
    index = np.array(few["index"], int)
    assert index.size < 0.6 * len(whole["index"]) and {0, 30, len(whole["index"]) - 1} <= {*index.tolist()}
    for name, values in few.items():
        assert values == np.array(whole[name])[index].tolist()
    slips = np.flatnonzero(whole["slip"])
    assert {*slips.tolist(), *(slips - 1).tolist()} <= {*index.tolist()}
