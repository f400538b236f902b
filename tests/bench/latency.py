"""How soon a moved slider shows: the first changed frame and the whole new curve, in a real browser, p50 and p95.

Run `panel serve app` first, then `python tests/bench/latency.py [--url URL] [--moves N] [--drag] [--known]`. Times are
taken in the page, from the slider's input event to the animation frame after that in which the new run was painted;
one visitor, warm.
The scenes are new to the server (its stiffness is a little different each time) unless asked otherwise.
"""

import argparse
import os
import shutil
import time

from playwright.sync_api import sync_playwright

from app.session.computing import coarse
from solver import Scene, advance

WATCH = """
() => {
  const slider = document.getElementById("delta_bar")
  window.marks = []
  const entry = document.getElementById("delta_bar-entry")
  window.curves = []  // whole new ones: when painted, and how long after their value was chosen
  slider.addEventListener("input", (event) => { // after the page, which writes the value into the entry
    marks.push({ at: event.timeStamp, run: punch.run.number, value: Number(entry.value) })
  })
  const watch = () => {
    const now = performance.now(), run = punch.run, shown = marks.find(({ value }) => value === run.scene?.delta_bar)
    const painted = run.whole && !punch.fresh && shown && curves.at(-1)?.run !== run.number
    if (painted) curves.push({ run: run.number, at: now, age: now - shown.at })
    for (const mark of marks) {
      if (run.number <= mark.run || punch.fresh) continue
      if (!mark.first && run.sheared >= 0) mark.first = now - mark.at
      if (!mark.whole && run.whole) mark.whole = now - mark.at
    }
    requestAnimationFrame(watch)
  }
  watch()
}
"""
SETTLED = "() => punch.status.state === 'finished' && marks.every((mark) => mark.whole)"
BROWSER = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]


def percentile(values, part):
    """The smallest value that `part` of all do not exceed."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))]


def measure(page, moves, drag):
    """Move the slider `moves` times by keyboard, waiting for every whole curve unless dragging; milliseconds."""
    page.wait_for_function("() => window.punch?.status.state === 'finished'", timeout=120_000)
    page.evaluate(WATCH)
    page.focus("#delta_bar")
    for _ in range(moves):
        if drag:  # the key stays down, and repeats
            page.keyboard.down("ArrowRight")
            page.wait_for_timeout(30)  # the rhythm of a hand, not a wait for a state
        else:
            page.keyboard.press("ArrowRight")
            page.wait_for_function(SETTLED, timeout=60_000)
    page.keyboard.up("ArrowRight")
    page.wait_for_function(SETTLED, timeout=60_000)
    return page.evaluate("[marks, curves]")


def bare_run():
    """Milliseconds of a coarse run by itself, in this process, the second one of two."""
    for E in (70.0, 70.1):
        begun = time.perf_counter()
        advance(coarse(Scene(E=E)), None, float("inf"))
    return 1000 * (time.perf_counter() - begun)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url", default="http://localhost:5006/app")
    parser.add_argument("--moves", type=int, default=60, help="at most 130: from delta_bar = -0.3 on, 0.01 at a time")
    parser.add_argument("--known", action="store_true", help="the same scenes every time: found on the server's shelf")
    parser.add_argument("--drag", action="store_true", help="move on every 30 ms without waiting, as a hand does")
    options = parser.parse_args()
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=BROWSER)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        stiffness = 70.0 if options.known else 70.0 + time.time() % 1.0
        page.goto(f"{options.url}?delta_bar=-0.3&E={stiffness:.6f}")
        marks, curves = measure(page, options.moves, options.drag)
        runs = page.evaluate("punch.run.number") - 1
        browser.close()
    load = " ".join(f"{part:.1f}" for part in os.getloadavg())
    print(f"{len(marks)} moves, {runs} runs; load of this machine {load}, {os.cpu_count()} cores")
    for what, name in (("first", "first changed frame"), ("whole", "whole new curve")):
        times = [mark[what] for mark in marks]
        print(f"{name:20s} p50 {percentile(times, 0.5):4.0f} ms   p95 {percentile(times, 0.95):4.0f} ms")
    if options.drag:
        print(f"a coarse run by itself: {bare_run():.0f} ms")
        held = [curve for curve in curves if curve["at"] <= marks[-1]["at"] + 250]
        seconds = (marks[-1]["at"] - marks[0]["at"]) / 1000
        ages = [curve["age"] for curve in held] or [float("inf")]
        print(f"{len(held) / seconds:.1f} new curves a second while dragging; age of each when painted", end=" ")
        print(f"p50 {percentile(ages, 0.5):.0f} ms   p95 {percentile(ages, 0.95):.0f} ms")


if __name__ == "__main__":
    main()
