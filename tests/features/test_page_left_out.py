"""Every feature may be left out, and all of them: the page computes, plays and answers as with all."""

import subprocess

import pytest
from copied import NAMES, copy_without
from served import ROOT, TROUBLE, Server, enter, finished, values_are
from tabs import Tabs

LAST = "Object.fromEntries(['F', 'L', 'A'].map((name) => [name, punch.run.curves[name].at(-1)]))"


def turn():
    """A number that is the same in one checkout: that of its commit, or 0 outside of a repository."""
    ran = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False)
    return int(ran.stdout[:8] or "0", 16)


def by_turns(count=3):
    """Names of features; another commit has others."""
    return [NAMES[(turn() + k * len(NAMES) // count) % len(NAMES)] for k in range(count)]


def dragged(page, slider, pixels):
    """Drag a slider by the mouse, and let it go, once the page follows."""
    box = page.locator(f"#{slider}").bounding_box()
    at, end = page.locator(f"#{slider}").evaluate("(input) => [input.valueAsNumber, Number(input.max)]")
    x, y = box["x"] + 8 + at / end * (box["width"] - 16), box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + pixels, y, steps=4)
    page.wait_for_function("punch.run?.followed")
    page.mouse.up()


def used(server, browser):
    """F, L and A at the end of a run, after a visitor has done what all do. Fails if the page or the server complains.

    Where the mouse leaves the slider depends on the layout, but the entry decides.
    """
    tabs = Tabs(server, browser)
    try:
        page = tabs.open()
        finished(page)
        dragged(page, "E", 20)
        page.wait_for_function("punch.run && !punch.run.followed && punch.status.values.E !== 70")
        finished(page)
        for playing in ("true", "false"):
            page.locator("#play").click()
            page.wait_for_function(f"punch.playing === {playing}")
        enter(page, "E", "90")
        values_are(page, E=90)
        return page.evaluate(LAST)
    finally:
        tabs.close()
        tabs.check()


def used_alone(browser, **how):
    """What `used` finds with a server of its own, whose log is clean."""
    server = Server(**how)
    try:
        server.wait_for("workers are warm")
        return used(server, browser)
    finally:
        server.stop()
        assert not [line for line in server.lines if TROUBLE.search(line)], "".join(server.lines)


@pytest.fixture(scope="module")
def expected(server, browser):
    """What `used` finds with all features."""
    return used(server, browser)


@pytest.mark.slow
@pytest.mark.parametrize("chosen", ["none", *(f"-{name}" for name in by_turns())])
def test_without_a_feature_a_visitor_finds_the_same(browser, expected, chosen):
    assert used_alone(browser, APP_FEATURES=chosen) == expected


@pytest.mark.thorough
@pytest.mark.parametrize("name", NAMES)
def test_a_feature_that_is_deleted_is_not_missed(browser, expected, name):
    with copy_without(name) as folder:
        assert used_alone(browser, root=folder) == expected
