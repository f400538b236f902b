"""The recipe of a feature in CONTRIBUTING works as printed, in a folder outside of the repository."""

import re
from pathlib import Path

from served import Server
from tabs import Tabs

ROOT = Path(__file__).parents[2]
FILES = {"python": "feature.py", "html": "header.html", "js": "index.js"}
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```", re.M | re.S)


def test_the_recipe_of_a_feature_makes_one_that_is_gone_with_its_folder(browser, server, tmp_path):
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    part = text.partition("**A feature.**")[2].partition("**A page.**")[0]
    blocks = dict(BLOCK.findall(part))
    assert set(blocks) == set(FILES) and sum(block.count("\n") for block in blocks.values()) <= 30
    (tmp_path / "count").mkdir()
    for kind, name in FILES.items():
        (tmp_path / "count" / name).write_text(blocks[kind], encoding="utf-8")
    own = Server(APP_FEATURES_PATH=str(tmp_path))
    tabs = Tabs(own, browser)
    try:
        own.wait_for("Bokeh app running at")
        page = tabs.open("?nodes=512&width=1250&more=0")
        page.locator("#count").click()
        page.locator("#count", has_text="512 sites").wait_for()
        tabs.close()
        tabs.check()
    finally:
        own.stop()
    without = Tabs(server, browser)
    page = without.open()
    page.wait_for_function("window.punch?.picture")
    assert page.locator("#count").count() == 0
    without.close()
