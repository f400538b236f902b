"""How soon a moved slider shows in a real browser: the first changed frame and the whole new curve, p50 and p95.

`python tests/bench/latency.py [--url URL] [--moves N] [--drag] [--throttle N] [--json FILE]` starts a server unless it
has a --url.
The page takes the times, from the slider's input event to the animation frame after the one that painted the new run.
There is one visitor, on a warm server. Without --drag, each key step follows the curve of the one before. With it,
each of three sliders is dragged at 20 moves a second, slowly and quickly, forth and back. It prints new curves per
second, their age, the time from the release to the exact run, the duration of interactions (Event Timing), and the
bytes of a drag. --laid repeats the drags with a measured curve over the run, which was dropped on the page, and prints
how soon it was drawn, and the ratio of curves a second; --between, with the unstable branch. --throttle 4 is a school's
Chromebook: a processor 4 times as slow, on 1366 x 768. Scenes are new to the server without --known.
"""

import argparse
import json
import os
import shutil
import sys
import time
from contextlib import contextmanager
from functools import partial
from pathlib import Path

from playwright.sync_api import sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from served import Server

WATCH = """
(name) => {
  const slider = document.getElementById(name), entry = document.getElementById(`${name}-entry`)
  window.marks = []
  window.interactions = []  // ms, of Event Timing
  window.observer ??= new PerformanceObserver((list) => {
    for (const { interactionId, duration } of list.getEntries()) if (interactionId) interactions.push(duration)
  })
  observer.observe({ type: "event", durationThreshold: 16 })
  window.curves = []  // whole new ones: when painted, and how long after their value was chosen
  const mine = window.watching = {}  // what watched before ends
  slider.addEventListener("input", (event) => { // after the page, which writes the value into the entry
    if (watching === mine) marks.push({ at: event.timeStamp, run: punch.run.number, value: Number(entry.value) })
  })
  let last = punch.run
  const watch = () => {
    const now = performance.now(), { run } = punch, painted = run.whole && !punch.fresh && punch.charted === run
    const shown = marks.findLast(({ value }) => value === run.scene?.[name])
    if (painted && run !== last && shown) {
      last = run
      const followed = Boolean(run.followed)
      curves.push({ at: now, age: now - shown.at, exact: !followed, followed })
    }
    for (const mark of marks) {
      if (run.number === mark.run || punch.fresh) continue
      if (!mark.first && run.sheared >= 0) mark.first = now - mark.at
      if (!mark.whole && run.whole) mark.whole = now - mark.at
    }
    if (watching === mine) requestAnimationFrame(watch)
  }
  watch()
}
"""
RESTS = "() => punch.status.state === 'finished' && !punch.run.followed && !punch.fresh"
SETTLED = f"{RESTS} && marks.every((mark) => mark.whole)"
THERE = "(name) => Number(document.getElementById(`${name}-entry`).value) === punch.run.scene?.[name]"
BROWSER = ["--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking"]
PACE = 0.05  # s between two moves of a hand
DRAGS = {  # slider: (positions a move, slow and quick)
    "delta_bar": (1, 2),
    "phi_ratio": (-1, -2),
    "E": (1, 2),
}


def percentile(values, part):
    """The smallest value that `part` of all do not exceed."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(part * len(ordered)))] if ordered else float("inf")


def bytes_of(message):
    """The bytes of a message of a websocket as the browser reports it: binary ones in base64."""
    return len(message["payloadData"]) * (0.75 if message["opcode"] == 2 else 1.0)


def settle(page, name=None):
    """Wait for the exact run of where the slider is."""
    if name:
        page.wait_for_function(THERE, arg=name, timeout=120_000)
    page.wait_for_function(RESTS, timeout=120_000)


def step_by_step(page, moves):
    """Move the slider `moves` times by keyboard, waiting for every whole curve; milliseconds."""
    page.evaluate(WATCH, "delta_bar")
    page.focus("#delta_bar")
    for _ in range(moves):
        page.keyboard.press("ArrowRight")
        page.wait_for_function(SETTLED, timeout=60_000)
    marks = page.evaluate("marks")
    for what, name in (("first", "first changed frame"), ("whole", "whole new curve")):
        times = [mark[what] for mark in marks]
        print(f"{name:20s} p50 {percentile(times, 0.5):4.0f} ms   p95 {percentile(times, 0.95):4.0f} ms")


def drag(page, name, positions, moves, received):
    """Drag a slider by so many positions a move from where it is: what was seen; received: bytes of each message."""
    page.evaluate(WATCH, name)
    box = page.locator(f"#{name}").bounding_box()
    at, last = (int(page.locator(f"#{name}").evaluate(f"(e) => e.{what}")) for what in ("value", "max"))

    def point(position):
        thumb = 16.0  # px, of Chromium
        return box["x"] + thumb / 2 + (box["width"] - thumb) * position / last, box["y"] + box["height"] / 2

    received.clear()
    page.mouse.move(*point(at))
    page.mouse.down()
    begun = time.monotonic()
    for k in range(1, moves + 1):
        page.mouse.move(*point(min(last, max(0, at + k * positions))))
        page.wait_for_timeout(max(1.0, 1000 * (begun + k * PACE - time.monotonic())))  # the rhythm of a hand
    page.mouse.up()
    up, size = page.evaluate("performance.now()"), sum(received)
    settle(page, name)
    page.wait_for_function("curves.at(-1)?.exact", timeout=60_000)
    marks, curves, interactions = page.evaluate("[marks, curves, interactions]")
    held = [curve for curve in curves if curve["at"] <= marks[-1]["at"] + 250 and not curve["exact"]]
    seconds = (marks[-1]["at"] - marks[0]["at"]) / 1000
    ages = [curve["age"] for curve in held]
    return {
        "curves a second": len(held) / seconds,
        "age p50": percentile(ages, 0.5),
        "age p95": percentile(ages, 0.95),
        "followed": sum(curve["followed"] for curve in held) / max(1, len(held)),
        "exact after": curves[-1]["at"] - up,
        "interactions p75": percentile(interactions or [16.0], 0.75),  # 16 ms and less are not reported
        "kB a second": size / 1e3 / seconds,
    }


def drags(page, moves):
    """Drag each slider slowly and quickly, forth and back; print each row; return {name: what was seen}."""
    found, received = {}, []
    session = page.context.new_cdp_session(page)
    session.send("Network.enable")
    session.on("Network.webSocketFrameReceived", lambda event: received.append(bytes_of(event["response"])))
    for name, ways in DRAGS.items():
        for pace, positions in zip(("slow", "quick"), ways, strict=True):
            for way, sign in (("forth", 1), ("back", -1)):
                settle(page)
                seen = found[f"{name} {pace} {way}"] = drag(page, name, sign * positions, moves, received)
                said = ", ".join(f"{what} {value:.3g}" for what, value in seen.items())
                print(f"{name:10s} {pace:5s} {way:5s} {said}", flush=True)
    seen = {what: sorted(row[what] for row in found.values()) for what in next(iter(found.values()))}
    rates = seen["curves a second"]
    print(f"curves a second: median {percentile(rates, 0.5):.1f}, worst {rates[0]:.1f}", end="; ")
    print(f"age p50: median {percentile(seen['age p50'], 0.5):.0f} ms", end="; ")
    print(f"interactions p75: median {percentile(seen['interactions p75'], 0.5):.0f} ms", end="; ")
    print(f"kB a second: median {percentile(seen['kB a second'], 0.5):.0f}")
    return found


LAY = """async (text) => {
  const began = performance.now(), dataTransfer = new DataTransfer()
  dataTransfer.items.add(new File([text], "curve.csv"))
  document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, cancelable: true, bubbles: true }))
  while (document.getElementById("file-use")?.disabled ?? true) await new Promise(requestAnimationFrame)
  document.getElementById("file-use").click()
  while (!charts.forces.parts.laid_F.x.length || punch.fresh) await new Promise(requestAnimationFrame)
  return performance.now() - began
}"""


def drags_with(more, page, moves):
    """Drag without and with what `more` opens on the page; print the ratio."""
    drags(page, moves)  # scripts and server are warm then
    without = drags(page, moves)
    more(page)
    found = drags(page, moves)
    ratios = [found[name]["curves a second"] / without[name]["curves a second"] for name in found]
    print(f"curves a second with over without: median {percentile(ratios, 0.5):.2f}")
    return found


def lay_a_curve(page):
    """Drop a measured curve over the run; print how soon it is drawn."""
    rows = "\n".join(f"{0.1 * k:.1f},{150 * (1 - 0.5 ** (0.03 * k)):.4f}" for k in range(1, 401))
    print(f"dropped curve of 400 points drawn after {page.evaluate(LAY, 'U_x (nm),F (N/m)' + chr(10) + rows):.0f} ms")


def open_the_branch(page):
    """Open the unstable branch, and wait for it."""
    page.evaluate("document.getElementById('unstable').click()")
    page.wait_for_function("punch.unstable.length > 0", timeout=60_000)


@contextmanager
def served(url):
    """The address of the app: `url`, or that of a server with warm workers, which is stopped at the end."""
    if url:
        yield url
        return
    server = Server()
    try:
        server.wait_for("workers are warm")
        yield server.address
    finally:
        server.stop()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--url", help="of a running app (default: start a server)")
    parser.add_argument("--moves", type=int, default=40, help="of a drag or, step by step, of all: 120 at most")
    parser.add_argument("--known", action="store_true", help="the same scenes every time, which the server has stored")
    parser.add_argument("--drag", action="store_true", help="move on every 50 ms without waiting, as a hand does")
    parser.add_argument("--laid", action="store_true", help="with --drag: again, with a measured curve over the run")
    parser.add_argument("--between", action="store_true", help="with --drag: again, with the unstable branch")
    parser.add_argument("--throttle", type=float, default=1.0, help="times as slow a processor, on a small screen")
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium")
    with served(options.url) as url, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=BROWSER)
        width, height = (1366, 768) if options.throttle > 1 else (1440, 900)
        page = browser.new_page(viewport={"width": width, "height": height})
        stiffness = 70.0 if options.known else 70.0 + time.time() % 1.0
        page.goto(f"{url}?E={stiffness:.6f}" + ("" if options.drag else "&delta_bar=-0.3"))
        page.wait_for_function("() => window.punch?.status.state === 'finished'", timeout=120_000)
        page.context.new_cdp_session(page).send("Emulation.setCPUThrottlingRate", {"rate": options.throttle})
        more = lay_a_curve if options.laid else open_the_branch if options.between else None
        dragging = partial(drags_with, more) if more else drags
        found = (dragging if options.drag else step_by_step)(page, options.moves)
        browser.close()
    load = " ".join(f"{part:.1f}" for part in os.getloadavg())
    print(f"load of this machine {load}, {os.cpu_count()} cores")
    if options.json and found:
        Path(options.json).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
