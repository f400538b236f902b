"""The app without a browser: entries, packed frames, and runs that survive cancelling and lost workers."""

import json
import os
import re
import signal

import numpy as np
import pytest
from helpers import until
from visitor import PARTING, SHORT, Page, say, unpacked, whole_run

from app import experiment as session_module
from app.experiment import example
from app.page import shared
from app.service import packing, worker
from app.session import controls, pursuit
from app.session.controls import CONTROLS, NAMES, address_of, changed_scene, scene_from_address
from solver import LIMITS, Scene, advance
from solver.presets import presets

ROUNDED = 2 * packing.FINE + 0.002  # of the largest value: straight lines over frames and nodes, and the steps


def test_slider_ranges_lie_within_the_solver_limits_and_contain_the_defaults():
    for control in CONTROLS:
        low, high = LIMITS[control.name][:2]
        assert low <= control.positions[0] < control.positions[-1] <= high
        assert getattr(Scene(), control.name) in control.positions
        assert list(control.positions) == sorted(set(control.positions))


@pytest.mark.parametrize("text", ["nan", "inf", "1e9", "-7", "", "2,500", "two", None, [1]])
@pytest.mark.parametrize("name", NAMES)
def test_invalid_entries_are_reported_with_their_range_and_change_nothing(name, text):
    scene, errors = changed_scene(SHORT, {name: text})
    assert scene == SHORT
    assert errors[name].startswith(controls.LABELS[name])
    assert controls.in_words(LIMITS[name].span) in errors[name]  # beyond the slider's own
    assert name not in errors[name].split()


def test_entries_accept_units_and_signs_and_report_a_decimal_comma(page):
    page.order("scene", delta_bar="−0,5", E="0.09 TPa")
    assert page.session.scene == SHORT.changed(delta_bar=-0.5, E=90.0)
    assert page.status()["errors"] == {} and "decimal point, −0.5" in page.status()["notes"][0]


def test_the_thumbs_of_the_page_stand_at_the_values_of_the_address_before_any_script_runs():
    html = shared(example).page_for({"delta_bar": [b"0.5"], "E": [b"10"]}, token="", nonce="")
    for control, value in zip(CONTROLS, (0.5, 1.0, 10.0), strict=True):
        slider = re.search(f'<input type="range" id="{control.name}"[^>]*value="(\\d+)"', html)
        assert control.positions[int(slider[1])] == value


def test_address_values_are_parsed_like_entries():
    scene, _, notes = scene_from_address({"delta_bar": [b"0,4"], "E": [b"90 GPa"]})
    assert scene == Scene(delta_bar=0.4, E=90.0) and len(notes) == 1 and "comma" in notes[0]


def test_each_address_value_is_validated_on_its_own():
    arguments = {"delta_bar": [b"0.4"], "phi_ratio": [b"x"], "E": [b"\xff"], "theme": [b"dark"]}
    scene, preset, notes = scene_from_address(arguments)
    assert scene == Scene(delta_bar=0.4) and preset == "fig6"
    assert len(notes) == 2 and "phi_ratio" in notes[0] and "default 1" in notes[0] and "default 70" in notes[1]
    assert "Stiffness" in notes[1] and "0.01 to 10⁶ GPa" in notes[1]


def test_an_invalid_value_of_an_address_leaves_the_others_together_valid():
    """waves=200 needs more nodes than the default, width=50 fewer."""
    for others in (
        {"surface": "wave", "amplitude": 0.3, "waves": 200, "nodes": 4096},
        {"width": 50.0, "nodes": 20},
    ):
        arguments = {name: [str(value).encode()] for name, value in others.items()}
        scene, _, (note,) = scene_from_address({"E": [b"7o"]} | arguments)
        assert scene == Scene(**others) and note.startswith("E in the address")


def test_each_value_of_an_address_that_is_refused_beside_the_others_has_a_note():
    arguments = {"du_x": [b"0.001"], "width": [b"50"], "E": [b"60"]}
    scene, _, notes = scene_from_address(arguments)
    assert scene == Scene(E=60.0) and [note.split()[0] for note in notes] == ["du_x", "width"]
    assert "node spacing" in notes[1] and "The default 2500 is used" in notes[1]


def test_an_address_holds_a_preset_and_its_changes():
    scene, preset, notes = scene_from_address(
        {"preset": [b"fig4a-blue"], "E": [b"90"], "width": [b"50"], "nodes": [b"20"]}
    )
    assert preset == "fig4a-blue" and not notes
    assert scene == presets()["fig4a-blue"].scene.changed(E=90.0, width=50.0, nodes=20)  # width alone would be refused
    again = {name: [text.encode()] for name, text in address_of(scene, preset).items()}
    assert again.keys() == {"preset", "E", "width", "nodes"} and scene_from_address(again)[:2] == (scene, preset)


def test_a_retired_parameter_in_the_address_is_reported_and_left_out():
    scene, _, (note,) = scene_from_address({"window_n": [b"12"], "E": [b"90"]})
    assert scene.E == 90.0 and note.startswith("“window_n” in the address: it has no effect since version 0.2")


def test_an_unknown_preset_in_the_address_is_reported_and_replaced_by_the_default():
    scene, preset, notes = scene_from_address({"preset": [b"fig99"]})
    assert (
        scene == Scene() and preset == "fig6" and "fig99" in notes[0] and "the list of experiments has all" in notes[0]
    )


@pytest.mark.parametrize(
    ("entries", "said"),
    [
        ({"phi_n": "-1"}, "phi_n “-1”: allowed: 0.001 to 1000 N/m; give a number in that range"),
        ({"nodes": "1e6"}, "nodes"),
        ({"surface": "measured"}, "choose a file under profile"),
        ({"surface": "bumpy"}, "surface “bumpy”: allowed: circular"),
        ({"du_x": "0.001"}, "40102 increments"),
        ({"tolerance": "two"}, "tolerance “two”: allowed: 10⁻¹² to 0.001 nm; give a number"),
    ],
)
def test_drawer_rejects_scenes_that_cannot_run_with_a_reason(entries, said):
    scene, errors = changed_scene(Scene(), entries)
    assert scene == Scene()
    assert list(errors) == list(entries) and said in errors[next(iter(entries))]


def test_a_flat_is_packed_with_only_the_drawn_nodes():
    scene = Scene(surface="flat", phi_ratio=0.1, u_x_max=2.0)
    frames, _ = advance(scene, None, np.inf)
    head, _, fields = unpacked(whole_run(scene).blocks[-1])
    assert head["nodes"] == packing.FLAT and head["first"] == (scene.nodes - packing.FLAT) // 2
    assert fields["T_x"][-1] == pytest.approx(frames[-1].T[0, 0], rel=ROUNDED)


@pytest.mark.parametrize(
    "path", [{"delta_bar": 0.2, "u_x_max": 1.0}, {"path": "points", "points": "0,-1; 0,0.2; 1,0.2"}]
)
def test_the_jump_of_an_approach_lies_on_its_curve_along_delta(path):
    """On a path through points it was marked 2 nm beside it, at its place along the whole path."""
    scene = SHORT.changed(**path)
    jump = next(frame for frame in advance(scene, None, np.inf)[0] if frame.slips)
    columns = [unpacked(block)[1] for block in whole_run(scene).blocks]
    marked = np.concatenate([each["slip_at"][each["slip"] > 0] for each in columns])
    assert jump.stage == "approach" and marked[0] == pytest.approx(jump.slips[0].load, abs=1e-4)


def test_nodes_that_packed_frames_leave_out_are_too_far_apart_to_be_seen():
    scene = SHORT.changed(delta_bar=-0.9, u_x_max=1.0)
    frame = advance(scene, None, np.inf)[0][-1]
    head, *_ = unpacked(whole_run(scene).blocks[-1])
    first = head["first"] - frame.first
    gap = scene.profile[frame.first :][: frame.u.shape[1]] + frame.u[1]
    left_out = np.delete(gap, slice(first, first + head["nodes"]))
    assert left_out.size and left_out.min() > packing.SEEN * scene.delta_n


@pytest.mark.parametrize("surface", ["circular", "flat"])
def test_a_packed_run_has_exact_columns_and_fields_to_one_per_cent(surface):
    """Gaps and u_x to a few hundredths of delta_n and delta_t."""
    scene = SHORT.changed(surface=surface, u_x_max=4.0)
    rows = [(frame, 0.1 * k) for k, frame in enumerate(advance(scene, None, 60.0)[0])]
    rows = [row for row in rows if row[0].first == rows[-1][0].first and row[0].u.shape == rows[-1][0].u.shape]
    (head, curves, whole), packed = packing.arrays(scene, rows, True), packing.pack(scene, rows, True)
    assert len(packed) < 0.25 * (curves.nbytes + whole.nbytes)
    same, columns, fields = unpacked(packed)
    assert json.loads(json.dumps(head)).items() <= same.items()
    for name, values in zip(head["columns"], curves, strict=True):
        np.testing.assert_array_equal(values, columns[name])
    for name, values in zip(packing.FIELDS, whole, strict=True):
        within = ROUNDED * 32767 * head["scales"][name]
        within = min(within, 3 * packing.CLOSE.get(name, np.inf))  # delta_n and delta_t are 1 nm
        np.testing.assert_allclose(fields[name], values * head["scales"][name], atol=within)


def test_page_receives_the_number_of_compiled_kernels_during_warm_up(session):
    session.jobs.pool.status, session.jobs.pool.compiled = "warming", 3
    say(session, {"do": "hello"})
    assert session.status["compiled"] == (3, worker.KERNELS)


def test_only_the_latest_of_several_changes_is_computed(page, monkeypatch):
    monkeypatch.setattr(pursuit, "FIRST", 0.002)  # the first part is cut off, however fast the solver
    page.order("hello")
    for value in (0.1, 0.2, 0.3):
        page.order("scene", delta_bar=value)
    page.until("finished")
    assert page.session.run.scene == SHORT.changed(delta_bar=0.3)
    shown = {run for run, *_ in page.chunks}
    assert shown <= {1, page.session.run.number}  # nothing of 0.1 and 0.2
    assert page.curve("delta")[-1] == pytest.approx(3.0)


@pytest.mark.slow
def test_a_run_is_unchanged_after_its_worker_is_killed_and_replaced(page, pool, monkeypatch):
    page.order("hello")
    page.until("finished")
    undisturbed = page.curve("F_bar")
    page.session.jobs.results.clear()
    monkeypatch.setattr(pursuit, "FIRST", 60.0)  # the whole run is one slice
    lost = pool.replaced
    page.order("hello")
    until(lambda: page.session.pursuit.job.slot)
    for process in pool.processes():
        os.kill(process, signal.SIGKILL)
    page.until("finished")
    assert pool.replaced > lost
    assert "Another worker repeats" in page.status()["notes"][0]
    assert len(page.curve("F_bar")) == len(undisturbed)
    # slices are cut by the clock, so the same increments may end elsewhere within the tolerance
    np.testing.assert_allclose(page.curve("F_bar"), undisturbed, atol=1e-6 * np.abs(undisturbed).max() + 1e-10)


def test_a_run_that_pulls_off_under_its_held_load_finishes_and_is_cached(page):
    page.session.show(PARTING, "fig6")
    page.until("finished")
    assert page.session.run.scene == PARTING and "has pulled off at U_x = " in page.status()["why"]
    assert page.session.jobs.keeps(worker.compute, PARTING)


@pytest.mark.thorough
@pytest.mark.slow
def test_a_slice_that_kills_every_worker_is_reported_as_failed(page, monkeypatch):
    monkeypatch.setattr(worker, "compute", end_worker)
    page.order("hello")
    page.until("failed")
    assert "workers" in page.status()["why"]


def end_worker(*_):
    """End the worker that makes this call."""
    os._exit(1)


def test_a_session_is_freed_when_its_visitor_leaves(pool):
    visit = Page(pool)
    visit.order("hello")
    assert visit.session in session_module.visitors
    visit.session.close()
    assert visit.session not in session_module.visitors
    assert visit.session.run is None
    before = visit.calls.qsize()
    other = Page(pool)
    other.order("hello")
    other.until("finished")
    assert visit.calls.qsize() <= before + 1  # no slice was submitted for the one who left
    other.session.close()
