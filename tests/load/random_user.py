"""A user who does anything: clicks, drags, keys, sizes and pages at random, while console, log and screen are watched.

`python tests/load/random_user.py --minutes 10 [--seed N] [--touch] [--json FILE]` starts the server itself, on
loopback; with --touch the user has a phone. Every few actions the user waits for the run and compares what the page
shows: sliders with entries and with the scene of the run, sentence and curves with its frames, chips with pins. It
prints errors, contradictions and the actions that led to each. The seed decides on the actions, but not on how far runs
have come when they happen.
"""

import argparse
import random
import sys
import time
from collections import Counter
from pathlib import Path
from shutil import which

from client import tell
from playwright.sync_api import Error, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from served import TROUBLE, Server

BROWSER = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--disable-background-networking"]
SIZES = (1440, 900), (1280, 720), (820, 1180), (390, 844), (844, 390), (720, 450), (1920, 1080), (400, 300)
PHONE = {"viewport": {"width": 390, "height": 844}, "has_touch": True, "is_mobile": True, "device_scale_factor": 2}
KEYS = (
    *("Space", "ArrowLeft", "ArrowRight", "Shift+ArrowRight", "Home", "End", "[", "]", "r", "p", "l", "c", "m", "?"),
    *("Escape", "Tab", "Shift+Tab", "Enter", "ArrowUp", "ArrowDown"),
)
TYPED = ("0", "0.3", "-0.5", "1e3", "7", "abc", "", "1,5", "-1e9", "∞", "x" * 100)
START = "", "?more=1", "?view=projector", "?preset=rough", "?preset=fig4a-blue", "?preset=unload", "?page=regimes"
PATIENCE = 120_000  # ms; a limit against hanging
LOOK_EVERY = 12  # actions between two comparisons
RELOAD_EVERY = 150  # actions of one visit
TOLD = 8  # last actions told with what is wrong
REST = """() => window.punch?.run?.whole && !punch.run.followed && !punch.run.stored && !punch.fresh && !punch.dragging
    && !punch.stale && ['finished', 'skipped'].includes(punch.status.state) && punch.run.length === punch.status.frames
    || document.getElementById('status').dataset.state === 'failed'"""
PLAY = "document.getElementById('play').click()"
SEEN = "(what) => [...document.querySelectorAll(what)].filter((e) => e.checkVisibility({ visibilityProperty: true }))"
PICK = f"""([what, part]) => {{
    // the middle of one of what is in sight, and its name
    const open = document.querySelector('dialog:modal'), page = ({SEEN})(what)
    const all = page.filter((e) => (!open || open.contains(e)) && !e.disabled && !e.closest('[download]'))
    const one = all[Math.floor(part * all.length)], box = one?.getBoundingClientRect()
    return one && [box.x + box.width / 2, box.y + box.height / 2, one.id || one.textContent.trim().slice(0, 24)]
}}"""
WRONG = """async () => {
    // what the page says against itself, at rest
    const { nowSentence } = await document.documentElement.module("features/sentence/sentence.js")
    const wrong = [], { run, status, drawn } = punch, by = (id) => document.getElementById(id)
    const differ = (what, a, b) => { if (`${a}` !== `${b}`) wrong.push(`${what}: ${a} against ${b}`) }
    if (status.state === 'failed' || !(run.sheared >= 0)) return wrong
    for (const name of ['delta_bar', 'phi_ratio', 'E']) {
        const { [name]: value } = status.values, entry = by(`${name}-entry`)
        if (!status.errors[name] && document.activeElement !== entry) differ(`entry of ${name}`, entry.value, value)
        differ(`${name} of the run`, Number(run.scene[name]), Number(value))
    }
    differ('grey', document.querySelector('.hero').ariaBusy, false)
    if (!punch.playing && punch.preview === null && !punch.instead) {
        const k = Math.min(drawn, run.length - 1)
        differ('sentence', by('sentence').textContent, nowSentence(run, k).text)
        differ('increment', by('scrub').value, k)
        const gaps = [...charts.punch.parts.surface.y], frame = run.frame(k)
        differ('nodes', gaps.length, frame.gap.length)
        if (gaps.some((gap, i) => gap !== frame.gap[i])) wrong.push('the surface is that of another increment')
    }
    for (const [view, label, name] of [['forces', 'F', 'F'], ['area', 'A', 'A']]) {
        const seen = document.querySelector(`.view[data-view=${view}]`).checkVisibility({ visibilityProperty: true })
        if (!seen) continue // what is not in sight is not drawn
        const { y } = charts[view].parts[label], most = Math.max(...y), own = run.drawn(name, punch.approach)
        if (most && Math.abs(most / (Math.max(...own.value) || 1) - 1) > 1e-3)
            wrong.push(`curve ${label}: largest ${most} against ${Math.max(...own.value)}`)
    }
    differ('chips', document.querySelectorAll('.chip').length, punch.pins.length)
    for (const text of document.body.innerText.match(/\\b(undefined|NaN|null|Infinity)\\b/g) ?? []) wrong.push(text)
    return wrong
}"""


class User:
    """One browser tab, and what is wrong with it."""

    sizes = SIZES

    def __init__(self, page, server, seed):
        self.page, self.server, self.random = page, server, random.Random(seed)
        self.done, self.count, self.found, self.loud = [], Counter(), [], 0
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: self.tell(f"page: {error}\n{error.stack}"))
        page.on("console", lambda said: self.tell(f"console: {said.text}") if said.type == "error" else None)
        page.on("dialog", lambda dialog: dialog.dismiss())

    def tell(self, what):
        self.found.append({"what": what, "after": self.done[-TOLD:]})

    def open(self):
        query = self.random.choice(START)
        self.done.append(f"open {query}")
        self.page.goto(self.server.address + query, wait_until="commit")
        self.page.wait_for_function("() => window.punch?.run?.length", timeout=PATIENCE)

    def at(self, what):
        """(x, y) of one of what is in sight, or None."""
        found = self.page.evaluate(PICK, [what, self.random.random()])
        if not found:
            return None
        self.done[-1] += f" {found[2]}"
        size = self.page.viewport_size
        x, y = (min(max(at, 1), most - 2) for at, most in zip(found[:2], (size["width"], size["height"]), strict=True))
        return x, y

    def tap(self, x, y, times=1):
        self.page.mouse.click(x, y, click_count=times)

    def stroke(self, places):
        """Draw the pointer along some places, pressed."""
        self.page.mouse.move(*places[0])
        self.page.mouse.down()
        for place in places[1:]:
            self.page.mouse.move(*place)
        self.page.mouse.up()

    def hover(self, x, y):
        self.page.mouse.move(x, y)

    def click(self):
        if place := self.at("button, input[type=checkbox], #row label, #chosen label, #one label, .mark, summary"):
            self.tap(*place)

    def press(self):
        key = self.random.choice(KEYS)
        self.done[-1] += f" {key}"
        self.page.keyboard.press(key)

    def drag(self):
        place = self.at("input[type=range], #punch-view, #lens")
        if not place:
            return
        places = [place]
        for _ in range(self.random.randint(1, 25)):
            x, y = places[-1]
            places.append((x + self.random.uniform(-25, 25), y + self.random.uniform(-8, 8)))
        self.stroke(places)

    def choose(self):
        self.page.evaluate(
            f"""(parts) => {{
                const all = ({SEEN})('select'), menu = all[Math.floor(parts[0] * all.length)]
                if (!menu || document.querySelector('dialog:modal')?.contains(menu) === false) return
                menu.selectedIndex = Math.floor(parts[1] * menu.options.length)
                menu.dispatchEvent(new Event('change', {{ bubbles: true }}))
            }}""",
            [self.random.random(), self.random.random()],
        )

    def type(self):
        if place := self.at("input[type=text], input[type=search]"):
            text = self.random.choice(TYPED)
            self.done[-1] += f" {text[:12]}"
            self.tap(*place, times=3)
            self.page.keyboard.type(text)
            self.page.keyboard.press(self.random.choice(("Enter", "Tab", "Escape")))

    def resize(self):
        width, height = self.random.choice(self.sizes)
        self.done[-1] += f" {width} x {height}"
        self.page.set_viewport_size({"width": width, "height": height})

    def turn(self):
        names = self.page.evaluate("[...document.querySelectorAll('nav button')].map((e) => e.dataset.page)")
        name = self.random.choice(names)
        self.done[-1] += f" {name}"
        self.page.evaluate("(name) => document.querySelector(`nav button[data-page='${name}']`).click()", name)

    def point(self):
        if place := self.at(".view"):
            x, y = (max(at + self.random.uniform(-60, 60), 0) for at in place)
            self.hover(x, y)
            if self.random.random() < 0.6:
                self.tap(x, y)

    def history(self):
        self.page.evaluate("(way) => history.go(way)", self.random.choice((-1, -1, 1)))

    def act(self):
        """One action, and at times a look at what came of it."""
        actions = {"click": 8, "press": 4, "drag": 4, "turn": 2, "point": 2, "type": 2, "choose": 1, "resize": 1}
        name = self.random.choices([*actions, "history"], [*actions.values(), 0.5])[0]
        self.done.append(name)
        self.count[name] += 1
        try:
            getattr(self, name)()
            if self.random.random() < 1 / LOOK_EVERY:
                self.look()
        except Error as error:
            if "context was destroyed" not in str(error):  # a click or Back has led elsewhere
                raise
            self.open()
        if self.random.random() < 1 / RELOAD_EVERY or "/app" not in self.page.url:
            self.open()
        for line in self.server.lines[self.loud :]:
            if TROUBLE.search(line) or "WARNING" in line or "Failed" in line:
                self.tell(f"log: {line.strip()}")
        self.loud = len(self.server.lines)

    def look(self):
        """Wait until the page is at rest, and compare what it shows."""
        self.count["look"] += 1
        pause = self.random.random() < 0.7
        try:
            self.page.wait_for_function(REST, timeout=PATIENCE)
            if pause:
                self.page.evaluate(f"() => {{ if (punch.playing) {PLAY} }}")
                self.page.wait_for_function(f"() => !punch.playing && ({REST})()", timeout=PATIENCE)
            self.page.wait_for_timeout(400)  # a change of size comes to its end; what is wrong for longer is told
            if self.page.evaluate(REST):
                for wrong in self.page.evaluate(WRONG):
                    self.tell(f"contradiction: {wrong}")
        except Error as error:
            state = self.page.evaluate("JSON.stringify([punch.status.state, punch.stale, punch.lost, punch.fresh])")
            if '"running"' in state:  # an expensive scene was typed
                self.count["expensive"] += 1
            else:
                self.tell(f"never at rest: {state} {str(error)[:80]}")
            self.open()


class Phone(User):
    """The same with a finger, on a phone that is turned at times."""

    sizes = (390, 844), (844, 390)

    def tap(self, x, y, times=1):
        self.page.touchscreen.tap(x, y)
        if times > 1:
            self.page.keyboard.press("Control+a")

    def stroke(self, places):
        """Draw a finger along some places."""
        finger = self.page.context.new_cdp_session(self.page)
        for i, (x, y) in enumerate(places):
            points = [{"x": x, "y": y}]
            finger.send("Input.dispatchTouchEvent", {"type": "touchMove" if i else "touchStart", "touchPoints": points})
        finger.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
        finger.detach()

    def hover(self, x, y):
        """A finger points at nothing without touching it."""

    def press(self):
        """A phone has no keys while no entry is open."""


def visit(server, options):
    """Actions of one user until the time is over: what was done, and what was wrong."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=which("chromium"), args=BROWSER)
        page = browser.new_page(**(PHONE if options.touch else {}))
        user = (Phone if options.touch else User)(page, server, options.seed)
        user.open()
        end = time.monotonic() + 60.0 * options.minutes
        while time.monotonic() < end:
            user.act()
        browser.close()
    return {"seed": options.seed, "actions": dict(user.count), "errors": user.found}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--minutes", type=float, default=10.0, help="at most 60")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--touch", action="store_true", help="with a finger on a phone")
    parser.add_argument("--json", help="file for what was found")
    options = parser.parse_args()
    options.minutes = min(options.minutes, 60.0)
    server = Server()
    try:
        server.wait_for("workers are warm")
        report = visit(server, options)
    finally:
        server.stop()
    tell(report, options.json)


if __name__ == "__main__":
    main()
