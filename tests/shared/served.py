"""A server of the app, and conditions that browser tests wait for."""

import os
import re
import signal
import socket
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

from playwright.sync_api import TimeoutError as TookTooLong

ROOT = Path(__file__).parents[2]
PATIENCE = 150_000  # ms; a limit against hanging, not a claim about speed
PARABOLA = "\n".join(f"{x},{0.0001 * (x - 250) ** 2}" for x in range(0, 501, 5))  # a profile, x and z in nm
PLAYING = {"reduced_motion": "no-preference"}  # options of a tab in which runs play on and on
SETTLE = 30_000  # ms for what is laid out anew; after that a fault is one
TROUBLE = re.compile(r"error|exception|traceback|critical", re.IGNORECASE)
FINISHED = "() => window.punch?.status.state === 'finished' && !punch.fresh && punch.run.length === punch.status.frames"
FAULTS = """() => {
    const said = []
    const name = (e) => e.id ? `#${e.id}` : `${e.tagName.toLowerCase()} “${e.textContent.trim().slice(0, 30)}”`
    const seen = (e) => e.checkVisibility({ visibilityProperty: true }) && !e.closest('[hidden], .unseen')
        && getComputedStyle(e).clipPath === 'none'
    const all = (what) => [...document.querySelectorAll(what)].filter(seen)
    if (document.documentElement.scrollWidth > innerWidth) said.push(`${document.documentElement.scrollWidth} px wide`)
    const least = 100 // px, of what the axes enclose
    for (const [label, { view, box }] of Object.entries(charts).filter(([, { view }]) => view.closest('.sheet')))
        if (seen(view) && !(box?.height >= least)) said.push(`${label} has a plot ${box?.height} px high`)
    const texts = [...document.querySelectorAll('.page *')].filter((e) => seen(e)
        && [...e.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()))
    for (const e of new Set([...all('header *'), ...all('.player *'), ...texts])) {
        const box = e.getBoundingClientRect()
        if (e.closest('#row')) continue // a strip that scrolls where it is too long
        if (box.width && (box.left < -1 || box.right > innerWidth + 1)) said.push(`${name(e)} leaves the screen`)
    }
    for (const e of texts) {
        const clips = getComputedStyle(e).overflowX !== 'visible'
        if (clips && e.scrollWidth > e.clientWidth + 1) said.push(`${name(e)} is cut`)
        if (e.closest('.view, table, select, #row')) continue
        const outer = e.closest('p, div, figcaption, header, form, section')?.getBoundingClientRect()
        for (const other of e.children) {
            const inner = other.getBoundingClientRect()
            if (outer && inner.width && inner.right > outer.right + 2) said.push(`${name(other)} leaves its box`)
        }
    }
    for (const e of all('.sheet > *, .figures > *')) {
        const clips = getComputedStyle(e).overflowY !== 'visible'
        if (!clips && e.scrollHeight > e.clientHeight + 2) said.push(`${name(e)} is lower than its contents`)
    }
    // what stays on the screen while the rest scrolls lies above the rest by intention
    const layer = (e) => e.closest('.reach, header, :is(#drawer, #theory) > .top, dialog')
    const strip = document.getElementById('row')?.getBoundingClientRect() // scrolls: what lies beyond it is not seen
    const beyond = (e) => e.closest('#row') && e.getBoundingClientRect().right > strip.right
    const controls = all('button, input, select, a, [role=slider]').filter((e) => !beyond(e))
        .map((e) => [e, e.getBoundingClientRect(), layer(e)])
    controls.forEach(([a, p, from], i) => {
        for (const [b, q, other] of controls.slice(i + 1)) {
            if (from !== other || a.contains(b) || b.contains(a)) continue
            const over = Math.min(p.right, q.right) - Math.max(p.left, q.left)
            const under = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top)
            if (over > 1 && under > 1) said.push(`${name(a)} and ${name(b)} overlap`)
        }
    })
    return [...new Set(said)]
}"""


class Server:
    """`panel serve app` on a free port, or a given one, with what it logs; environment: further variables.

    root: a repository, or a copy of it; what: a file in place of the app.
    """

    def __init__(self, prefix="", port=None, root=ROOT, what="app", **environment):
        self.port = port
        if port is None:
            with socket.socket() as probe:
                probe.bind(("127.0.0.1", 0))
                self.port = probe.getsockname()[1]
        command = [Path(sys.executable).parent / "panel", "serve", what, "--port", str(self.port)]
        quick = ["--unused-session-lifetime", "1000", "--check-unused-sessions", "500"]  # ms, closed tabs
        self.process = subprocess.Popen(
            [*command, *quick, "--prefix", prefix],
            cwd=root,
            env=os.environ | {"PYTHONPATH": str(root)} | environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.lines, self.news = [], threading.Condition()
        threading.Thread(target=self._listen, daemon=True).start()
        self.origin = f"http://localhost:{self.port}"
        self.address = f"{self.origin}{prefix}/{Path(what).stem}"

    def _listen(self):
        for line in self.process.stdout:
            with self.news:
                self.lines.append(line)
                self.news.notify_all()

    def wait_for(self, pattern, since=0):
        """The first logged line from number `since` on that matches."""
        with self.news:
            found = self.news.wait_for(
                lambda: next(filter(re.compile(pattern).search, self.lines[since:]), None), PATIENCE / 1000
            )
        assert found, f"the server never logged {pattern!r}:\n{''.join(self.lines)}"
        return found

    def stop(self):
        self.process.send_signal(signal.SIGTERM)  # as process managers do; background jobs do not hear SIGINT
        self.process.wait(PATIENCE / 1000)


def patient(page):
    """A tab that waits longer than Playwright's half a minute."""
    page.set_default_timeout(PATIENCE)
    return page


def finished(page, run=1):
    """When a run is complete and drawn: number `run` of those since the page was opened, or since a test got it."""
    then = f"punch.status.run >= (window.before ?? 0) + {run}"
    for condition in (FINISHED, then, FINISHED):
        # by a timer, as looking with every picture makes the browser draw one after another
        page.wait_for_function(condition, timeout=PATIENCE, polling=50)


def from_menu(page, button):
    """Press a button of the menu."""
    page.evaluate("document.getElementById('panel').togglePopover(true)")
    page.locator(button).click()


def enter(page, name, text):
    """Write into the entry of a parameter, and press Enter."""
    page.fill(f"#{name}-entry", text)
    page.keyboard.press("Enter")


def paused_at(page, frame):
    """Stop, and show an increment; in one go, as a picture in between would set the slider back."""
    page.locator("#scrub").evaluate(f"(scrub) => {{ scrub.value = {frame}; scrub.dispatchEvent(new Event('input')) }}")
    page.wait_for_function(f"() => punch.drawn === {frame}")


def values_are(page, **values):
    """Wait until the page shows a finished run of these parameters."""
    for name, value in values.items():
        page.wait_for_function(f"punch.status.values.{name} === {value!r}", timeout=PATIENCE)
    finished(page)


def laid_out(page, size=None):
    """After the next picture of the screen, or of one of that size: (width, height).

    What lies over something only until the next picture of a busy machine is no fault.
    """
    if size:
        page.set_viewport_size(dict(zip(("width", "height"), size, strict=True)))
    page.evaluate("() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))")
    page.wait_for_function(  # the lens moves with the next drawing of the punch
        """() => {
            const [lens, view] = ['lens', 'punch-view'].map((id) => document.getElementById(id).getBoundingClientRect())
            return !lens.width || (lens.right <= view.right && lens.bottom <= view.bottom && lens.top >= view.top)
        }"""
    )
    with suppress(TookTooLong):
        page.wait_for_function(f"() => !({FAULTS})().length", timeout=SETTLE)


def faults_at(page, sizes):
    """{size: faults of the layout}, where there are any."""
    found = {}
    for width, height in sizes:
        laid_out(page, (width, height))
        if faults := page.evaluate(FAULTS):
            found[f"{width} x {height}"] = faults
    return found


def found_by_axe(page):
    """Violations that axe reports: {rule: elements}."""
    from axe_playwright_python.sync_playwright import Axe

    rules = Axe().run(page, options={"iframes": False}).response["violations"]
    return {rule["id"]: [node["html"][:160] for node in rule["nodes"]] for rule in rules}


def grab(page, name):
    """Press the mouse on the thumb of a slider; returns where each of its positions is."""
    slider = page.locator(f"#{name}")
    box, (at, last) = slider.bounding_box(), slider.evaluate("(e) => [Number(e.value), Number(e.max)]")

    def point(steps):
        thumb = 16.0  # px
        return box["x"] + thumb / 2 + (box["width"] - thumb) * (at + steps) / last, box["y"] + box["height"] / 2

    page.mouse.move(*point(0))
    page.mouse.down()
    return point


def paused(look, query):
    """The page, paused at increment 300."""
    page = look(query)
    paused_at(page, 300)
    return page
