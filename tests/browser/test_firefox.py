"""The page in Firefox: it loads, computes, follows a slider and starts the tour, without an error in the console."""

import os
import shutil

import pytest
from firefox import Firefox
from served import FINISHED, PATIENCE


@pytest.fixture
def firefox(tmp_path):
    path = shutil.which("firefox-esr") or shutil.which("firefox")
    if path is None:
        (pytest.fail if os.environ.get("CI") else pytest.skip)("no firefox-esr or firefox on PATH")
    opened = Firefox(path, tmp_path, PATIENCE / 1000)
    yield opened
    opened.close()
    assert not opened.errors


@pytest.mark.thorough
def test_page_runs_in_firefox_from_loading_to_the_tour(server, firefox):
    firefox.open(f"{server.address}?delta_bar=0.1")
    firefox.wait_for(f"({FINISHED})()")
    slider = "document.getElementById('delta_bar')"
    box = f"(({{ left, width, top, height }}) => [left, width, top + height / 2])({slider}.getBoundingClientRect())"
    left, width, y = firefox.evaluate(box)
    part = firefox.evaluate(f"(({{ min, max, value }}) => (value - min) / (max - min))({slider})")
    firefox.drag((left + part * width, y), (left + (part + 0.1) * width, y))
    firefox.wait_for("punch.run.scene?.delta_bar > 0.15 && !punch.run.followed")
    firefox.wait_for(f"({FINISHED})()")
    firefox.evaluate("document.getElementById('menu').click()")
    firefox.wait_for("document.getElementById('theme').checkVisibility()")
    firefox.evaluate("document.getElementById('theme').click()")
    firefox.wait_for("!document.getElementById('theme').checkVisibility()")
    firefox.evaluate("document.getElementById('tour').click()")
    firefox.wait_for("document.querySelector('#tour-card button.answer')")
    firefox.evaluate("punch.speed = 40, document.querySelector('#tour-card button.answer').click()")
    firefox.wait_for("document.querySelector('#tour-card [role=status]')?.textContent")
