"""The pages in Chromium: drawing, opening, closing, playback, and files."""

import numpy as np
import pytest
from served import PATIENCE, faults_at, finished, found_by_axe, laid_out
from tabs import imported

from app.pages import listed
from solver import Scene, release_rates, simulate

thorough = pytest.mark.thorough
MODEL = "[...Bokeh.documents[0]._all_models.values()].find((model) => model.name === '{}')"
COUNT = f"{MODEL}?.data_source.data.{{}}.length"
DRAWN = {  # page: condition that its result is drawn
    "law": f"({COUNT.format('law_shear_map.stick', 's')} > 50 && document.getElementById('law-stick').textContent)",
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
    page.wait_for_function(f"() => {DRAWN[name]}", timeout=PATIENCE)
    yield name, page
    shared_tab.check()


def painted_pixels(page):
    """Return the number of colours in the first figure of the open page: a blank one has a few."""
    return page.evaluate(
        """() => {
            const views = document.querySelectorAll('.sheet:not([hidden]) .view > div')
            const find = (node) => node.shadowRoot ? [...node.shadowRoot.querySelectorAll('*')].flatMap(find)
                .concat([...node.shadowRoot.querySelectorAll('canvas')]) : [...node.children ?? []].flatMap(find)
            const canvas = [...find(views[0])].filter((c) => c.tagName === 'CANVAS' && c.width > 50)
            const seen = new Set()
            for (const c of canvas) {
                const data = c.getContext('2d').getImageData(0, 0, c.width, c.height).data
                for (let i = 0; i < data.length; i += 44) seen.add(data[i] + 256 * data[i + 1] + 65536 * data[i + 2])
            }
            return seen.size
        }"""
    )


def test_every_page_draws_its_result(opened):
    name, page = opened
    assert page.locator(".sheet:visible").count() == 1
    page.wait_for_function(
        "() => [...document.querySelectorAll('.sheet:not([hidden]) .view')].every((v) => v.clientHeight > 60)"
    )
    assert name == "matters" or painted_pixels(page) > 8  # that page has bars in HTML, no figure


@thorough
def test_every_page_fits_every_screen_size_without_clipped_captions(opened):
    _, page = opened
    assert not faults_at(page, SIZES)
    for size in (SIZES[0], SIZES[3]):
        page.set_viewport_size({"width": size[0], "height": size[1]})
        laid_out(page)
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
    page.set_viewport_size({"width": 1280, "height": 720})
    laid_out(page)
    assert not found_by_axe(page)
    page.set_viewport_size({"width": 390, "height": 844})
    page.locator("#theme").evaluate("(button) => button.click()")
    laid_out(page)
    found = found_by_axe(page)
    page.locator("#theme").evaluate("(button) => button.click()")
    assert not found


@thorough
def test_a_closed_page_removes_its_figures_and_only_one_page_is_open(look):
    page = look()
    finished(page)
    # what still belongs to the document: Bokeh itself looks but every half minute
    count = "new Set(Bokeh.documents[0].roots().flatMap((root) => [...root.references()])).size"
    before = page.evaluate(count)
    for name in ("law", "load"):
        page.locator(f"nav [data-page={name}]").evaluate("(button) => button.click()")
        page.wait_for_function(f"() => {DRAWN[name]}", timeout=PATIENCE)
        assert page.locator(".sheet:visible").count() == 1
    page.locator("nav [data-page='']").evaluate("(button) => button.click()")
    page.wait_for_function(f"() => {count} === {before}", timeout=PATIENCE)
    assert page.locator(".sheet:visible").count() == 0
    assert "page=" not in page.url


@thorough
def test_a_closed_page_leaves_no_elements_listeners_or_models_behind(visit):
    page = visit()
    finished(page)
    tools = page.context.new_cdp_session(page)
    tools.send("Performance.enable")
    found = []
    for _ in range(3):
        page.evaluate("document.querySelector('nav [data-page=law]').click()")
        page.wait_for_function(f"() => {DRAWN['law']} && !('drawing' in law.dataset)", timeout=PATIENCE)
        page.evaluate("document.querySelector('#law .close').click()")
        page.wait_for_function(f"() => !({MODEL.format('law_shear_map.map')})", timeout=PATIENCE)
        tools.send("HeapProfiler.collectGarbage")
        metrics = {each["name"]: each["value"] for each in tools.send("Performance.getMetrics")["metrics"]}
        found.append((metrics["Nodes"], metrics["JSEventListeners"]))
    assert found[2][1] == found[0][1]
    assert found[2][0] - found[0][0] < 200  # of 1,600 that the page has


@thorough
def test_page_named_in_the_address_is_open_from_the_start(visit):
    page = visit("?page=law&delta_bar=0.1")
    finished(page)
    page.wait_for_function(f"() => {DRAWN['law']}", timeout=PATIENCE)
    page.wait_for_function("() => document.getElementById('law-stick').textContent")
    numbers = [int(page.inner_text(f"#law-{state}")) for state in ("stick", "slip", "open")]
    assert sum(numbers) == page.evaluate("punch.run.frame(punch.drawn).x.length")


def test_edges_on_the_toughness_are_those_of_the_solver(visit):
    """Within the rounding of the fields that a browser receives."""
    page = visit("?page=law&k=180")
    finished(page)
    frame = simulate(Scene(u_x_max=8.0)).frames[180]
    for label, edge in zip(("trailing", "leading"), release_rates(frame), strict=True):
        source = f"{MODEL.format(f'law_toughness.{label}')}?.data_source.data"
        page.wait_for_function(f"() => {source}?.value?.length && punch.drawn === 180", timeout=PATIENCE)
        shown = page.evaluate(f"() => [{source}.value[0], {source}.angle[0]]")
        assert shown == pytest.approx([edge.J, np.degrees(edge.psi)], rel=5e-3)


@thorough
def test_nodes_lie_on_the_curve_of_the_interface_law(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}", timeout=PATIENCE)
    distance = page.evaluate(
        f"""() => {{
            const law = {MODEL.format("law_shear_law.law")}.data_source.data
            const nodes = {MODEL.format("law_shear_law.stick")}.data_source.data
            const at = (s) => {{
                const part = (s - law.s[0]) / (law.s[1] - law.s[0]), i = Math.min(Math.floor(part), law.s.length - 2)
                return law.value[i] + (part - i) * (law.value[i + 1] - law.value[i])
            }}
            const shown = [...nodes.s.keys()].filter((i) => nodes.value[i] === nodes.value[i])
            return shown.length > 0.8 * nodes.s.length
                && Math.max(...shown.map((i) => Math.abs(nodes.value[i] - at(nodes.s[i]))))
        }}"""
    )
    assert 0.0 < distance < 0.03  # u_x comes to packing.CLOSE, twice, and tractions to packing.FINE


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
    finished(page)
    opened = "document.querySelector('.page').dataset.page"
    for leave in (page.go_back, lambda: page.locator("#law .close").click()):
        page.evaluate("document.querySelector('nav button[data-page=law]').click()")
        page.wait_for_function(
            "!document.getElementById('law').dataset.drawing && !document.getElementById('law').hidden"
        )
        leave()
        page.wait_for_function(f"{opened} === '' && !new URLSearchParams(location.search).has('page')")
    page.evaluate("document.querySelector('nav button[data-page=law]').click()")
    page.fill("#E-entry", "90")
    page.keyboard.press("Enter")
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
    page.wait_for_function("document.querySelector('#regimes-at').textContent.startsWith('Point')")
    page.select_option("#regimes-y", "phi_ratio")
    assert page.input_value("#regimes-x") == "delta_bar"


@thorough
def test_a_preset_replaces_every_parameter_and_says_what_to_look_for(look):
    page = look("?delta_bar=0.3&nu=0.3")
    finished(page)
    page.select_option("#preset", "fig4a-red")
    finished(page, run=2)
    values = page.evaluate("punch.status.values")
    assert (values["surface"], values["E"], values["nu"], values["delta_bar"]) == ("flat", 140, 0.45, 0)
    assert "stiff" in page.inner_text("#look") and "preset=fig4a-red" in page.url and "nu=" not in page.url
    page.get_by_role("button", name="Reset", exact=True).click()
    finished(page, run=3)
    assert page.input_value("#preset") == "fig6" and "preset" not in page.url


@thorough
def test_a_page_closed_before_its_script_has_arrived_is_not_drawn(visit):
    page, held = visit(""), []
    finished(page)
    page.route("**/pages/regimes/page.js*", lambda route: held.append(route))
    shown = (
        "[...Bokeh.documents[0]._all_models.values()].some(({ type, children }) => type === 'Column' && children[0])"
    )
    page.evaluate("document.querySelector('nav [data-page=regimes]').click()")
    page.wait_for_function(shown, timeout=PATIENCE)
    page.locator("#regimes .close").click()
    page.wait_for_function(f"!{shown}", timeout=PATIENCE)
    for route in held:
        route.continue_()
    page.evaluate("document.querySelector('nav [data-page=law]').click()")
    page.wait_for_function(f"() => {DRAWN['law']}", timeout=PATIENCE)  # earlier messages are through, without errors
    assert held


@thorough
def test_clicking_several_pages_quickly_draws_only_the_last_one(look):
    page = look()
    finished(page)
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
    page.wait_for_function(f"() => {DRAWN['law']}", timeout=PATIENCE)
    page.wait_for_function("() => !document.querySelector('.sheet:not([hidden])[data-drawing]')", timeout=PATIENCE)
    assert page.evaluate("ordered") == ["law"]
    assert painted_pixels(page) > 8


@thorough
def test_maps_of_the_law_have_a_scale_and_a_legend_for_their_nodes(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['law']}", timeout=PATIENCE)
    for name in ("shear", "normal"):
        mapper = f"{MODEL.format(f'law_{name}_map.map')}.glyph.color_mapper"
        high = float(page.inner_text(f"#law_{name}_map-high").strip("+ GPa"))
        assert high == pytest.approx(page.evaluate(f"{mapper}.high"), rel=0.05)  # two digits
    assert "past the peak" in page.inner_text("#law")
    style = "getComputedStyle(document.querySelector('.key .{}')).backgroundColor"
    assert page.evaluate(style.format("stick")) != page.evaluate(style.format("repulsive"))
    assert int(page.inner_text("#law-open")) == page.evaluate("charts.punch.parts.free.x.length")
    image = f"{MODEL.format('law_shear_map.map')}.data_source.data.image[0]"
    right = page.evaluate(f"[...{image}].filter((_, i) => i % 160 === 159)")
    assert min(right) > 0.0  # up to half a spacing ahead of a site the law pulls back


@thorough
def test_clicking_the_map_shows_the_scene_of_that_place(look):
    """The axes of the map are delta_bar and phi_ratio; what is pointed at is read out, and a click goes there."""
    page = look(f"?page=regimes&{TINY}")
    page.wait_for_function(f"() => {DRAWN['regimes']}", timeout=PATIENCE)
    before = page.evaluate("(({ delta_bar, phi_ratio }) => [delta_bar, phi_ratio])(punch.status.values)")
    frame = imported(page, "figures").evaluate(
        "(({ left, top, width, height }) => ({ left, top, width, height }))("
        "Bokeh.index.find_one(modules.figures.figures.regimes_map).frame.bbox)"
    )
    box = page.locator("#regimes .view").bounding_box()
    x, y = box["x"] + frame["left"] + 0.7 * frame["width"], box["y"] + frame["top"] + 0.3 * frame["height"]
    page.mouse.move(x, y)
    page.wait_for_function("!document.getElementById('regimes-at').textContent.startsWith('Point')")
    page.mouse.click(x, y)
    changed = f"punch.status.values.delta_bar > {before[0]} && punch.status.values.phi_ratio !== {before[1]}"
    page.wait_for_function(changed, timeout=PATIENCE)
    finished(page, run=2)
    assert page.evaluate("punch.run.scene.delta_bar === punch.status.values.delta_bar && !punch.run.followed")
