"""The parameters of the Stage as Panel passes them on."""

import asyncio

import pytest
from visitor import PATIENCE, messages, waited

from app.experiment import Experiment
from app.service.jobs import Jobs
from solver import Scene, SceneError


def test_changes_that_panel_passes_on_together_are_obeyed_in_the_order_of_their_numbers(session, monkeypatch):
    obeyed = []
    monkeypatch.setattr(session, "obey", lambda name, given: obeyed.append(name))

    async def change():
        session.stage.param.update(scene={"n": 5, "values": {}}, restore={"n": 4, "values": {}}, skip={"n": "x"})
        async with asyncio.timeout(PATIENCE):
            while len(obeyed) < 3:
                await asyncio.sleep(0)

    waited(change())
    assert obeyed == ["skip", "restore", "scene"]


def test_two_equal_messages_are_both_sent(session):
    sent = messages(session)
    for _ in range(2):
        session.send("skeleton", acknowledged=1, body=b"1")
    assert len(sent) == 2


@pytest.mark.parametrize("values", [{"u_x_max": 1e4}, {"nodes": 8192, "u_x_max": 1.0}, {"du_x": 0.001}])
def test_a_scene_too_large_for_a_browser_is_refused_in_python_as_on_the_page(session, values):
    """The page would refuse its own address."""
    before, large = session.scene, Scene(**values)
    with pytest.raises(SceneError, match="allowed"):
        session.scene = large
    assert session.scene is before and session.pursuit.scene is before
    with pytest.raises(SceneError, match="allowed"):
        Experiment(large, jobs=session.jobs)


def test_an_experiment_computes_in_a_notebook_on_the_loop_of_its_kernel(pool):
    async def cell():
        experiment = Experiment(Scene(nodes=256, width=625.0, u_x_max=2.0), jobs=Jobs(pool))
        experiment.stage.hello = {"n": 0}
        async with asyncio.timeout(PATIENCE):
            while experiment.status.get("state") != "finished":
                await asyncio.sleep(0.01)
            experiment.scene = experiment.scene.changed(E=90.0)
            while (experiment.status["state"], experiment.status["values"]["E"]) != ("finished", 90.0):
                await asyncio.sleep(0.01)
        frames = experiment.run.frames
        experiment.close()
        return frames

    assert waited(cell()) > 1
