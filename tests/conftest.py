"""Fixtures that tests share: a real Chromium, the app served to it, and a pool of workers."""

import asyncio
import os
import shutil
from collections import Counter
from functools import cached_property
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in workers: threads that wait for each other eat both cores

import numpy as np
import pytest
from served import TROUBLE, Server, finished
from tabs import SharedTab, Tabs
from xdist.scheduler import LoadFileScheduling

from solver import Scene, load_path

# Each window loads the pop-ups of its address bar: three quarters of the cost of opening an empty page. The others are
# those that Playwright switches off, whose list this one replaces.
UNUSED = (
    *("WebUIOmniboxPopup", "WebUIOmniboxAimPopup", "WebUIOmniboxFullPopup", "PreloadTopChromeWebUI", "AimEnabled"),
    *("HttpsUpgrades", "MediaRouter", "NetworkTimeServiceQuerying", "OptimizationHints", "PaintHolding"),
    "PreconnectToSearch",
)
CHROMIUM = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")


def named(config):
    """Whether the command names files or tests, rather than folders or nothing."""
    return any(not os.path.isdir(argument) for argument in config.args)


def pytest_xdist_auto_num_workers(config):
    """Two processes for the suite; for named files this one alone, which a debugger needs."""
    return 0 if named(config) else int(os.environ.get("PYTEST_XDIST_AUTO_NUM_WORKERS", 2))


def in_browser(file):
    """Whether a file has tests that need a browser: those of tests/browser, and of a feature those of its page."""
    return file.startswith("tests/browser/") or "/test_page" in file


class OneBrowser(LoadFileScheduling):
    """One process has all tests of a browser, with one server; both share these where they are most of the tests."""

    def _split_scope(self, nodeid):
        file = super()._split_scope(nodeid)
        return "browser" if in_browser(file) and not self._mostly else file

    @cached_property
    def _mostly(self):
        return 2 * sum(in_browser(test.split("::")[0]) for test in self.collection) > len(self.collection)


def pytest_xdist_make_scheduler(config, log):
    return OneBrowser(config, log)


def pytest_configure(config):
    """Leave thorough tests out, unless `-m` names them or the command names files: these run all they have."""
    chosen = config.option.markexpr
    if "thorough" not in chosen and (chosen or not named(config)):
        config.option.markexpr = f"({chosen}) and not thorough" if chosen else "not thorough"


@pytest.hookimpl(tryfirst=True)  # before `-m` chooses
def pytest_collection_modifyitems(items):
    """Tests in a browser are marked so; of a test marked `once` all parameters but the first are thorough."""
    seen = Counter()
    for item in items:
        if in_browser(item.nodeid.split("::")[0]):
            item.add_marker(pytest.mark.browser)
        if once := item.get_closest_marker("once"):
            test = item.parent.nodeid, item.originalname
            seen[test] += 1
            if seen[test] > (once.args or (1,))[0]:
                item.add_marker(pytest.mark.thorough)


@pytest.fixture
def call(capsys):
    """call(*arguments) -> (exit code, standard output, standard error), within this process."""

    from solver import cli

    def run(*arguments):
        try:
            code = cli.main([str(argument) for argument in arguments])
        except SystemExit as end:
            code = end.code
        return code, *capsys.readouterr()

    return run


@pytest.fixture(scope="session")
def chromium():
    """Path of the Chromium on this machine; skips without one, but fails where CI promised it."""
    path = next(filter(None, map(shutil.which, CHROMIUM)), None)
    if path is None:
        message = f"no Chromium on PATH (looked for {', '.join(CHROMIUM)})"
        (pytest.fail if os.environ.get("CI") else pytest.skip)(message)
    return path


@pytest.fixture(scope="session")
def browser(chromium):
    """A headless Chromium driven by Playwright, one for all tests; open a context of your own in it."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        # Containers run as root and with a small /dev/shm; the pages opened here are our own.
        arguments = ["--no-sandbox", "--disable-dev-shm-usage", "--disable-gpu", "--disable-background-networking"]
        arguments += [f"--disable-features={','.join(UNUSED)}"]
        opened = playwright.chromium.launch(executable_path=chromium, args=arguments)
        yield opened
        opened.close()


@pytest.fixture(scope="session")
def server(chromium):
    running = Server()
    try:
        running.wait_for("workers are warm")
        yield running
    finally:
        running.stop()
    trouble = [line for line in running.lines if TROUBLE.search(line)]
    assert not trouble, "".join(running.lines)


@pytest.fixture
def visit(server, browser):
    """visit(address) -> the app in a tab of the test's own, at rest after its run unless `rests` is false."""
    tabs = Tabs(server, browser)

    def opened(query="", rests=True, **options):
        page = tabs.open(query, **options)
        if rests:
            finished(page)
        return page

    yield opened
    tabs.close()
    tabs.check()


APP = Path(__file__).parent.parent / "app"
RUN_OF = """() => {
    window.runOf = async (blocks) => { // the Run of packed blocks in base64
        const { Run } = await import("http://scripts/static/js/run.js")
        const { unpackLater } = await import("http://scripts/static/js/packed.js")
        let run = null
        for (const text of blocks) {
            const { buffer } = Uint8Array.from(atob(text), (c) => c.charCodeAt(0))
            const chunk = await unpackLater({ body: buffer })
            run ??= new Run(7, chunk.head)
            run.add(chunk)
        }
        return run
    }
}"""


@pytest.fixture(scope="module")
def tab(browser):
    """A blank page at an address of its own from which modules can be imported, with `runOf`; no server."""
    page = browser.new_page()
    kinds = {".js": "text/javascript", ".html": "text/html"}

    def answer(route):
        path = route.request.url.removeprefix("http://scripts/")
        body = "<!doctype html>" if path == "blank.html" else (APP / path).read_text(encoding="utf-8")
        route.fulfill(body=body, content_type=kinds[Path(path).suffix])

    page.route("http://scripts/**", answer)
    page.goto("http://scripts/blank.html")
    page.evaluate(RUN_OF)
    yield page
    page.close()


@pytest.fixture(scope="session")
def shared_tab(server, browser):
    tab = SharedTab(server, browser)
    yield tab
    tab.close()


@pytest.fixture
def look(shared_tab, request):
    """look(address) -> the app in the tab that all tests of the process share, as if it had been opened there.

    A test may change whatever the controls of the page can change back. One that needs a page of its own, as it is
    about loading, history or what only an address can ask for, takes `visit`.
    """
    failed = request.session.testsfailed
    yield shared_tab.show
    if request.session.testsfailed > failed:
        shared_tab.close()  # whatever state it is in
    shared_tab.check()


@pytest.fixture(scope="session")
def pool():
    from app.service.pool import Pool  # here: tests of the solver need nothing of the app

    workers = Pool(size=2)
    workers.start()
    yield workers
    workers.close()


@pytest.fixture(scope="session")
def shared_pool():
    """The pool that Panel apps use without a server."""
    from app.service.pool import pool

    yield pool
    pool.close()


@pytest.fixture
def script(shared_pool):
    """Panel apps compute at once, as in a script. A browser of this process, which other tests share, leaves a loop
    running, for which Panel would leave them waiting.
    """
    running = asyncio._get_running_loop()
    asyncio._set_running_loop(None)
    yield
    asyncio._set_running_loop(running)


@pytest.fixture
def page(pool):
    """A visitor whose runs the pool computes."""
    from visitor import Page

    visit = Page(pool)
    yield visit
    visit.session.close()


@pytest.fixture
def session():
    """A visitor whose pool does nothing."""
    from bokeh.document import Document
    from visitor import NoPool, ended

    from app.experiment import Experiment
    from app.service.jobs import Jobs
    from app.stage import Wire

    visit = Experiment(doc=Document(), jobs=Jobs(NoPool()), stage=Wire())
    visit.doc.add_next_tick_callback = lambda call: ended(call())  # no server: at once
    yield visit
    visit.close()


@pytest.fixture(scope="module")
def frame():
    """A contact under shear, on a patch, and its scene."""
    scene = Scene(nodes=256, width=625.0, delta_bar=0.2, radius=2.5, du_z=0.5, du_x=0.5, u_x_max=5.0)
    return scene, list(load_path(scene))[-1]


@pytest.fixture(scope="module")
def pressed():
    """(scene, first, traction, a, middle): a contact of half-width a = w/256 under Hertz pressure, p0 = 1."""
    scene = Scene(nodes=16384, width=16384 * 2.4, height=1.0, nu=0.45)
    a, middle = 64 * scene.spacing, 8192 * scene.spacing
    first = 8192 - 64
    T = np.zeros((2, 129))
    T[1] = np.sqrt(np.maximum(1.0 - ((scene.x[first : first + 129] - middle) / a) ** 2, 0.0))
    return scene, first, T, a, middle
