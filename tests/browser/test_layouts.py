"""A Stage where others put it: in layouts and templates of Panel, beside widgets, in saved files, in a notebook."""

import json
import os
import re
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from textwrap import indent
from time import monotonic, sleep

import pytest
from served import PATIENCE, ROOT, Server, patient

APPS = ROOT / "docs" / "apps"
HEAD = """
import panel as pn
from app.experiment import Experiment
from app.stage import Stage
from solver import Scene, simulate
pn.extension()
small = {"nodes": 256, "width": 625.0, "u_x_max": 12.0}
one, two = (simulate(Scene(**small, E=E)) for E in (60.0, 120.0))
"""
LAYOUTS = {
    "column": """
pn.config.raw_css.append("body { background: color(srgb 0.98 0.98 0.98) }")  # as marimo names colours
pn.Column("# above", Stage(one), "# below", Stage(two, height=500)).servable()""",
    "tabs and card": """
tabs = pn.Tabs(("text", "nothing"), ("run", Stage(one, height=500)), active=1)
pn.Column(tabs, pn.Card(Stage(two, height=480), title="card")).servable()""",
    "material, dark": """
page = pn.template.MaterialTemplate(title="Material", theme="dark")
page.sidebar.append(pn.widgets.FloatSlider(name="mine"))
page.main.extend([Stage(one), Stage(two)])
page.servable()""",
    "fast, dark": """
page = pn.template.FastListTemplate(title="Fast", theme="dark", sidebar=["text"], main=[Stage(one), Stage(two)])
page.servable()""",
}
IGNORED = re.compile(
    r"^\[bokeh|ERR_NAME_NOT_RESOLVED|ERR_INTERNET"
)  # fonts that templates of Panel load from elsewhere
PLAYED = "(root) => root.punch?.run?.whole && root.punch.drawn > 0 && !root.punch.fresh"
PICTURE = "(root) => root.charts.punch.canvas.toDataURL()"
LARGE = "(root) => root.clientWidth > 500 && root.clientHeight > 400"


@pytest.fixture
def visit(browser):
    """visit(address): a tab whose faults are on record; none may be there at the end."""
    pages = []

    def open_page(address):
        page = patient(browser.new_page(viewport={"width": 1280, "height": 1200}))
        page.faults = []
        page.on("pageerror", lambda error: page.faults.append(str(error)))
        kept = lambda message: message.type in ("error", "warning") and not IGNORED.search(message.text)  # noqa: E731
        page.on("console", lambda message: page.faults.append(message.text) if kept(message) else None)
        page.goto(address)
        pages.append(page)
        return page

    yield open_page
    faults = [page.faults for page in pages]
    for page in pages:
        page.close()
    assert not any(faults), faults


@pytest.fixture
def served(tmp_path):
    """served(path of a script): the address at which it is served."""
    servers = []

    def serve(script):
        servers.append(Server(what=str(script)))
        servers[-1].wait_for("running at")
        return servers[-1].address

    yield serve
    for server in servers:
        server.stop()


def played(page, count):
    """Roots of so many Stages that are drawn and play."""
    roots = page.locator(".root")
    roots.nth(count - 1).wait_for()
    assert roots.count() == count
    for k in range(count):
        root = roots.nth(k).element_handle()
        page.wait_for_function(PLAYED, arg=root)
        before = root.evaluate(PICTURE)
        root.evaluate("(root) => { root.punch.playing = true }")
        page.wait_for_function(f"([root, before]) => ({PICTURE})(root) !== before", arg=[root, before])
    return roots


@pytest.mark.parametrize("name", LAYOUTS)
def test_a_stage_is_drawn_and_played_in_a_layout(name, visit, served, tmp_path):
    script = tmp_path / "layout.py"
    script.write_text(HEAD + LAYOUTS[name])
    page = visit(served(script))
    roots = played(page, 2)
    themes = roots.evaluate_all("(all) => all.map((root) => root.dataset.theme)")
    assert themes == 2 * ["dark" if "dark" in name else "light"]
    scenes = roots.evaluate_all("(all) => all.map((root) => root.punch.run.scene.E)")
    assert sorted(scenes) == [60.0, 120.0]  # each has a store of its own
    for k in range(2):  # a template gives its width late
        page.wait_for_function(LARGE, arg=roots.nth(k).element_handle())
    for part in ("header", ".controls", "#slow"):  # of a Result that is played
        assert not roots.first.locator(part).first.is_visible()


def test_keys_are_those_of_the_stage_that_was_pressed_last(visit, served, tmp_path):
    script = tmp_path / "layout.py"
    script.write_text(HEAD + LAYOUTS["column"])
    page = visit(served(script))
    roots = played(page, 2)
    roots.nth(1).locator("#punch-view").click()
    page.keyboard.press("Home")
    page.wait_for_function("(root) => root.punch.drawn === 0", arg=roots.nth(1).element_handle())
    assert roots.nth(0).evaluate("(root) => root.punch.playing && root.punch.drawn !== 0")


def test_a_live_experiment_obeys_its_sliders_and_those_of_others(visit, served):
    page = visit(served(APPS / "own_slider.py"))
    root = played(page, 1).first.element_handle()
    page.wait_for_function("(root) => root.punch.status.state === 'finished'", arg=root)
    page.locator(".root #E").press("ArrowRight")
    page.wait_for_function("(root) => root.punch.run.checked && root.punch.status.state === 'finished'", arg=root)
    E = root.evaluate("(root) => root.punch.run.scene.E")
    assert E > 70.0
    page.get_by_text(f"E = {E:g} GPa").wait_for()  # bound by the author
    page.locator(".noUi-handle").press("ArrowRight")  # the author's own slider
    scene = "(root) => root.punch.run?.whole && root.punch.run.scene.phi_ratio === 2 && !root.punch.stale"
    page.wait_for_function(scene, arg=root)
    assert root.evaluate("(root) => root.punch.run.scene.E") == E
    assert page.locator(".root #phi_ratio-entry").input_value() == "2"
    assert "own_slider" in page.url and "?" not in page.url  # the address is the author's


def test_a_dashboard_is_saved_as_a_file_that_plays(visit, tmp_path):
    command = [sys.executable, APPS / "dashboard.py"]
    subprocess.run(command, cwd=tmp_path, env=None, check=True, timeout=PATIENCE / 1000, capture_output=True)
    page = visit((tmp_path / "dashboard.html").as_uri())
    played(page, 2)
    assert "E = 140 GPa" in page.locator("table").inner_text()


def test_a_live_experiment_in_a_file_says_that_nothing_computes_there(browser, tmp_path):
    made, script = tmp_path / "live.html", tmp_path / "live.py"
    lines = "from bokeh.resources import INLINE", f"pn.Row(Experiment()).save({str(made)!r}, resources=INLINE)"
    script.write_text(HEAD.split("small")[0] + "\n".join(lines))
    subprocess.run([sys.executable, script], cwd=tmp_path, check=True, timeout=PATIENCE / 1000, capture_output=True)
    page = browser.new_page()
    page.clock.install()
    page.goto(made.as_uri())
    page.locator(".root .page").wait_for()
    assert not page.locator("#lost").is_visible()
    page.clock.fast_forward(10_000)
    page.locator("#lost", has_text="A saved page computes nothing").wait_for()
    assert not page.locator("#retry").is_visible()
    page.close()


NOTEBOOKS = {  # as text: with cells that show a live Experiment, and a slider and a text of the author's
    "marimo": """
import marimo
app = marimo.App()

@app.cell
def _():
    {}
    experiment
    return (Stage, experiment, pn, simulate)

@app.cell
def _(Stage, experiment, pn, simulate):
    {}
    column
    return
""",
    "jupyterlab": """{{"cells": [
{{"cell_type": "code", "id": "a", "metadata": {{}}, "source": {}, "outputs": [], "execution_count": null}},
{{"cell_type": "code", "id": "b", "metadata": {{}}, "source": {}, "outputs": [], "execution_count": null}}
], "metadata": {{"kernelspec": {{"display_name": "Python 3", "language": "python", "name": "python3"}}}},
"nbformat": 4, "nbformat_minor": 5}}""",
}
LIVE = """import panel as pn
from app.experiment import Experiment
from app.stage import Stage
from solver import Scene, simulate
pn.extension(inline=True)
experiment = Experiment(Scene(nodes=256, width=625.0, u_x_max=12.0))"""
OTHERS = """said = pn.pane.Markdown(pn.bind(lambda scene: f"depth {scene.delta_bar}", experiment.param.scene))
ratio = pn.widgets.DiscreteSlider(options=[0.5, 1.0, 2.0], value=1.0)
changes = lambda event: experiment.param.update(scene=experiment.scene.changed(phi_ratio=event.new))
ratio.param.watch(changes, "value")
column = pn.Column(ratio, said, Stage(simulate(experiment.scene)))"""


@pytest.fixture
def notebook(tmp_path):
    """notebook(name of its tool): the address of a server of the live notebook."""
    running = []

    def serve(tool):
        pytest.importorskip(tool)
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        if tool == "marimo":
            (tmp_path / "live.py").write_text(
                NOTEBOOKS[tool].format(*(indent(c, "    ").strip() for c in (LIVE, OTHERS)))
            )
            options = ["-m", "marimo", "-q", "run", "live.py", "--port", str(port), "--headless", "--no-token"]
            address = f"http://localhost:{port}"
        else:
            cells = LIVE + "\nexperiment", OTHERS + "\ncolumn"
            (tmp_path / "live.ipynb").write_text(NOTEBOOKS[tool].format(*map(json.dumps, cells)))
            options = [
                "-m",
                "jupyterlab",
                "--allow-root",
                "--no-browser",
                f"--port={port}",
                "--IdentityProvider.token=",
            ]
            address = f"http://localhost:{port}/doc/tree/live.ipynb"
        environment = os.environ | {"PYTHONPATH": str(ROOT)}
        running.append(subprocess.Popen([sys.executable, *options], cwd=tmp_path, env=environment))
        until = monotonic() + PATIENCE / 1000
        while monotonic() < until:
            with suppress(OSError), socket.create_connection(("localhost", port), 1):
                break
            sleep(0.2)
        return address

    yield serve
    for process in running:
        process.terminate()
        process.wait(PATIENCE / 1000)


@pytest.mark.thorough
@pytest.mark.parametrize("tool", NOTEBOOKS)
def test_a_live_experiment_runs_in_a_notebook(tool, notebook, browser):
    page = patient(browser.new_page(viewport={"width": 1400, "height": 1400}))
    page.goto(notebook(tool))
    if tool == "jupyterlab":
        page.locator("#jp-main-statusbar", has_text="| Idle").wait_for()  # its kernel is there
        page.get_by_role("menuitem", name="Run").click()
        page.get_by_text("Run All Cells", exact=True).click()
    root = page.locator(".root:not([data-alone])[data-placed]").element_handle()
    page.wait_for_function("(root) => root.punch?.run?.whole && root.punch.status.state === 'finished'", arg=root)
    assert root.evaluate("(root) => root.dataset.theme") == "light"
    page.locator(".root:not([data-alone]) #delta_bar-entry").fill("0.2")
    page.keyboard.press("Enter")
    page.wait_for_function("(root) => root.punch.run.scene.delta_bar === 0.2 && !root.punch.stale", arg=root)
    page.get_by_text("depth 0.2").wait_for()
    page.locator(".noUi-handle").press("ArrowRight")
    scene = "(root) => root.punch.run?.whole && root.punch.run.scene.phi_ratio === 2 && !root.punch.stale"
    page.wait_for_function(scene, arg=root)
    page.wait_for_function(PLAYED, arg=page.locator(".root[data-alone]").element_handle())
    page.close()


@pytest.mark.thorough
def test_a_notebook_plays_its_stages_when_it_is_shown_as_a_page(visit, tmp_path):
    pytest.importorskip("nbconvert")
    made = tmp_path / "notebook.html"
    options = ["--to", "html", "--execute", "--output", str(made)]
    subprocess.run([sys.executable, "-m", "nbconvert", *options, APPS / "notebook.ipynb"], check=True, timeout=600)
    page = visit(made.as_uri())
    played(page, 2)
    frame = page.frame_locator("iframe").first
    frame.locator("#status b", has_text="saved").wait_for()


def test_an_example_for_layouts_is_short():
    for path in APPS.glob("*.py"):
        assert len(path.read_text(encoding="utf-8").splitlines()) <= 32, path.name
    assert {path.suffix for path in Path(APPS).iterdir()} == {".py", ".ipynb"}
