"""The parameters of the Stage as Panel passes them on."""

import asyncio

from visitor import PATIENCE, messages, waited


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
