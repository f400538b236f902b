"""How soon the research pages open, what a visit costs the server, and how much they delay other visitors.

`python tests/bench/lab.py [--visits N] [--moves N] [--only PAGE]` starts a server and prints, for each page that was
open before, the time from the request until all its plots are drawn, and the server's processor time (Linux); when the
page Accuracy shows the stored diagram, its first own point and its result; and the age of a drag's pictures for one
visitor, without and with another visitor for whom this page computes. Numbers are medians.
"""

import argparse
import os
import shutil
import sys
import time
from pathlib import Path
from statistics import median

from latency import BROWSER, drag, settle
from playwright.sync_api import sync_playwright
from served import PATIENCE, Server

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.features.lab.feature import listed

MODELS = "[...(window.Bokeh?.documents[0]?._all_models.values() ?? [])]"
DRAWN = f"""() => {{
    const figures = {MODELS}.filter((model) => model.type === "Figure")
    return figures.length && figures.every((figure) => Bokeh.index.find_one(figure)?.frame?.bbox.width > 0)
}}"""
POINT = f"""(alpha) => {MODELS}.some(({{ type, glyph, data_source: of }}) => type === "GlyphRenderer"
    && glyph.type === "Scatter" && Array.from(of.data.x).some((x, i) => x > 0 && of.data.alpha[i] === alpha))"""
PALE, OWN = 0.3, 1.0  # opacity of stored points and of those of the scene
ROUNDS = 3  # drags with and without another visitor, in turn


def processor_time(pid):
    """Processor time of a process so far, s; 0 where the system does not show it."""
    file = Path(f"/proc/{pid}/stat")
    if not file.exists():
        return 0.0
    fields = file.read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def opened(browser, address):
    """(tab, s until all plots are drawn)."""
    tab = browser.new_page(viewport={"width": 1440, "height": 900})
    tab.set_default_timeout(PATIENCE)
    start = time.monotonic()
    tab.goto(address)
    tab.wait_for_function(DRAWN)
    return tab, time.monotonic() - start


def visits(browser, server, name, count):
    """Print the medians of visits to a page that was open before."""
    seconds, costs = [], []
    for _ in range(count + 1):
        before = processor_time(server.process.pid)
        tab, took = opened(browser, f"{server.address}?lab={name}")
        tab.close()
        seconds.append(took)
        costs.append(processor_time(server.process.pid) - before)
    print(f"{name:10s} opens in {median(seconds[1:]):.2f} s, server {median(costs[1:]):.2f} s a visit", flush=True)


def accuracy(browser, server):
    """Print when the page Accuracy of the default scene shows its parts."""
    warm = browser.new_page()
    warm.goto(f"{server.address}?lab=none")
    warm.get_by_text("There is no page").wait_for()
    warm.close()
    start = time.monotonic()
    tab, _ = opened(browser, f"{server.address}?lab=accuracy")
    for what, ready, alpha in (("stored diagram", POINT, PALE), ("first own point", POINT, OWN)):
        if alpha == OWN:
            tab.get_by_role("button", name="Measure this scene").click()
        tab.wait_for_function(ready, arg=alpha)
        print(f"accuracy   {what} after {time.monotonic() - start:.2f} s", flush=True)
    tab.get_by_role("button", name="Cancel").wait_for(state="hidden")
    print(f"accuracy   whole diagram after {time.monotonic() - start:.1f} s", flush=True)
    tab.close()


def drags(browser, server, moves):
    """Print the age of a drag's pictures, and its ratio with another visitor for whom the page Accuracy computes."""
    tab, ages = browser.new_page(viewport={"width": 1440, "height": 900}), {False: [], True: []}
    tab.set_default_timeout(PATIENCE)
    tab.goto(f"{server.address}?E=70.5")
    tab.wait_for_function("() => window.punch?.status.state === 'finished'")
    for turn in range(2 * ROUNDS):
        busy = turn % 2 == 1
        other = opened(browser, f"{server.address}?lab=accuracy&E={71 + turn}")[0] if busy else None
        if other:
            other.get_by_role("button", name="Measure this scene").click()
            other.wait_for_function(POINT, arg=OWN)
        tab.bring_to_front()  # a tab in the background is not drawn
        settle(tab)
        ages[busy].append(drag(tab, "delta_bar", 1 if turn % 4 < 2 else -1, moves, [])["age p50"])
        if other:
            other.close()
    alone, beside = (median(ages[busy]) for busy in (False, True))
    print(f"drag       age of a picture {alone:.0f} ms alone, {beside:.0f} ms beside Accuracy: {beside / alone:.2f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--visits", type=int, default=10, help="to each page")
    parser.add_argument("--moves", type=int, default=40, help="of a drag")
    parser.add_argument("--only", choices=listed(), help="measure only visits to this page")
    options = parser.parse_args()
    server = Server()
    try:
        server.wait_for("workers are warm")
        with sync_playwright() as playwright:
            path = os.environ.get("CHROMIUM") or shutil.which("chromium")
            browser = playwright.chromium.launch(executable_path=path, args=BROWSER)
            if not options.only:
                accuracy(browser, server)  # first: workers are free
                drags(browser, server, options.moves)
            for name in [options.only] if options.only else listed():
                visits(browser, server, name, options.visits)
            browser.close()
    finally:
        server.stop()


if __name__ == "__main__":
    main()
