"""The scripts in a blank tab of Chromium, fed with packed runs."""

import json
from pathlib import Path

import numpy as np
import pytest
from scripts import SHORT, run_of

from app.service import packing

APP = Path(__file__).parents[2] / "app"


MODULES = sorted(
    path.relative_to(APP).as_posix() for room in ("static", "features") for path in (APP / room).rglob("*.js")
)


LOOP = SHORT.changed(path="loop", u_x_max=6.0)


ROUNDED = 2 * packing.FINE + 0.002  # of the largest value: straight lines over frames and nodes, and the steps


def test_what_is_ordered_before_the_stage_is_there_follows_the_order_that_starts_the_run(tab):
    """The first test here, as the module of all others has a Stage."""
    given = tab.evaluate(
        """async () => {
            const { connect, order } = await import("http://scripts/static/js/channel.js")
            const given = [], stage = new Proxy({ on() {} }, { set: (_, what, { n }) => given.push([what, n]) })
            order("layer", { rows: 1 })
            connect(stage)
            connect(stage) // Panel renders it again
            order("skip")
            return given
        }"""
    )
    assert given == [["hello", 0], ["layer", 1], ["skip", 2]]


def test_the_server_is_silent_from_any_order_until_it_answers_that_one(tab, session):
    """Whether it is still there is asked after 4 s: see connection.js."""
    silent = tab.evaluate(
        """async (names) => {
            const { connect, heard, order, silence } = await import("http://scripts/static/js/channel.js")
            let last = 0
            connect(new Proxy({ on() {} }, { set: (_, what, { n }) => { last = n; return true } }))
            order("skip")
            heard(last) // and whatever this tab has ordered before
            const tick = () => { const begun = performance.now(); while (performance.now() === begun); }
            return Object.fromEntries(names.map((name) => {
                order(name)
                tick()
                const waits = silence() > 0
                heard(last - 1)
                const still = silence() > 0
                heard(last)
                return [name, [waits, still, silence() > 0]]
            }))
        }""",
        sorted(session.orders.keys() - {"hello"}),
    )
    assert len(silent) > 15 and {*map(tuple, silent.values())} == {(True, True, False)}


def test_messages_keep_their_order_while_packed_ones_are_unpacked(tab):
    passed_on = tab.evaluate(
        """async () => {
            const { connect, take } = await import("http://scripts/static/js/channel.js")
            const passedOn = [], unpacking = [Promise.withResolvers(), Promise.withResolvers()]
            const told = {}, stage = { on: (kind, call) => { told[kind] = call } }
            connect(stage)
            const send = ({ kind, ...message }) => { stage[kind] = message; told[kind]() }
            take("status", ({ text }) => passedOn.push(text))
            take("run", (message) => passedOn.push(message), ({ number }) => unpacking[number].promise)
            send({ kind: "status", text: "first" })
            send({ kind: "run", number: 0 })
            send({ kind: "status", text: "second" })
            send({ kind: "run", number: 1 })
            send({ kind: "status", text: "third" })
            unpacking[1].resolve("chunk 1")
            await new Promise((then) => setTimeout(then))
            const waited = passedOn.length === 1
            unpacking[0].resolve("chunk 0")
            await new Promise((then) => setTimeout(then))
            return [waited, passedOn]
        }"""
    )
    assert passed_on == [True, ["first", "chunk 0", "second", "chunk 1", "third"]]


@pytest.mark.parametrize("kind", ["run", "slip"])
@pytest.mark.parametrize("fails", ["new Promise(() => {})", "Promise.reject(new Error('no frames'))"])
def test_of_a_run_with_a_part_that_is_not_unpacked_no_later_part_is_passed_on_and_the_page_says_so(tab, kind, fails):
    """What else comes after it is passed on."""
    passed_on, said = tab.evaluate(
        f"""async ([kind, of]) => {{
            const {{ setTimeout: later }} = window, passedOn = []
            window.setTimeout = (call, ms) => later(call, ms > 5000 ? 1 : ms) // the time is over at once
            window.addEventListener("error", (event) => event.preventDefault(), {{ once: true }})
            document.body.innerHTML = "<p id=lost hidden><b></b><span></span><button id=retry></button></p>"
            const {{ connect, take }} = await import("http://scripts/static/js/channel.js")
            const told = {{}}, stage = {{ on: (kind, call) => {{ told[kind] = call }} }}
            connect(stage)
            const send = ({{ kind, ...message }}) => {{ stage[kind] = message; told[kind]() }}
            take("status", ({{ text }}) => passedOn.push(text))
            take(kind, ({{ part }}) => passedOn.push(part), async (message) => message.part ? message : {fails})
            const own = Math.random(), other = Math.random() // the tab has others of other tests
            for (const part of ["first", "", "third"]) send({{ kind, [of]: own, part }})
            send({{ kind: "status", text: "after" }})
            send({{ kind, [of]: other, part: "of another" }})
            send({{ kind, [of]: own, part: "fourth" }})
            send({{ kind: "status", text: "last" }})
            while (passedOn.at(-1) !== "last") await new Promise((then) => later(then))
            window.setTimeout = later
            const lost = document.getElementById("lost")
            return [passedOn, lost.hidden ? "" : lost.textContent]
        }}""",
        [kind, {"run": "run", "slip": "frame"}[kind]],
    )
    assert passed_on == ["first", "after", "of another", "last"]
    assert said.startswith("Incomplete:") and "Load the page again" in said


@pytest.mark.parametrize("name", MODULES)
def test_each_module_can_be_imported_without_a_page(tab, name):
    tab.evaluate(f"import('http://scripts/{name}').then((module) => Object.keys(module))")


def test_unpacked_frames_match_the_solver(tab):
    frames = run_of(tab, SHORT)
    assert tab.evaluate("[run.number, run.length, run.whole]") == [7, len(frames), True]
    for name in ("index", "U_x", "delta", "F_bar", "L_bar", "A_bar", "residual", "evaluations"):
        mine = np.array([getattr(frame, name) for frame in frames], dtype=np.float32)
        assert tab.evaluate(f"run.curves.{name}") == mine.tolist(), name
    k = len(frames) - 1
    shown = {name: tab.evaluate(f"[...run.frame({k}).{name}]") for name in ("x", "gap", "T_n", "T_t")}
    frame = frames[k]
    nodes = frame.first + np.arange(frame.u.shape[1])
    true = {
        "x": nodes * SHORT.spacing - SHORT.width / 2 + frame.u[0],
        "gap": SHORT.profile[nodes % SHORT.nodes] + frame.u[1],
        "T_n": frame.T[1],
        "T_t": -frame.T[0],  # shown positive where it resists
    }
    for name, values in true.items():
        assert np.abs(np.array(shown[name]) - values).max() < ROUNDED * np.abs(values).max(), name


def test_shear_values_exclude_the_approach(tab):
    frames = run_of(tab, SHORT)
    forces = [frame.F_bar for frame in frames if frame.stage == "shear"]
    assert tab.evaluate("[...run.shear('F_bar')]") == pytest.approx(forces, rel=1e-6)


def test_nearest_frame_of_a_loop_lies_on_the_leg_on_screen(tab):
    frames = run_of(tab, LOOP)
    for stage in ("shear", "back", "forth"):
        leg = [k for k, frame in enumerate(frames) if frame.stage == stage]
        now = leg[len(leg) // 2]
        k = tab.evaluate(f"run.nearest(2.04, {now})")
        assert frames[k].stage == stage and frames[k].U_x == pytest.approx(2.04, abs=LOOP.du_x)


def test_numbers_use_a_true_minus_sign_and_no_negative_zero(tab):
    written = tab.evaluate(
        """import("http://scripts/static/js/quantities.js").then(({ fixed, minus }) => [
            fixed(-1.25, 1), fixed(-0.0004, 3).replace("−", ""), fixed(3, 0), minus("-2")])"""
    )
    assert written == ["−1.2", "0.000", "3", "−2"]


@pytest.mark.parametrize(("low", "high"), [(-0.8, 0.4), (-0.8, 40.0), (-3.0, 3.0)])
def test_colours_change_from_attraction_to_repulsion_exactly_at_zero(tab, low, high):
    ends = {"pull-0": "#ff0000", "pull-1": "#c80000", "push-0": "#0000ff", "push-1": "#0000c8"}
    made = tab.evaluate(
        f"""import("http://scripts/static/js/colours.js").then(({{ readAgain, shades }}) => {{
            const styles = Object.entries({json.dumps(ends)}).map(([name, ink]) => `--${{name}}: ${{ink}}`)
            document.documentElement.style.cssText = styles.join(";")
            readAgain()
            return shades({low}, {high})
        }})"""
    )
    step = (made["high"] - made["low"]) / len(made["palette"])
    below = round(-made["low"] / step)
    assert -made["low"] / step == pytest.approx(below, abs=1e-6)
    assert low - step <= made["low"] <= low and high <= made["high"] <= high + step
    assert all(shade & 0xFFFF00 == 0 for shade in made["palette"][:below])  # red only
    assert all(shade & 0x00FFFF == 0 for shade in made["palette"][below:])  # blue only


def test_axis_limits_are_rounded_up_to_simple_numbers(tab):
    values = [0.012, 0.99, 1.0, 1.01, 37.0, 4200.0]
    rounded = tab.evaluate(f"import('http://scripts/static/js/colours.js').then(({{ nice }}) => {values}.map(nice))")
    assert rounded == [0.015, 1, 1, 1.5, 40, 5000]


def test_page_state_rejects_undeclared_fields(tab):
    refused = """import("http://scripts/static/js/store.js").then(({ me }) => {
        me.at = 3
        try { me.att = 3 } catch (error) { return [me.at, error.name] }
    })"""
    tab.evaluate("document.body.innerHTML = ''")
    assert tab.evaluate(f"(async () => {{ 'use strict'; return await {refused} }})()") == [3, "TypeError"]


def test_views_of_changed_fields_draw_together_once_also_if_one_fails(tab):
    drawn = tab.evaluate(
        """async () => {
            const { frame, me, set, view } = await import("http://scripts/static/js/store.js")
            const drawn = [], flushed = () => new Promise((then) => requestAnimationFrame(() => setTimeout(then)))
            frame(["at"], () => drawn.push(`frame of ${me.at}`))
            view(["at"], () => { throw new Error("one view fails") })
            view(["at", "preview"], () => drawn.push(`${me.at} ${me.preview}`))
            view(["drawn"], () => drawn.push("unchanged"))
            await flushed()
            drawn.length = 0
            me.at = 5
            set({ at: 6, preview: 7 })
            me.preview = 7
            await flushed()
            return drawn
        }"""
    )
    assert drawn == ["6 7", "frame of 6"]
