"""Undocumented behaviour of BokehJS that app/static/js/bokeh.js relies on, one test each."""

import pytest
from tabs import imported

PIXELS = """() => [...function* find(node) {
    if (node.tagName === "CANVAS" && node.width > 50) yield node.toDataURL()
    for (const child of [...node.children ?? [], ...node.shadowRoot?.children ?? []]) yield* find(child)
}(document.querySelector("figure[aria-label^=Friction] .view"))].join()"""


@pytest.fixture
def still(look):
    """The app, paused, with `bokeh` (the module) and `figures`, `parts` of figures.js as globals."""
    page = look()
    page.evaluate("punch.look++")  # drawn anew, whatever another test has filled in
    page.wait_for_function("() => !punch.fresh && punch.mapped")
    imported(page, "bokeh", "figures", "channel", "store").evaluate(
        f"""async () => {{
            const {{ bokeh, figures: {{ figures, parts }} }} = modules
            Object.assign(window, {{ bokeh, figures, parts, pixels: {PIXELS} }})
            window.screen2 = () => new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(go)))
            await screen2()
        }}"""
    )
    return page


def test_view_of_every_figure_is_found_and_reports_when_it_is_drawn(still):
    assert still.evaluate("Object.values(figures).every((figure) => bokeh.viewOf(figure).model === figure)")
    still.wait_for_function("() => Object.values(figures).every(bokeh.isDrawn)")


def test_repainting_reads_no_css_variable_and_leaves_style_sheets_unchanged(still):
    asked, written = still.evaluate(
        """async () => {
            let asked = 0, written = 0
            const ask = CSSStyleDeclaration.prototype.getPropertyValue
            CSSStyleDeclaration.prototype.getPropertyValue = function (name) {
                asked += name.startsWith("--bk-")
                return ask.call(this, name)
            }
            const sheets = [...function* find(node) {
                if (node.tagName === "STYLE") yield node
                for (const child of [...node.children ?? [], ...node.shadowRoot?.children ?? []]) yield* find(child)
            }(document.body)]
            if (!sheets.length) throw new Error("no style sheets")
            const watch = new MutationObserver((changes) => { written += changes.length })
            for (const sheet of sheets) watch.observe(sheet, { childList: true, characterData: true })
            const before = pixels()
            bokeh.fill(parts.forces.F, { U_x: [0, 20, 40], value: [0, 1, 0] })
            await bokeh.bokehPainted()
            await screen2()
            CSSStyleDeclaration.prototype.getPropertyValue = ask
            return pixels() === before ? null : [asked, written]
        }"""
    )
    assert asked == 0 and written < 5  # and not one for each of some 30 things that are drawn


def test_an_axis_is_painted_again_only_with_another_range_size_or_colour(still):
    texts = still.evaluate(
        """async () => {
            const { prototype } = OffscreenCanvasRenderingContext2D, was = prototype.fillText, texts = []
            let count = 0
            prototype.fillText = function (...given) { count++; return was.apply(this, given) }
            const { start, end } = figures.forces.y_range, axis = figures.forces.left[0]
            const changes = [
                () => bokeh.fill(parts.forces.F, { U_x: [0, 20, 40], value: [0, 1, 0] }),
                () => bokeh.set(figures.forces.y_range, { start: start - 1 }),
                () => bokeh.set(axis, { major_label_text_color: "#ff0000" }),
                () => bokeh.set(axis, { axis_label_text_font_size: "17px" }),
                () => bokeh.fill(parts.forces.F, { U_x: [0, 20, 40], value: [1, 0, 1] }),
            ]
            for (const change of changes) {
                const before = pixels()
                count = 0
                change()
                await bokeh.bokehPainted()
                await screen2()
                texts.push([count > 0, pixels() !== before])
            }
            bokeh.set(figures.forces.y_range, { start })
            prototype.fillText = was
            modules.store.redraw()
            return texts
        }"""
    )
    assert texts == [[False, True], [True, True], [True, True], [True, True], [False, True]]


def test_marks_of_one_colour_are_painted_as_one_path_without_lines_between_them(still):
    painted, inside = still.evaluate(
        """async () => {
            const { prototype } = CanvasRenderingContext2D, fill = prototype.fill
            const canvas = bokeh.viewOf(figures.punch).canvas_view.primary.el
            const { X, Y } = bokeh.frameBox(figures.punch), scale = canvas.width / canvas.clientWidth
            const at = () => [...canvas.getContext("2d").getImageData(X(0) * scale, Y(3) * scale, 1, 1).data].join()
            const before = at(), marks = Array.from({ length: 90 }, (_, i) => (2 * Math.PI * i) / 90)
            let count = 0
            prototype.fill = function (...given) { count++; return fill.apply(this, given) }
            bokeh.fill(parts.punch.repulsive, { x: marks.map((t) => 90 * Math.cos(t)),
                gap: marks.map((t) => 3 + Math.sin(t)), at: marks, T_n: marks, T_t: marks })
            await bokeh.bokehPainted()
            await screen2()
            prototype.fill = fill
            const painted = canvas.getContext("2d").getImageData(X(90) * scale, Y(3) * scale, 1, 1).data.join()
            modules.store.redraw()
            return [count, at() === before && painted !== before]
        }"""
    )
    assert painted < 20 and inside


def test_new_data_are_sorted_by_place_when_the_mouse_comes_not_before(still):
    place, known = still.evaluate(
        """async () => {
            window.nodes = bokeh.viewOf(figures.punch).renderer_views.get(parts.punch.repulsive).glyph
            window.sorted = Reflect.get(nodes, "_index")
            const x = Array.from({ length: 41 }, (_, i) => 5 * (i - 20)), same = x.map(() => 3)
            bokeh.fill(parts.punch.repulsive, { x, gap: same, at: x, T_n: same, T_t: same })
            await bokeh.bokehPainted()
            await screen2()
            const { X, Y } = bokeh.frameBox(figures.punch)
            return [[X(0), Y(3)], Reflect.get(nodes, "_index") !== sorted]
        }"""
    )
    assert not known
    view = still.locator("#punch-view").bounding_box()
    still.mouse.move(view["x"] + place[0] + 1, view["y"] + place[1] + 1)
    still.wait_for_function("() => Reflect.get(nodes, '_index') !== sorted")
    still.locator(".bk-Tooltip", has_text="3.000 nm").first.wait_for()
    still.mouse.move(1, 1)
    still.evaluate("modules.store.redraw()")


def test_several_changes_are_painted_once_and_painting_can_be_awaited(still):
    painted = still.evaluate(
        """async () => {
            const before = pixels()
            let times = { forces: 0, area: 0 }
            for (const name in times) {
                const view = bokeh.viewOf(figures[name]), was = view.paint
                view.paint = (...given) => { times[name]++; return was.apply(view, given) }
            }
            bokeh.fill(parts.forces.F, { U_x: [0, 20, 40], value: [1, 0, 1] })
            bokeh.fill(parts.forces.L, { U_x: [0, 20, 40], value: [0, 1, 0] })
            await bokeh.bokehPainted()
            const awaited = pixels()
            await screen2()
            return [awaited !== before, awaited === pixels(), times.forces, times.area]
        }"""
    )
    assert painted == [True, True, 1, 0]


def test_only_orders_are_sent_to_the_server_not_local_changes_of_figures(still):
    sent = still.evaluate(
        """async () => {
            const send = WebSocket.prototype.send, said = []
            WebSocket.prototype.send = function (text) { said.push(text); return send.call(this, text) }
            bokeh.set(figures.forces.y_range, { start: -3, end: 3 })
            bokeh.fill(parts.forces.L, { U_x: [0], value: [0] })
            bokeh.tint(parts.forces.L, "#ff0000")
            await screen2()
            modules.channel.order("skip")
            await screen2()
            WebSocket.prototype.send = send
            return said.flatMap((text) => JSON.parse(text).events ?? []).map((event) => event.attr ?? event.kind)
        }"""
    )
    layout = {"inner_width", "inner_height", "outer_width", "outer_height"}  # which Bokeh tells by itself
    assert set(sent) - layout == {"order"}


def test_parts_of_a_figure_are_found_by_name_and_can_be_coloured(still):
    assert set(still.evaluate("Object.keys(parts.forces)")) == {
        *("zero", "ghost_F", "ghost_L", "F", "L", "slips_F", "cursor", "pins", "ways")
    }
    still.evaluate("bokeh.tint(parts.forces.F, '#123456')")
    line, bokeh_value = "parts.forces.F.glyph.line_color", still.evaluate("parts.forces.F.glyph.line_color")
    assert "#123456" in (bokeh_value, still.evaluate(f"{line}.value")), bokeh_value


def test_an_image_keeps_its_shape(still):
    shape = still.evaluate("bokeh.image(parts.map.map, new Float32Array(6), [2, 3])[0].shape")
    assert list(shape) == [2, 3]


def test_drawn_data_of_a_part_can_be_read_back(still):
    assert still.evaluate("bokeh.drawnBy(parts.forces.F).x.length === bokeh.drawnBy(parts.forces.F).y.length")
    assert still.evaluate(
        "(({ image, rows, columns }) => image.length === rows * columns)(bokeh.drawnBy(parts.map.map))"
    )
    assert still.evaluate("bokeh.drawnBy(parts.forces.cursor)") is None


def test_frame_of_a_figure_lies_within_its_element(still):
    box = still.evaluate("bokeh.frameBox(figures.punch)")
    view = still.locator("#punch-view").bounding_box()
    assert 0 < box["left"] < box["left"] + box["width"] <= view["width"]
    assert 0 <= box["top"] < box["top"] + box["height"] <= view["height"]


def test_listeners_receive_changes_and_taps_of_a_model(still):
    heard = still.evaluate(
        """() => {
            let changes = 0
            bokeh.onChange(figures.forces.y_range, "end", () => changes++)
            bokeh.set(figures.forces.y_range, { end: 7 })
            return changes
        }"""
    )
    assert heard == 1
    still.evaluate("window.taps = []; bokeh.onEvent(figures.area, 'tap', ({ x }) => taps.push(x))")
    box = still.locator("figure[aria-label^='Contact area'] .view").bounding_box()
    still.mouse.click(box["x"] + 0.6 * box["width"], box["y"] + 0.4 * box["height"])
    still.wait_for_function("() => taps.length === 1 && taps[0] > 0 && taps[0] < 40")


def test_canvases_over_the_punch_follow_whenever_bokeh_has_a_new_frame(still):
    """The element of the figure keeps its size, so that only Bokeh knows of the change."""
    still.evaluate("bokeh.set(figures.punch, { min_border_left: 250 })")
    still.wait_for_function(
        """() => {
            const { left, top } = bokeh.frameBox(figures.punch), story = document.getElementById("story")
            const alpha = (x) => story.getContext("2d").getImageData(x, top + 4, 1, 1).data[3]
            return left >= 250 && alpha(left + 3) > 0 && alpha(left - 6) === 0 // the bar of the top begins there
        }"""
    )
    still.evaluate("bokeh.set(figures.punch, { min_border_left: 0 })")


def test_no_canvas_can_be_focused_by_the_tab_key(still):
    """Read before any view is requested, which would correct the tab index."""
    stops = """() => {
        const within = (root) => [...root.querySelectorAll("*")].flatMap((e) => (
            (e.classList.contains("bk-events") ? [e.tabIndex] : []).concat(e.shadowRoot ? within(e.shadowRoot) : [])))
        return within(document)
    }"""
    found = still.evaluate(stops)
    assert len(found) >= 4 and set(found) == {-1}


def test_a_figure_is_a_canvas_with_what_is_drawn(still):
    wide, colours = still.evaluate(
        """() => {
            const picture = bokeh.pictureOf(figures.map), pen = picture.getContext("2d")
            const { data } = pen.getImageData(0, 0, picture.width, picture.height)
            return [picture.width, new Set(new Uint32Array(data.buffer)).size]
        }"""
    )
    assert wide > 200 and colours > 20


def test_element_that_contains_a_figure_is_found(still):
    view = "document.querySelector('figure[aria-label^=Friction] .view')"
    assert still.evaluate(f"bokeh.holderOf(figures.forces) === {view}")


def test_line_width_is_multiplied_from_its_original_value(still):
    widths = still.evaluate(
        """() => [2, 3, 1].map((times) => {
            bokeh.thicken(parts.forces.F, times)
            return bokeh.plain(parts.forces.F.glyph.line_width)
        })"""
    )
    once = [width["value"] if isinstance(width, dict) else width for width in widths]
    assert once[0] == pytest.approx(2 * once[2]) and once[1] == pytest.approx(3 * once[2])
