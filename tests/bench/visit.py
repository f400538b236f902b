"""What a first visit costs a browser: its largest contentful paint, the first picture of the run, and the bytes.

`python tests/bench/visit.py [--url URL] [--visits N]` opens the page in new contexts, which have nothing stored, of one
browser, on 1440 x 900; the server is warm. Times are from the start of the navigation; it prints medians.
"""

import argparse
import os
import shutil
from statistics import median

from latency import BROWSER, bytes_of, served
from playwright.sync_api import sync_playwright

DRAWN = """async () => {
  while (!(window.punch?.run?.length > 1) || punch.fresh) await new Promise(requestAnimationFrame)
  return performance.now()
}"""
LARGEST = """() => new Promise((tell) => {
  const seen = (list) => tell(list.getEntries().at(-1).startTime)
  new PerformanceObserver(seen).observe({ type: "largest-contentful-paint", buffered: true })
})"""


def visit(browser, url):
    """(ms of the largest paint, ms until the first picture, MB) of a visit."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page, received = context.new_page(), []
    session = context.new_cdp_session(page)
    session.send("Network.enable")
    session.on("Network.webSocketFrameReceived", lambda event: received.append(bytes_of(event["response"])))
    session.on("Network.loadingFinished", lambda event: received.append(event["encodedDataLength"]))
    page.goto(url)
    drawn, largest = page.evaluate(DRAWN), page.evaluate(LARGEST)
    page.wait_for_function("() => punch.status.state === 'finished'", timeout=120_000)
    context.close()
    return largest, drawn, sum(received) / 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url", help="of a running app (default: start a server)")
    parser.add_argument("--visits", type=int, default=15, help="at most 100; one before them is not counted")
    options = parser.parse_args()
    with served(options.url) as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=os.environ.get("CHROMIUM") or shutil.which("chromium"), args=BROWSER
        )
        visits = [visit(browser, url) for _ in range(1 + min(options.visits, 100))][1:]
        browser.close()
    largest, drawn, size = (median(column) for column in zip(*visits, strict=True))
    print(f"largest contentful paint {largest:.0f} ms, first picture {drawn:.0f} ms, {size:.2f} MB")


if __name__ == "__main__":
    main()
