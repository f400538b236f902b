"""Undocumented behaviour of BokehJS that app/static/js/bokeh.js relies on, one test each."""

import pytest
from served import PATIENCE
from tabs import imported


@pytest.fixture
def still(look):
    """The page *Interface law*, with `bokeh` (the module) and `figures`, `parts` of figures.js as globals."""
    page = look("?page=law")
    page.wait_for_function("() => !('drawing' in law.dataset)", timeout=PATIENCE)
    imported(page, "bokeh", "figures", "channel").evaluate(
        """async () => {
            const { bokeh, figures: { figures, parts } } = modules
            Object.assign(window, { bokeh, figures, parts })
            window.screen2 = () => new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)))
            await screen2()
        }"""
    )
    return page


def test_view_of_every_figure_is_found_and_reports_when_it_is_drawn(still):
    assert still.evaluate("Object.values(figures).every((figure) => bokeh.viewOf(figure).model === figure)")
    still.wait_for_function("() => Object.values(figures).every(bokeh.isDrawn)")


def test_only_orders_are_sent_to_the_server_not_local_changes_of_figures(still):
    sent = still.evaluate(
        """async () => {
            const send = WebSocket.prototype.send, said = [], figure = figures.law_shear_law
            WebSocket.prototype.send = function (text) { said.push(text); return send.call(this, text) }
            bokeh.set(figure.y_range, { start: -3, end: 3 })
            bokeh.fill(parts.law_shear_law.stick, { s: [0], value: [0] })
            bokeh.tint(parts.law_shear_law.law, "#ff0000")
            await screen2()
            modules.channel.order("skip")
            await screen2()
            WebSocket.prototype.send = send
            return said.flatMap((text) => JSON.parse(text).events ?? []).map((event) => event.attr ?? event.kind)
        }"""
    )
    layout = {"inner_width", "inner_height", "outer_width", "outer_height"}  # which Bokeh tells by itself
    assert set(sent) - layout == {"skip"}


def test_parts_of_a_figure_are_found_by_name_and_can_be_coloured(still):
    assert {"law", "stick", "slip", "open"} <= set(still.evaluate("Object.keys(parts.law_shear_law)"))
    still.evaluate("bokeh.tint(parts.law_shear_law.law, '#123456')")
    line = "parts.law_shear_law.law.glyph.line_color"
    value = still.evaluate(line)
    assert "#123456" in (value, still.evaluate(f"{line}.value")), value


def test_an_image_can_be_read_back(still):
    assert still.evaluate(
        "(({ image, rows, columns }) => image.length === rows * columns)(bokeh.drawnBy(parts.law_shear_map.map))"
    )


def test_no_canvas_can_be_focused_by_the_tab_key(still):
    """Read before any view is requested, which would correct the tab index."""
    stops = """() => {
        const within = (root) => [...root.querySelectorAll("*")].flatMap((e) => (
            (e.classList.contains("bk-events") ? [e.tabIndex] : []).concat(e.shadowRoot ? within(e.shadowRoot) : [])))
        return within(document)
    }"""
    found = still.evaluate(stops)
    assert len(found) >= 4 and set(found) == {-1}


def test_a_figure_is_a_canvas_with_what_is_drawn_in_an_element_that_is_found(still):
    wide, colours = still.evaluate(
        """() => {
            const picture = bokeh.pictureOf(figures.law_shear_map), pen = picture.getContext("2d")
            const { data } = pen.getImageData(0, 0, picture.width, picture.height)
            return [picture.width, new Set(new Uint32Array(data.buffer)).size]
        }"""
    )
    assert wide > 100 and colours > 20
    assert still.evaluate("bokeh.holderOf(figures.law_shear_map).matches('#law .view')")


def test_line_width_is_multiplied_from_its_original_value(still):
    widths = still.evaluate(
        """() => [2, 3, 1].map((times) => {
            bokeh.thicken(parts.law_shear_law.law, times)
            return parts.law_shear_law.law.glyph.line_width
        })"""
    )
    once = [width["value"] if isinstance(width, dict) else width for width in widths]
    assert once[0] == pytest.approx(2 * once[2]) and once[1] == pytest.approx(3 * once[2])
