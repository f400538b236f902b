"""How often the page draws the large picture while a run plays, and how busy the browser is.

    python tests/bench/fringes.py [--seconds S]

Chromium without a graphics processor, 1440 x 900, the default run at 4 and at 20 nm/s, with and without fringes. Prints
frames per second and the share of the main thread's time, measured over S seconds each (default 6).
"""

import argparse
import shutil
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from served import Server, finished

FLAGS = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]


def busy(session):
    metrics = session.send("Performance.getMetrics")["metrics"]
    return {metric["name"]: metric["value"] for metric in metrics}["TaskDuration"]


COUNT = """async () => {
    const { cover } = await import(new URL("./app/static/js/store.js", document.baseURI))
    window.counter ??= cover(["picture"], () => { window.drawn++ }) ?? true
    window.drawn = 0
}"""


def measured(page, session, seconds):
    """(frames a second, share of the main thread) while the run plays."""
    page.evaluate(COUNT)
    start, before = time.perf_counter(), busy(session)
    page.wait_for_timeout(1000 * seconds)
    passed = time.perf_counter() - start
    return page.evaluate("window.drawn") / passed, (busy(session) - before) / passed


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=6.0, metavar="S")
    arguments = parser.parse_args()
    server = Server()
    server.wait_for("workers are warm")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        for width, height in ((1440, 900), (390, 844)):
            page = browser.new_page(viewport={"width": width, "height": height})
            page.goto(server.address)
            finished(page)
            page.wait_for_timeout(5000)  # pictures of the row come
            session = page.context.new_cdp_session(page)
            session.send("Performance.enable")
            for fringes in (True, False):
                page.evaluate(f"document.getElementById('fringes-on').checked = {str(fringes).lower()}")
                page.evaluate("document.getElementById('fringes-on').dispatchEvent(new Event('change'))")
                for speed in (4, 20):
                    page.evaluate(f"punch.speed = {speed}; punch.at = punch.run.sheared")
                    rate, share = measured(page, session, arguments.seconds)
                    print(
                        f"{width} x {height}, {speed:2d} nm/s, fringes {fringes}: {rate:.1f} frames/s, {share:.0%} busy"
                    )
        browser.close()
    server.stop()


if __name__ == "__main__":
    main()
