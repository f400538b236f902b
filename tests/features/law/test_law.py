"""The page of the interface law, without a browser."""

import numpy as np
import pytest
from visitor import messages, order

from app.features.law import page as law
from app.features.law.tasks import relative_toughness
from solver import CHOICES, toughness
from solver.mechanics import cohesive_law


def test_a_page_that_is_opened_again_is_told_anew(session):
    sent = messages(session)
    for _ in range(2):
        order(session, "page", page="law")
    opened = [message.get("open") for message in sent if message["kind"] == "opened"]
    assert opened[0] == opened[-1] == "law" and {"kind": "opened"} in sent  # closed, it has no texts


def test_a_step_of_the_press_depth_sends_nothing_of_an_unchanged_interface_law(session):
    order(session, "hello")
    order(session, "page", page="law")
    sent = messages(session)
    order(session, "scene", delta_bar="0.21")
    assert {message["kind"] for message in sent} == {"status"}
    order(session, "scene", phi_ratio="0.5")
    law = [message["law"] for message in sent if message["kind"] == "opened"]
    assert law and law[0]["constants"] == cohesive_law.law_constants(session.scene).tolist()


def test_interface_law_page_explains_overlap(session):
    order(session, "page", page="law")
    for name, words in (("np1", "grows where the surfaces overlap"), ("xu-needleman", "changes sign below")):
        order(session, "scene", law=name)
        assert words in session.features["pages"].page.published["texts"]["law-numbers"]


def test_interface_law_page_draws_the_toughness_and_says_how_shear_changes_it(session):
    order(session, "page", page="law")
    for values, words in (
        ({"phi_ratio": "1"}, "weaker than opened"),
        ({"phi_ratio": "8"}, "tougher than opened"),
        ({"phi_ratio": "1", "law": "xu-needleman"}, "as tough as opened"),
        ({"phi_ratio": "0"}, "by opening alone"),
    ):
        order(session, "scene", **values)
        page = session.features["pages"].page
        for job in session.jobs.pool.jobs:
            if job.call[0] is relative_toughness and not job.done():
                session.jobs.pool.does(job)
        assert words in page.published["texts"]["law-toughness-text"]
        drawn = page.published["law"]["toughness"]
        if values["phi_ratio"] == "0":
            assert drawn is None
        else:
            expected = toughness(session.scene, np.radians(drawn["angle"]))
            assert drawn["value"] == pytest.approx(expected, rel=1e-6)


def test_every_law_has_its_sentence_on_the_page_of_the_law():
    assert law.TEXTS.keys() == CHOICES["law"].keys()
