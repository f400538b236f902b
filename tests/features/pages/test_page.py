"""The pages in Chromium: drawing, opening, closing, playback, and files."""

import pytest
from served import enter, faults_at, finished, found_by_axe, laid_out, patient

from app.features.pages.feature import listed

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


@thorough
def test_close_button_and_back_close_a_page_and_change_no_parameter(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    opened = "(document.querySelector('.sheet:not([hidden])')?.id ?? '')"
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
def test_a_page_closed_before_its_script_has_arrived_is_not_drawn(server, browser):
    page, held = patient(browser.new_page()), []
    page.route("**/static/later.js*", lambda route: held.append(route))
    page.goto(server.address)
    finished(page)
    opened = "Bokeh.documents[0].roots()[0].data.opened.open"
    page.evaluate("document.querySelector('nav [data-page=regimes]').click()")
    page.wait_for_function(f"{opened} === 'regimes'")
    page.locator("#regimes .close").click()
    page.wait_for_function(f"{opened} === undefined")
    for route in held:
        route.continue_()
    page.evaluate("document.querySelector('nav [data-page=law]').click()")
    page.wait_for_function(f"() => {DRAWN['law']}")  # earlier messages are through, without errors
    page.close()
    assert held


@thorough
def test_clicking_several_pages_quickly_draws_only_the_last_one(look):
    page = look()
    ordered = page.evaluate(
        """() => {
            const stage = Bokeh.documents[0].roots().find(({ name }) => name === 'Wire').data
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
