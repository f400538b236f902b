"""Dragging a slider in Chromium: predictions during the drag, fixed axes, then the exact run."""

import pytest
from served import enter, finished, grab, paused, values_are
from tabs import imported

pytestmark = pytest.mark.thorough


AXES = """Object.fromEntries(["forces", "area", "map", "punch"].map((name) => {
    const { x, y } = charts[name]
    return [name, [x.start, x.end, y.start, y.end]]
}))"""


COLOURS = "[document.getElementById('map-low').textContent, document.getElementById('map-high').textContent]"


WORD = "document.querySelector('#status b').textContent"


DRAWN = """() => {  // the curves of the charts, and of the run on screen
    const { forces: { parts: { F } }, area: { parts: { A } } } = charts
    return [[[...F.y], [...A.y]], [[...punch.run.shear("F")], [...punch.run.shear("A")]]]
}"""


DRAWN_F = "() => [[...charts.forces.parts.F.x], [...charts.forces.parts.F.y]]"


WATCH = """() => {  // what is on screen with every run that is painted whole
    window.seen = []
    let last = punch.run
    const look = () => {
        const { run } = punch
        if (run !== last && run.whole && !punch.fresh && punch.charted === run) {
            last = run
            const { stale } = document.querySelector(".page").dataset
            const of = { followed: Boolean(run.followed), stale: stale === "true" }
            seen.push({ ...of, held: punch.dragging, word: %s, axes: %s, colours: %s,
                at: run.curves.U_x[Math.floor(punch.at)] })
        }
        requestAnimationFrame(look)
    }
    look()
}""" % (WORD, AXES, COLOURS)  # noqa: UP031


ADHERING = """() => {  // pixels of the punch in the colour of nodes that adhere
    const { canvas } = charts.punch, { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height)
    let found = 0
    for (let i = 0; i < data.length; i += 4)
        if (data[i] === 0xd5 && data[i + 1] === 0x5e && data[i + 2] === 0 && data[i + 3] === 255) found++
    return found
}"""


def test_dragging_a_slider_shows_predictions_then_the_exact_run_on_axes_that_stay(look):
    page = paused(look, "?E=71.3&delta_bar=0.1")
    before = page.evaluate("[...punch.run.shear('F_bar')]")
    axes, colours, at = page.evaluate(f"[{AXES}, {COLOURS}, punch.run.curves.U_x[300]]")
    page.evaluate(WATCH)
    page.evaluate("punch.rests = 1e6")  # on however slow a machine, this hand rests when it lets go
    point = grab(page, "delta_bar")
    for steps in (1, 2, 3):
        page.mouse.move(*point(steps))
        page.wait_for_function(f"punch.run.followed && punch.run.scene.delta_bar === {0.1 + 0.01 * steps:.2f}")
    page.wait_for_function("!punch.fresh && punch.mapped")
    drawn, followed = page.evaluate(DRAWN)
    assert drawn == followed
    imported(page, "features/share/share")
    heading, row = page.evaluate("modules.share.csv(punch.run)").splitlines()[1:3]
    saved = dict(zip(heading.split(","), row.split(","), strict=True))
    assert saved["residual (nm)"] == saved["evaluations"] == "" and saved["F (N/m)"]  # of a prediction none is known
    assert page.inner_text("figure[aria-label^='Friction'] .ghost") == "before: δ/δ₀ = 0.1"
    page.mouse.up()
    page.wait_for_function("!punch.run.followed")
    finished(page)
    page.wait_for_function(f"{WORD} !== 'followed' && punch.mapped")
    seen = page.evaluate("seen")
    held = [each for each in seen if each["held"]]
    assert held and all(each["followed"] and each["word"] == "followed" for each in held)
    assert page.evaluate(f"[{AXES}, {COLOURS}]") == [held[-1]["axes"], colours]  # also after letting go
    for name in ("forces", "area"):  # these axes grow at their upper end, which the curves leave
        narrow, wider = axes.pop(name), [each["axes"].pop(name) for each in held]
        assert all(a[:3] == narrow[:3] and a[3] >= narrow[3] for a in wider)
    assert [(each["axes"], each["colours"]) for each in held] == [(axes, colours)] * len(held)
    assert not any(each["stale"] for each in seen)
    assert all(each["at"] == pytest.approx(at, abs=0.01) for each in seen)  # what was looked at
    assert page.evaluate("punch.run.scene.delta_bar") == 0.13 and page.evaluate("punch.run.head.step") < 0.2
    assert page.evaluate("[...punch.ghost.shear('F_bar')]") == before  # the run before the drag, and exact
    drawn, exact = page.evaluate(DRAWN)
    assert drawn == exact
    assert page.evaluate("punch.status.notes").count("off") == 0 and "delta_bar=0.13" in page.url


def test_a_predicted_run_shows_any_increment_where_one_scrubs_or_points_and_plays_at_once(look):
    page = paused(look, "?E=70.4")
    page.evaluate("punch.rests = 1e6")
    point = grab(page, "delta_bar")
    page.mouse.move(*point(2))
    page.wait_for_function("punch.run.followed && !punch.fresh && punch.picture.run === punch.run")
    own = page.evaluate("punch.drawn")
    gaps = []
    for change, k in ((f"{{ at: {own + 20} }}", own + 20), (f"{{ at: {own}, preview: {own + 30} }}", own + 30)):
        page.evaluate(f"Object.assign(punch, {change})")
        page.wait_for_function("!punch.fresh")
        assert page.evaluate("[punch.picture.k, punch.drawn, Number(scrub.value)]") == [k] * 3
        gaps.append(page.evaluate("[...charts.punch.parts.surface.y]"))
        assert gaps[-1] == page.evaluate(f"[...punch.run.frame({k}).gap]")
    assert gaps[0] != gaps[1]
    page.evaluate("punch.preview = null")
    page.evaluate("document.getElementById('play').click()")
    page.mouse.up()
    page.wait_for_function(f"punch.run.followed && !punch.run.few && punch.drawn > 0 && punch.playing && {own} > 0")
    at = page.evaluate("punch.at")
    page.wait_for_function(f"punch.at > {at}")


def test_a_status_from_before_the_last_picture_does_not_put_the_slider_back(look):
    """A key let go before the server said so lost its step."""
    page = paused(look, "?E=71.2")
    page.evaluate("punch.rests = 1e6")
    page.focus("#delta_bar")
    page.keyboard.down("ArrowRight")
    page.wait_for_function("punch.run.followed && !punch.waiting.length && !punch.fresh")
    page.evaluate("Object.assign(punch, { dragging: false, status: { ...punch.status } })")
    page.wait_for_function("!punch.fresh")
    assert page.input_value("#delta_bar-entry") == "0.01"
    page.keyboard.up("ArrowRight")
    page.keyboard.press("ArrowRight")
    values_are(page, delta_bar=0.02)


def test_letting_go_of_a_slider_is_answered_before_anything_is_painted_again(look):
    """What is on screen stays until all increments of the prediction are there, so that the browser is free at once."""
    page = paused(look, "?E=71.7")
    point = grab(page, "E")
    for steps in range(1, 6):
        page.mouse.move(*point(steps))
    page.wait_for_function("punch.run.few && !punch.waiting.length && !punch.fresh")
    page.evaluate(
        """() => {
            const { canvas } = charts.forces, pen = canvas.getContext("2d"), { clearRect } = pen
            window.painted = []
            pen.clearRect = (...box) => { if (!punch.dragging) painted.push(punch.run.few); clearRect.apply(pen, box) }
        }"""
    )
    page.mouse.up()
    page.wait_for_function("painted.length && !punch.run.few && !punch.fresh")
    assert page.evaluate("painted").count(True) == 0


def test_choosing_a_flat_while_paused_removes_the_nodes_of_the_punch(look):
    page = paused(look, "?E=71.4&theme=light")
    assert page.evaluate(ADHERING) > 20
    page.locator("#row input[value='fig4a-blue']").evaluate("(radio) => radio.click()")
    page.wait_for_function("punch.run.head.flat && punch.run.whole && !punch.fresh")
    assert page.evaluate(ADHERING) == 0


def test_force_arrows_keep_their_scale_while_the_stiffness_is_dragged(look):
    page = paused(look, "?E=71.5&delta_bar=0.1")
    before = page.evaluate("punch.run.strongest")
    page.evaluate("punch.rests = 1e6")
    point = grab(page, "E")
    page.mouse.move(*point(40))
    page.wait_for_function("punch.run.followed && punch.run.scene.E > 100")
    F, L, strongest = page.evaluate("[...['F', 'L'].map((name) => punch.run.curves[name]), punch.run.strongest]")
    assert strongest == pytest.approx(max(before, *map(abs, F + L)))
    page.mouse.up()


def test_sentence_updates_its_numbers_when_only_they_change(look):
    """Both slide without slips, so that the sentence is the same but for its numbers."""
    page = paused(look, "?phi_ratio=0.004")
    page.keyboard.press("End")
    page.wait_for_function("document.getElementById('sentence').textContent.includes('slides without slips')")
    before = page.locator("#sentence").inner_text()
    enter(page, "phi_ratio", "0.008")
    page.wait_for_function("punch.run.scene.phi_ratio == 0.008 && punch.run.whole")
    page.wait_for_function("(before) => document.getElementById('sentence').textContent !== before", arg=before)
    high = page.evaluate("Math.max(...punch.run.curves.F)")
    assert f"{high:.3g} N/m" in page.locator("#sentence").inner_text()


def test_pausing_within_a_drag_computes_the_exact_run_and_keeps_the_run_before_the_drag(look):
    page = paused(look, "?E=71.6&delta_bar=0.1")
    point = grab(page, "delta_bar")
    page.mouse.move(*point(1))
    page.wait_for_function("punch.run.scene?.delta_bar === 0.11 && !punch.run.followed && punch.run.whole")
    page.mouse.move(*point(2))
    page.wait_for_function("punch.run.followed && punch.run.scene.delta_bar === 0.12")
    assert page.evaluate("punch.ghost.scene.delta_bar") == 0.1
    page.mouse.up()
    page.wait_for_function("!punch.run.followed && punch.run.scene.delta_bar === 0.12")
    finished(page)
    assert page.evaluate("punch.ghost.scene.delta_bar") == 0.1
