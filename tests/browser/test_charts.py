"""The charts of the experiment, which our own scripts draw: ticks, places, texts beside the mouse, sharpness."""

import pytest
from served import finished, laid_out
from tabs import imported

TEXTS = """() => {  // what is written into a chart from now on
    const { prototype } = CanvasRenderingContext2D, { fillText } = prototype
    window.texts = []
    prototype.fillText = function (text, ...at) {
        if (this.canvas.className === "chart") texts.push(text)
        return fillText.call(this, text, ...at)
    }
}"""


@pytest.mark.parametrize(
    ("start", "end", "most", "texts"),
    [
        (0, 40, 8, ["0", "5", "10", "15", "20", "25", "30", "35", "40"][:9]),
        (-1.2, 7, 5, ["0", "2", "4", "6"]),
        (-100, 210, 4, ["−100", "0", "100", "200"]),
        (0.011, 0.019, 4, ["0.012", "0.014", "0.016", "0.018"]),
        (-3e-7, 3e-7, 3, ["−0.0000002", "0.0000000", "0.0000002"]),
    ],
)
def test_numbers_of_an_axis_are_round_and_within_it(tab, start, end, most, texts):
    ticks = tab.evaluate(
        """async ([start, end, most]) => {
            const { ticksOf } = await import("http://scripts/static/js/chart.js")
            return ticksOf({ start, end }, most)
        }""",
        [start, end, most],
    )
    assert [text for _, text in ticks] == texts
    assert all(start <= value <= end for value, _ in ticks)


def test_a_curve_lies_where_the_axes_say(look):
    """The pixel at a point of the curve of A has its colour, on every screen as sharp as the screen is."""
    page = look("?theme=light&du_x=0.5&u_x_max=8")
    page.keyboard.press("Home")
    ratio, inside, outside = page.evaluate(
        """() => {
            const { area: chart } = charts, { box, canvas } = chart, pen = canvas.getContext("2d")
            chart.parts.cursor.at = -1e3
            chart.fill("slips", { x: [], y: [] })
            chart.fill("A", { x: [chart.x.start, chart.x.end], y: [chart.y.start, chart.y.end] })
            chart.paint()
            const ratio = canvas.width / canvas.clientWidth
            const at = (x, y) => [...pen.getImageData(Math.round(x * ratio), Math.round(y * ratio), 1, 1).data]
            const x = 0.37 * (chart.x.end - chart.x.start) + chart.x.start
            const y = 0.37 * (chart.y.end - chart.y.start) + chart.y.start
            const found = [ratio, at(box.X(x), box.Y(y)), at(box.X(x), box.Y(y) - 12)]
            punch.look++
            return found
        }"""
    )
    area = page.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--area').trim()")
    colour = [int(area[i : i + 2], 16) for i in (1, 3, 5)]
    assert ratio == pytest.approx(page.evaluate("devicePixelRatio"), abs=0.01)
    assert inside[3] > 100 and max(abs(a - b) for a, b in zip(inside, colour, strict=False)) < 60
    assert outside[3] < 100 or max(abs(a - b) for a, b in zip(outside, colour, strict=False)) > 60


@pytest.mark.parametrize(
    ("view", "said"),
    [("forces", ["Uₓ = ", "F = ", "L = "]), ("area", ["Uₓ = ", "A = "]), ("map", ["Uₓ = ", "x = ", "Tₙ = "])],
)
def test_a_chart_tells_beside_the_mouse_what_is_there_and_a_click_goes_there(look, view, said):
    page = look("?more=1")
    page.keyboard.press("End")
    laid_out(page)
    page.evaluate(TEXTS)
    box = page.locator(f".view[data-view={view}]").bounding_box()
    place = page.evaluate(
        f"(({{ left, top, width, height }}) => [left + width / 2, top + height / 2])(charts.{view}.box)"
    )
    page.mouse.move(box["x"] + place[0], box["y"] + place[1])
    page.wait_for_function("() => punch.preview !== null && texts.length && !punch.fresh")
    told = page.evaluate("texts")
    assert all(any(text.startswith(start) for text in told) for start in said), told
    page.mouse.click(box["x"] + place[0], box["y"] + place[1])
    page.mouse.move(1, 1)
    page.wait_for_function("() => punch.preview === null && punch.drawn === Math.floor(punch.at)")
    assert page.evaluate("punch.run.curves.U_x[punch.drawn]") == pytest.approx(20.0, abs=0.3)


@pytest.mark.thorough
def test_a_node_tells_its_state_place_gap_and_tractions(look):
    page = look()
    page.keyboard.press("End")
    laid_out(page)
    page.evaluate(TEXTS)
    box = page.locator("#punch-view").bounding_box()
    at = page.evaluate("(({ x, y }, { X, Y }) => [X(x[200]), Y(y[200])])(charts.punch.parts.surface, charts.punch.box)")
    page.mouse.move(box["x"] + at[0], box["y"] + at[1])
    page.wait_for_function("() => texts.some((text) => text.startsWith('gap = '))")
    page.mouse.move(1, 1)


@pytest.mark.thorough
def test_several_changes_are_painted_once_and_what_is_not_in_sight_never(look):
    page = look("?more=0")  # forces only
    counts = imported(page, "store").evaluate(
        """async () => {
            const counts = {}
            for (const name of ["forces", "area"]) {
                const pen = charts[name].canvas.getContext("2d"), { clearRect } = pen
                counts[name] = 0
                pen.clearRect = (...given) => { counts[name]++; clearRect.apply(pen, given) }
            }
            punch.at = punch.run.length - 9
            punch.look++
            punch.ghost = null
            await new Promise(requestAnimationFrame)
            await new Promise(requestAnimationFrame) // the one in which they were painted is over
            return counts
        }"""
    )
    assert counts == {"forces": 1, "area": 0}


@pytest.mark.thorough
@pytest.mark.parametrize("ratio", [1, 1.25, 2])
def test_a_chart_is_as_sharp_as_the_screen(browser, server, ratio):
    """A canvas has the pixels of the screen that it covers, no more and no less: the browser shows them as they are."""
    context = browser.new_context(device_scale_factor=ratio, viewport={"width": 1366, "height": 768})
    page = context.new_page()
    page.goto(f"{server.address}?more=1")
    finished(page)
    covered = """({ canvas }) => {
        const { left, right, top, bottom } = canvas.getBoundingClientRect()
        const pixels = (from, to) => Math.round(to * devicePixelRatio) - Math.round(from * devicePixelRatio)
        return canvas.width === pixels(left, right) && canvas.height === pixels(top, bottom)
    }"""
    assert page.evaluate(f"['punch', 'forces', 'area'].map((name) => ({covered})(charts[name]))") == 3 * [True]
    context.close()
