"""Take the pictures of README and docs from the real app in a real Chromium.

    python docs/pictures.py [--chromium PATH] [--quick]

Draws the small pictures of the row of experiments (row.py) and run.png, the plot of README's example. Then starts the
app on a free port; writes app.webp and slip.webp, the punch through two slips, beside this file. Without --quick it
measures the default scene for minutes and draws accuracy.png (tests/bench/curves.py).
"""

import argparse
import re
import shutil
import socket
import subprocess
import sys
from io import BytesIO
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright
from row import main as draw_row

from solver import Scene, simulate

HERE = Path(__file__).parent
READY = "() => window.punch?.status.state === 'finished' && punch.run.whole && !punch.fresh"
SHOW = "([scrub, k]) => { scrub.value = k; scrub.dispatchEvent(new Event('input')) }"
FIRST, LAST, STEP = 96, 146, 2  # increments of the shear in the animation
PACE, WIDE = 120, 720  # of the animation: ms for each picture, pixels
SMALL = {"quality": 75, "method": 6}  # of WebP: text stays sharp at a sixth of a PNG's bytes


def served():
    """The running server, once its workers are warm, and its address."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    command = [Path(sys.executable).parent / "panel", "serve", "app", "--port", str(port)]
    server = subprocess.Popen(command, cwd=HERE.parent, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    for line in server.stdout:
        if re.search("workers are warm", line):
            return server, f"http://localhost:{port}/app"
    raise SystemExit("the server ended before its workers were warm")


def opened(browser, address, size):
    page = browser.new_page(viewport=dict(zip(("width", "height"), size, strict=True)), color_scheme="light")
    page.goto(address)
    page.wait_for_function(READY, timeout=120_000)
    page.locator("#play").click()
    return page


def shown(page, k):
    """Show increment k of the shear, and wait until it is painted."""
    at = page.evaluate("punch.run.sheared") + k
    page.evaluate(SHOW, [page.locator("#scrub").element_handle(), at])
    page.wait_for_function(f"() => punch.drawn === {at}")
    page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def take(browser, address):
    page = opened(browser, address, (1440, 900))
    shown(page, 109)
    page.wait_for_function("() => charts.punch.parts.fringes.picture", timeout=120_000)
    shown(page, 109)
    _save(page, "app.webp")
    plain = "(of) => { of.value = 'plain'; of.dispatchEvent(new Event('change')) }"
    page.locator("#stress").evaluate(plain)  # fringes: their colours are too many for a GIF
    images = []
    for k in range(FIRST, LAST, STEP):
        shown(page, k)
        image = Image.open(BytesIO(page.locator("#punch-view").screenshot())).convert("RGB")
        images.append(image.resize((WIDE, WIDE * image.height // image.width)))
    images[0].save(HERE / "slip.webp", save_all=True, append_images=images[1:], duration=PACE, loop=0, **SMALL)


def _save(what, name):
    """A screenshot of a page or a part of it, beside this file."""
    Image.open(BytesIO(what.screenshot())).convert("RGB").save(HERE / name, **SMALL)


def measure():
    """Write accuracy.png: error against run time by four methods."""
    bench = HERE.parent / "tests" / "bench" / "curves.py"
    subprocess.run([sys.executable, bench, "--picture", HERE / "accuracy.png"], cwd=HERE.parent, check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--chromium", default=shutil.which("chromium") or shutil.which("google-chrome"))
    parser.add_argument("--quick", action="store_true", help="leave accuracy.png as it is")
    arguments = parser.parse_args()
    simulate(Scene(delta_bar=0.2, phi_ratio=0.5)).save(HERE / "run.png")
    draw_row()
    server, address = served()
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=arguments.chromium, args=["--no-sandbox"])
            take(browser, address)
            browser.close()
    finally:
        server.terminate()
        server.wait(30)
    if not arguments.quick:
        measure()


if __name__ == "__main__":
    main()
