"""Pinned runs: kept in the browser, overlaid, in numbers, in a link; in a real Chromium."""

import pytest
from served import FAULTS, MODEL, PATIENCE, PLAYING, finished, laid_out, values_are

from solver import Scene, load_path, summarize
from solver.analysis.friction_laws import friction_force
from solver.analysis.peeling import peel_asymmetry
from solver.presets import preset

pytestmark = [pytest.mark.browser, pytest.mark.thorough]


def lines(page, view):
    """How many lines of pinned runs a figure has."""
    return page.evaluate(f"{MODEL.format(f'{view}.pins')}.data_source.data.xs.length")


@pytest.mark.thorough
def test_a_run_is_pinned_shown_hidden_renamed_loaded_and_removed_by_keyboard(visit):
    page = visit()
    finished(page)
    page.locator("body").press("End")
    page.get_by_role("button", name="Pin", exact=True).press("Enter")
    chip = page.locator(".chip")
    chip.wait_for()
    page.focus("#E")
    page.keyboard.press("ArrowRight")
    finished(page, run=2)
    assert [lines(page, view) for view in ("forces", "area", "map", "punch")] == [2, 1, 2, 1]
    assert page.locator(".page").get_attribute("data-ghost") == "false"  # nothing pale over it
    # the force of the pinned run in N/m, whatever the stiffness of the run on screen
    pinned = page.evaluate(f"{MODEL.format('forces.pins')}.data_source.data.ys[0][50]")
    stiff = page.evaluate("punch.status.values.E")
    first = next(frame for frame in load_path(Scene()) if frame.stage == "shear" and frame.index == 50)
    assert pinned == pytest.approx(first.F_bar * 70 * 2500, rel=1e-4)  # N/m
    style = page.evaluate(
        f"(({{ colour, dash }}) => [colour[0], dash[0]])({MODEL.format('forces.pins')}.data_source.data)"
    )
    assert style == page.evaluate(
        "['--pin-1', '--pin-1-dash'].map((name) => getComputedStyle(document.documentElement).getPropertyValue(name))"
    )
    show = chip.get_by_role("button", name="Show")
    show.press("Enter")
    page.wait_for_function(f"() => {MODEL.format('forces.pins')}.data_source.data.xs.length === 0")
    assert show.get_attribute("aria-pressed") == "false"
    show.press("Space")
    chip.get_by_role("button", name="Rename").press("Enter")
    page.keyboard.type("Paper's punch")
    page.keyboard.press("Enter")
    chip.get_by_role("button", name="Load Paper's punch").press("Enter")
    values_are(page, E=70)
    chip.get_by_role("button", name="Remove Paper's punch").press("Enter")
    page.wait_for_function(f"() => {MODEL.format('forces.pins')}.data_source.data.xs.length === 0")
    assert page.locator("#pins").is_hidden() and page.evaluate("document.activeElement.id") == "pin"
    page.get_by_role("button", name="Undo").press("Enter")  # loading was a change like any other
    page.wait_for_function(f"punch.status.values.E === {stiff}", timeout=PATIENCE)


def test_the_numbers_are_those_of_the_solver_and_lead_to_their_increments(visit):
    page = visit("?preset=fig7-case2")
    finished(page)
    page.get_by_role("button", name="Pin", exact=True).click()
    page.locator(".chip").wait_for()
    page.select_option("#preset", "fig6")
    values_are(page, delta_bar=0)
    page.get_by_role("button", name="Numbers").press("Enter")
    rows = page.locator("#numbers-table tbody tr")
    for row, scene in zip((0, 1), (Scene(), preset("fig7-case2").scene), strict=True):

        def cell(measure, row=row):
            return rows.nth(row).locator(f"[data-measure={measure}]")

        def number(measure, cell=cell):
            return float(cell(measure).inner_text().replace("−", "-"))

        frames = list(load_path(scene))
        known, force = summarize(scene, frames), scene.E * scene.width
        assert cell("regime").inner_text() == "stick-slip"
        assert number("slips") == known["slips"]
        assert number("U_s") == pytest.approx(known["U_s"], rel=1e-3)
        assert number("F_s") == pytest.approx(known["F_s"] * force, rel=1e-3)
        assert number("A_s") == pytest.approx(known["A_s"] * scene.width, rel=1e-3)
        assert number("tau_c") == pytest.approx(known["F_s"] * scene.E / known["A_s"], rel=1e-2)
        assert number("mean") == pytest.approx(friction_force(scene, frames).mean * force, rel=1e-3)
        shear = [frame for frame in frames if frame.stage == "shear"]
        before = shear[next(k for k, frame in enumerate(shear) if frame.slip) - 1]
        asymmetry = float(cell("peeling").inner_text().split(", ")[1])
        assert asymmetry == pytest.approx(peel_asymmetry(scene, shear[0], before), abs=0.02)
        assert cell("dissipated").inner_text() == "–"
    place = frames.index(before)  # of the pinned run
    cell("F_s").press("Enter")
    values_are(page, delta_bar=0.4)
    page.wait_for_function(f"punch.drawn === {place} && !punch.playing")
    assert not page.locator("#numbers").is_visible()


@pytest.mark.thorough
def test_pins_travel_in_the_address(visit):
    page = visit("?E=100&pin=Soft*E*20&pin=*preset*fig7-case2")
    finished(page)
    page.wait_for_function(f"() => {MODEL.format('area.pins')}.data_source.data.xs.length === 2", timeout=PATIENCE)
    assert page.locator(".chip").all_inner_texts()[0].startswith("Soft") or "Soft" in page.inner_text("#chips")
    assert page.evaluate("punch.status.values.E") == 100 and page.evaluate("punch.run.number") == 1
    page.get_by_role("button", name="Remove Soft").click()
    assert "Soft" not in page.url and "fig7-case2" in page.url


TWIN = """() => {
    const { figures, parts } = window.views, pinned = window.pins[0].run, { twin, punch: main } = figures
    if (!twin || punch.drawn < punch.run.sheared) return null
    const U_x = punch.run.curves.U_x[punch.drawn], { U_x: passed } = pinned.curves
    const k = passed.findIndex((U, i) => i >= pinned.sheared && Math.abs(U - U_x) < 0.01)
    const { x, gap, state } = pinned.frame(k), states = Array.from(x, (_, i) => state(i))
    const drawn = (state) => parts.twin[state].data_source.data.x.length
    const asMany = (state) => drawn(state) === states.filter((one) => one === state).length
    const range = (figure) => [figure.x_range, figure.y_range].flatMap(({ start, end }) => [start, end]).join()
    return ["repulsive", "adhering", "free"].every(asMany) && range(twin) === range(main)
        && parts.twin.surface.data_source.data.gap.every((value, i) => value === gap[i])
}"""


def test_two_runs_are_side_by_side_at_the_same_place_and_to_the_same_scale(visit):
    page = visit("?theme=dark", **PLAYING)
    finished(page)
    page.get_by_role("button", name="Pin", exact=True).press("Enter")
    page.locator(".chip").wait_for()
    page.select_option("#preset", "fig7-case2")
    values_are(page, delta_bar=0.4)
    # paused during the approach, it would never come to an increment that both have
    page.wait_for_function(
        "() => !punch.fresh && punch.run.sheared > 0 && punch.drawn > punch.run.sheared", timeout=PATIENCE
    )
    page.get_by_role("button", name="Pause").press("Enter")
    page.evaluate(
        """async () => {
            const from = (name) => import(new URL(`./app/static/js/${name}.js`, document.baseURI))
            Object.assign(window, { views: await from("figures"), pins: (await from("later/pins")).pins })
        }"""
    )
    beside = page.get_by_role("button", name="Side by side with Stick, peel, slip")
    beside.press("Enter")
    page.wait_for_function(f"() => ({TWIN})()", timeout=PATIENCE)
    assert beside.get_attribute("aria-pressed") == "true" and beside.evaluate("(e) => e === document.activeElement")
    assert "Stick, peel, slip" in page.inner_text("#twin-of") and "Pressed: peels" in page.inner_text("#punch-of")
    for key in ("]", "]", "ArrowRight", "Home", "End"):  # one time bar for both
        page.locator("body").press(key)
        page.wait_for_function(f"() => ({TWIN})() ?? punch.drawn === 0", timeout=PATIENCE)
    for width, height in ((1440, 900), (1280, 720), (1024, 768), (820, 1180), (844, 390), (390, 844)):
        page.set_viewport_size({"width": width, "height": height})
        laid_out(page)
        assert not page.evaluate(FAULTS), (width, height)
        left, right = page.evaluate(  # at one moment: a sentence above both may still get or lose a line
            """() => ['punch-view', 'twin-view'].map(
                (id) => document.getElementById(id).getBoundingClientRect().toJSON())"""
        )
        if height > 561 and width >= 600:
            assert left["x"] + left["width"] <= right["x"]
            assert (left["y"], left["height"]) == pytest.approx((right["y"], right["height"]), abs=1.0)
        else:
            assert left["y"] + left["height"] <= right["y"]
    page.locator("body").press("p")
    page.set_viewport_size({"width": 1280, "height": 720})
    laid_out(page)
    assert not page.evaluate(FAULTS) and page.locator("#twin").is_visible()
    page.locator("body").press("p")
    page.select_option("#preset", "unload")  # it is walked along delta: nothing to be compared
    values_are(page, path="unload")
    page.locator("#twin-said").filter(has_text="another path").wait_for()
    page.get_by_role("button", name="Remove Stick, peel, slip").press("Enter")
    page.locator("#twin").wait_for(state="hidden")
