"""The pages in Chromium: drawing, opening, closing, playback, and files."""

import numpy as np
import pytest
from served import enter, faults_at, finished, found_by_axe, laid_out

from app.pages import listed
from solver import Scene, release_rates, simulate
from solver.mechanics import cohesive_law

thorough = pytest.mark.thorough
DRAWN = {  # page: condition that its result is drawn
    "law": "(charts.law_shear_map?.parts.stick.x.length > 50 && document.getElementById('law-stick').textContent)",
    "load": "(parseInt(document.getElementById('load-count').textContent) > 0)",
    "matters": "(document.querySelectorAll('#matters-bars button').length > 5)",
    "regimes": "document.getElementById('regimes-text').textContent.includes(' points')",  # its first tile
}
SMALL = {"nodes": 256, "width": 625.0, "du_x": 0.5, "du_z": 0.5}  # inexpensive, for maps and area laws
QUICK = "&".join(f"{name}={value:g}" for name, value in SMALL.items())
TINY = "nodes=64&width=160&radius=0.6&du_x=0.5&du_z=0.5"  # for pages of many runs
SIZES = (390, 844), (844, 390), (768, 1024), (1280, 720), (1920, 1080), (720, 450)


@pytest.fixture(scope="module", params=listed())
def opened(request, shared_tab):
    """(name, tab): each page once, drawn, for all tests that look at it."""
    name = request.param
    page = shared_tab.show(f"?more=0&page={name}&{TINY if name == 'regimes' else QUICK}")
    page.wait_for_function(f"() => {DRAWN[name]}")
    yield name, page
    shared_tab.check()


def painted_pixels(page):
    """Return the number of colours in the first chart of the open page: a blank one has a few."""
    return page.evaluate(
        """() => {
            const canvas = document.querySelector('.sheet:not([hidden]) .chart')
            const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height)
            return new Set(new Uint32Array(data.buffer)).size
        }"""
    )


def test_every_page_draws_its_result(opened):
    name, page = opened
    assert page.locator(".sheet:visible").count() == 1
    page.wait_for_function(
        "() => [...document.querySelectorAll('.sheet:not([hidden]) .view')].every((v) => v.clientHeight > 60)"
    )
    page.wait_for_function("!punch.fresh")
    assert name == "matters" or painted_pixels(page) > 8  # that page has bars in HTML, no chart


@thorough
def test_every_page_fits_every_screen_size_without_clipped_captions(opened):
    _, page = opened
    assert not faults_at(page, SIZES)
    for size in (SIZES[0], SIZES[3]):
        laid_out(page, size)
        cut = page.evaluate(
            """() => [...document.querySelectorAll('figcaption, header, nav')]
                .filter((e) => e.clientWidth && getComputedStyle(e).overflow !== 'visible')
                .filter((e) => e.scrollWidth > e.clientWidth || e.scrollHeight > e.clientHeight + 1)
                .map((e) => e.textContent)"""
        )
        assert not cut


@thorough
def test_axe_reports_no_violation_on_any_page_on_a_desktop_or_in_the_dark_on_a_phone(opened):
    _, page = opened
    laid_out(page, (1280, 720))
    assert not found_by_axe(page)
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator("#theme").evaluate("(button) => button.click()")
    laid_out(page)
    found = found_by_axe(page)
    page.locator("#theme").evaluate("(button) => button.click()")
    assert not found


@thorough
def test_only_one_page_is_open_and_a_closed_one_leaves_no_elements_or_listeners_behind(visit):
    page = visit()
    known = "['delta_bar', 'phi_ratio', 'E'].every((name) => punch.status.marks[name])"
    page.wait_for_function(known)  # each mark beside a slider listens, whenever it comes
    tools = page.context.new_cdp_session(page)
    tools.send("Performance.enable")
    found = []
    for _ in range(4):
        for name in ("load", "law"):
            page.evaluate(f"document.querySelector('nav [data-page={name}]').click()")
            page.wait_for_function(f"() => {DRAWN[name]} && !('drawing' in {name}.dataset)")
            assert page.locator(".sheet:visible").count() == 1
        page.evaluate("document.querySelector('#law .close').click()")
        page.wait_for_function("() => Bokeh.documents[0].roots()[0].data.opened.open === undefined")
        assert page.locator(".sheet:visible").count() == 0 and "page=" not in page.url
        tools.send("HeapProfiler.collectGarbage")
        metrics = {each["name"]: each["value"] for each in tools.send("Performance.getMetrics")["metrics"]}
        found.append((metrics["Nodes"], metrics["JSEventListeners"]))
    assert found[3][1] == found[1][1]  # after the first time: scripts have arrived
    assert found[3][0] - found[1][0] < 200  # of 1,600 that the page has


def test_edges_on_the_toughness_are_those_of_the_solver(visit):
    """Within the rounding of the fields that a browser receives."""
    page = visit("?page=law&k=180")
    frame = simulate(Scene(u_x_max=8.0)).frames[180]
    for label, edge in zip(("trailing", "leading"), release_rates(frame), strict=True):
        part = f"charts.law_toughness?.parts.{label}"
        page.wait_for_function(f"() => {part}?.x.length && punch.drawn === 180")
        shown = page.evaluate(f"() => [{part}.y[0], {part}.x[0]]")
        assert shown == pytest.approx([edge.J, np.degrees(edge.psi)], rel=5e-3)


def test_the_law_is_that_of_the_solver(look):
    """The browser draws it from the law that its states follow: maps, where sticking ends, and both curves."""
    scene = Scene(phi_ratio=0.3, law="xu-needleman")
    page = look("?page=law&phi_ratio=0.3&law=xu-needleman&u_x_max=4")
    page.wait_for_function(f"() => {DRAWN['law']}")
    for name, sign, part in (("shear", -1.0, 0), ("normal", 1.0, 1)):
        shown = page.evaluate(
            """(name) => {
                const { x, wide, y, high, columns, rows, values } = charts[`law_${name}_map`].parts.map
                return { x, wide, y, high, columns, rows, values: [...values] }
            }""",
            name,
        )
        values = np.reshape(shown["values"], (shown["rows"], shown["columns"]))
        s = shown["x"] + shown["wide"] * (np.arange(shown["columns"]) + 0.5) / shown["columns"]
        gap = shown["y"] + shown["high"] * (np.arange(shown["rows"]) + 0.5) / shown["rows"]
        expected = sign * cohesive_law.traction(scene, *np.meshgrid(s, gap))[part]
        np.testing.assert_allclose(values, expected, rtol=1e-4, atol=1e-5 * np.abs(expected).max())
        assert shown["x"] == -0.5 * scene.spacing and shown["y"] == -scene.delta_n
    s, rise = page.evaluate("(({ x, y }) => [[...x], [...y]])(charts.law_shear_law.parts.law)")
    expected = -cohesive_law.traction(scene, np.array(s), 0.0)[0] * scene.delta_t / scene.phi_t
    np.testing.assert_allclose(rise, expected, atol=1e-5)
    gap, pull = page.evaluate("(({ x, y }) => [[...x], [...y]])(charts.law_normal_law.parts.law)")
    over = cohesive_law.traction(scene, 0.0, np.array(gap))[1] / cohesive_law.traction(scene, 0.0, scene.delta_n)[1]
    np.testing.assert_allclose(pull, -over / np.e, atol=1e-9)


@thorough
def test_nodes_lie_on_the_curve_of_the_interface_law_and_stick_before_its_peak(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}")
    distance, stuck, slipping, peak = page.evaluate(
        """() => {
            const { law, stick, slip } = charts.law_shear_law.parts
            const at = (s) => {
                const part = (s - law.x[0]) / (law.x[1] - law.x[0]), i = Math.min(Math.floor(part), law.x.length - 2)
                return law.y[i] + (part - i) * (law.y[i + 1] - law.y[i])
            }
            const shown = [...stick.x.keys()].filter((i) => stick.y[i] === stick.y[i]), { abs, exp, max, min } = Math
            const gap = charts.law_normal_law.parts.stick.x // a rounded traction is divided by exp(-gap)
            const off = (i) => abs(stick.y[i] - at(stick.x[i])) * exp(-gap[i])
            return [shown.length > 0.8 * stick.x.length && max(...shown.map(off)),
                max(...stick.x.map(abs)), min(...slip.x.map(abs)), abs(law.x[law.y.indexOf(max(...law.y))])]
        }"""
    )
    assert 0.0 < distance < 0.03  # u_x comes to packing.CLOSE, twice, and tractions to packing.FINE
    assert stuck <= peak < slipping and 0.5 < peak < 0.71  # 1/sqrt(2) for one spring, less for a lattice


@thorough
def test_page_what_matters_marks_the_punch_while_it_is_open_and_a_bar_raises_its_parameter(look):
    page = look()
    colours = """(() => {
        const { canvas } = charts.punch, pen = canvas.getContext("2d")
        return [...pen.getImageData(0, 0, canvas.width, canvas.height).data].reduce((sum, value) => sum + value, 0)
    })()"""
    finished(page)
    page.wait_for_function("!punch.fresh && punch.drawn === punch.run.length - 1")
    alone = page.evaluate(colours)
    page.evaluate("document.querySelector('nav button[data-page=matters]').click()")
    page.locator("#matters-bars button").first.wait_for()
    names = page.locator("#matters-bars span").all_inner_texts()
    assert len(names) > 5 and not any("periodic cell" in name for name in names)
    page.wait_for_function(f"() => !punch.fresh && {colours} !== {alone}")
    page.evaluate("document.querySelector('nav button[data-page=\"\"]').click()")
    page.wait_for_function(f"() => !punch.fresh && {colours} === {alone}")
    page.evaluate("document.querySelector('nav button[data-page=matters]').click()")
    page.locator("#matters-bars button", has_text="tiffness").click()
    page.wait_for_function("punch.status.values.E === 73.5")
    finished(page, run=2)


@thorough
def test_close_button_and_back_close_a_page_and_change_no_parameter(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    opened = "document.querySelector('.page').dataset.page"
    for leave in (page.go_back, lambda: page.locator("#law .close").click()):
        page.evaluate("document.querySelector('nav button[data-page=law]').click()")
        page.wait_for_function(
            "!document.getElementById('law').dataset.drawing && !document.getElementById('law').hidden"
        )
        leave()
        page.wait_for_function(f"{opened} === '' && !new URLSearchParams(location.search).has('page')")
    page.evaluate("document.querySelector('nav button[data-page=law]').click()")
    enter(page, "E", "90")
    page.wait_for_function("punch.status.values.E === 90 && location.search.includes('E=90')")
    page.go_back()
    page.wait_for_function(f"{opened} === ''")
    assert page.evaluate("punch.status.values.E") == 90 and "E=90" in page.url and "page=" not in page.url
    page.go_back()
    page.wait_for_function("punch.status.values.E === 70")
    assert page.evaluate(opened) == ""


@thorough
def test_choosing_the_same_parameter_for_both_map_axes_swaps_them(look):
    page = look("?page=regimes")
    page.wait_for_function("document.getElementById('regimes-text').textContent")
    page.select_option("#regimes-x", "phi_ratio")
    assert page.input_value("#regimes-y") == "delta_bar"
    page.select_option("#regimes-y", "phi_ratio")
    assert page.input_value("#regimes-x") == "delta_bar"


@thorough
def test_a_preset_replaces_every_parameter_says_what_to_look_for_and_is_marked_when_changed(look):
    page = look("?delta_bar=0.3&nu=0.3")
    page.select_option("#preset", "fig4a-red")
    finished(page, run=2)
    values = page.evaluate("punch.status.values")
    assert (values["surface"], values["E"], values["nu"], values["delta_bar"]) == ("flat", 140, 0.45, 0)
    assert "stiff" in page.inner_text("#look") and "preset=fig4a-red" in page.url and "nu=" not in page.url
    assert page.locator("#preset optgroup").count() > 3
    enter(page, "E", "100")
    finished(page, run=3)
    assert "changed" in page.evaluate("document.getElementById('preset').selectedOptions[0].textContent")
    assert "Stiffness" in page.inner_text("#look")
    page.select_option("#preset", "fig4a-red")
    finished(page, run=4)
    assert page.evaluate("punch.status.values.E") == 140
    page.get_by_role("button", name="Reset", exact=True).click()
    finished(page, run=5)
    assert page.input_value("#preset") == "fig6" and "preset" not in page.url


@thorough
def test_a_page_closed_before_its_script_has_arrived_is_not_drawn(visit):
    page, held = visit(""), []
    page.route("**/pages/regimes/page.js*", lambda route: held.append(route))
    opened = "Bokeh.documents[0].roots()[0].data.opened.open"
    page.evaluate("document.querySelector('nav [data-page=regimes]').click()")
    page.wait_for_function(f"{opened} === 'regimes'")
    page.locator("#regimes .close").click()
    page.wait_for_function(f"{opened} === undefined")
    for route in held:
        route.continue_()
    page.evaluate("document.querySelector('nav [data-page=law]').click()")
    page.wait_for_function(f"() => {DRAWN['law']}")  # earlier messages are through, without errors
    assert held


@thorough
def test_clicking_several_pages_quickly_draws_only_the_last_one(look):
    page = look()
    ordered = page.evaluate(
        """() => {
            const stage = Bokeh.documents[0].roots().find(({ name }) => name === 'Stage').data
            window.ordered = []
            stage.properties.page.change.connect(() => ordered.push(stage.page.page))
            for (const name of ["load", "law", "matters", "load", "law"]) {
                document.querySelector(`nav button[data-page=${name}]`).click()
            }
            return getComputedStyle(document.querySelector("#law .figures"), "::after").content
        }"""
    )
    assert "drawing" in ordered
    page.wait_for_function(f"() => {DRAWN['law']}")
    page.wait_for_function("() => !document.querySelector('.sheet:not([hidden])[data-drawing]')")
    assert page.evaluate("ordered") == ["law"]
    assert painted_pixels(page) > 8


@thorough
def test_maps_of_the_law_have_a_scale_and_a_legend_for_their_nodes(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}")
    for name in ("shear", "normal"):
        high = float(page.inner_text(f"#law_{name}_map-high").strip("+ GPa"))
        assert high == pytest.approx(
            page.evaluate(f"charts.law_{name}_map.parts.map.limits[1]"), rel=0.05
        )  # two digits
    assert "past the peak" in page.inner_text("#law")
    style = "getComputedStyle(document.querySelector('.key .{}')).backgroundColor"
    assert page.evaluate(style.format("stick")) != page.evaluate(style.format("repulsive"))
    numbers = [int(page.inner_text(f"#law-{state}")) for state in ("stick", "slip", "open")]
    assert sum(numbers) == page.evaluate("punch.run.frame(punch.drawn).x.length")
    assert numbers[-1] == page.evaluate("charts.punch.parts.free.x.length")
    right = page.evaluate("[...charts.law_shear_map.parts.map.values].filter((_, i) => i % 160 === 159)")
    assert min(right) > 0.0  # up to half a spacing ahead of a site the law pulls back


@thorough
def test_a_drag_on_the_map_ends_where_the_button_is_let_go_also_outside_and_the_right_button_drags_nothing(look):
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    page.wait_for_function("charts.regimes_map.box && charts.regimes_map.parts.map.picture")
    box = page.locator("#regimes .view").bounding_box()
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.4 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    page.mouse.move(x + 40, y + 20)
    page.mouse.up(button="right")
    assert page.evaluate("[punch.dragging, punch.waiting.length]") == [False, 0]
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 40, y + 20)
    page.wait_for_function("punch.dragging")
    page.mouse.move(x + 40, box["y"] - 30)
    page.mouse.up()
    page.wait_for_function("!punch.dragging && !punch.waiting.length && punch.status.values.phi_ratio === 2")
    there = page.evaluate("JSON.stringify(punch.status.values)")
    page.mouse.move(x, y)
    page.mouse.move(x - 40, y)
    page.wait_for_function("!punch.fresh")
    assert page.evaluate("[punch.dragging, JSON.stringify(punch.status.values)]") == [False, there]


@thorough
def test_the_choices_of_the_map_are_those_of_what_is_shown_when_it_is_opened_again(look):
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    page.select_option("#regimes-of", "A_s")
    page.select_option("#regimes-x", "E")
    page.wait_for_function("charts.regimes_map.across.startsWith('stiffness')")
    page.locator("#regimes .close").click()
    page.wait_for_function("() => Bokeh.documents[0].roots()[0].data.opened.open === undefined")
    page.evaluate("document.querySelector('nav [data-page=regimes]').click()")
    page.wait_for_function("charts.regimes_map.across.startsWith('press')")
    assert [page.input_value(f"#regimes-{name}") for name in ("x", "y", "of")] == ["delta_bar", "phi_ratio", "F_s"]


@thorough
def test_clicking_the_map_shows_the_scene_of_that_place(look):
    """The axes of the map are delta_bar and phi_ratio; what is pointed at is read out, and a click goes there."""
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}")
    before = page.evaluate("(({ delta_bar, phi_ratio }) => [delta_bar, phi_ratio])(punch.status.values)")
    frame = page.evaluate("(({ left, top, width, height }) => ({ left, top, width, height }))(charts.regimes_map.box)")
    box = page.locator("#regimes .view").bounding_box()
    x, y = box["x"] + frame["left"] + 0.7 * frame["width"], box["y"] + frame["top"] + 0.3 * frame["height"]
    page.mouse.move(x, y)
    said = page.wait_for_function(
        "(({ pointed }) => pointed && charts.regimes_map.says(charts.regimes_map.placeOf(pointed)))(charts.regimes_map)"
    ).json_value()
    assert [line.split(":")[0] for line in said[:2]] == ["press depth δ/δ₀", "friction / adhesion φₜ/φₙ"]
    page.mouse.click(x, y)
    changed = f"punch.status.values.delta_bar > {before[0]} && punch.status.values.phi_ratio !== {before[1]}"
    page.wait_for_function(changed)
    finished(page, run=2)
    assert page.evaluate("punch.run.scene.delta_bar === punch.status.values.delta_bar && !punch.run.followed")
