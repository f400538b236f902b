"""The parameters of the Stage as Panel passes them on."""

import asyncio

import pytest
from visitor import PATIENCE, messages, waited

from app.stage import Stage


def test_changes_that_panel_passes_on_together_are_obeyed_in_the_order_of_their_numbers(session, monkeypatch):
    """A page was asked for something before it was open."""
    obeyed = []
    monkeypatch.setattr(session, "obey", lambda name, given: obeyed.append(name))

    async def change():
        session.stage.param.update(ask={"n": 5, "what": "sweep"}, page={"n": 4, "page": "load"}, skip={"n": "x"})
        async with asyncio.timeout(PATIENCE):
            while len(obeyed) < 3:
                await asyncio.sleep(0)

    waited(change())
    assert obeyed == ["skip", "page", "ask"]


def test_two_equal_messages_are_both_sent(session):
    sent = messages(session)
    for _ in range(2):
        session.send("file", ending="npz", why="", body=b"1")
    assert len(sent) == 2


def test_a_stage_without_a_result_is_not_saved(tmp_path):
    with pytest.raises(ValueError, match="no result"):
        Stage().save(tmp_path / "punch.html")
    assert not list(tmp_path.iterdir())


def test_a_stage_without_a_result_says_so_in_a_notebook():
    assert "no result" in Stage()._repr_html_() and "iframe" not in Stage()._repr_html_()
