"""The pages in Chromium: drawing, opening, closing, playback, and files."""

import pytest
from served import PATIENCE, PLAYING, finished

from app.pages import listed

pytestmark = [pytest.mark.thorough]
MODEL = "[...Bokeh.documents[0]._all_models.values()].find((model) => model.name === '{}')"
COUNT = f"{MODEL}?.data_source.data.{{}}.length"
DRAWN = {  # title of a page: condition that its result is drawn
    "Interface law": f"({COUNT.format('law_shear_map.stick', 's')} > 50)",
    "Stick-slip": f"({COUNT.format('stickslip_mean.runs', 'ratio')} === 9"
    f" && {COUNT.format('stickslip_forces.fig4a-blue', 'F')} > 400)",
    "Area laws": "(document.querySelectorAll('#arealaws-rows tr').length > 0"
    " && document.querySelectorAll('#arealaws-series tr').length > 2)",
    "Inside the solid": f"({MODEL.format('solid_field.field')}?.data_source.data.image[0].length === 400 * 100)",
    "Friction over load": "(parseInt(document.getElementById('load-count').textContent) > 0)",
    "What matters": "(document.querySelectorAll('#matters-bars button').length > 5)",
    "Map of regimes": "document.getElementById('regimes-text').textContent.includes(' points')",
    "Fit": f"({COUNT.format('fit_curve.run', 'U_x')} > 50)",
    "Accuracy": "document.getElementById('accuracy-state').textContent.includes('takes')",
}


def test_every_page_is_covered_by_the_drawing_test():
    assert {*DRAWN} == {page.TITLE for page in listed().values()}


def painted_pixels(page, name):
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


@pytest.mark.parametrize("number", range(len(DRAWN)), ids=list(DRAWN))
def test_a_page_is_drawn_on_desktop_or_phone(look, number):
    """By turns light on a desktop and dark on a phone."""
    title = list(DRAWN)[number]
    size, theme = (((1280, 720), "light"), ((390, 844), "dark"))[number % 2]
    quick = "&nodes=256&width=625&du_x=0.5&du_z=0.5" if title == "Area laws" else ""  # inexpensive
    page = look(f"?theme={theme}{quick}")
    page.set_viewport_size({"width": size[0], "height": size[1]})
    finished(page)
    if page.locator("#menu").is_visible():
        page.locator("#menu").click()
    page.get_by_role("button", name=title, exact=True).click()
    page.wait_for_function(f"() => {DRAWN[title]}", timeout=PATIENCE)
    page.wait_for_function(
        "() => [...document.querySelectorAll('.sheet:not([hidden]) .view')].every((v) => v.clientHeight > 60)"
    )
    assert page.evaluate("document.documentElement.scrollWidth") <= size[0]
    assert title == "What matters" or painted_pixels(page, title) > 8  # that page has bars in HTML, no figure


@pytest.mark.thorough
def test_a_closed_page_removes_its_figures_and_only_one_page_is_open(visit):
    page = visit()
    finished(page)
    # what still belongs to the document: Bokeh itself looks but every half minute
    count = "new Set(Bokeh.documents[0].roots().flatMap((root) => [...root.references()])).size"
    before = page.evaluate(count)
    for title in ("Interface law", "Stick-slip"):
        page.get_by_role("button", name=title).click()
        page.wait_for_function(f"() => {DRAWN[title]}", timeout=PATIENCE)
        assert page.locator(".sheet:visible").count() == 1
    page.get_by_role("button", name="Experiment").click()
    page.wait_for_function(f"() => {count} === {before}", timeout=PATIENCE)
    assert page.locator(".sheet:visible").count() == 0
    assert "page=" not in page.url


@pytest.mark.thorough
def test_page_named_in_the_address_is_open_from_the_start(visit):
    page = visit("?page=law&delta_bar=0.1")
    finished(page)
    page.wait_for_function(f"() => {DRAWN['Interface law']}", timeout=PATIENCE)
    page.wait_for_function("() => document.getElementById('law-stick').textContent")
    numbers = [int(page.inner_text(f"#law-{state}")) for state in ("stick", "slip", "open")]
    assert sum(numbers) == page.evaluate("punch.run.frame(punch.drawn).x.length")


def test_nodes_lie_on_the_curve_of_the_interface_law(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['Interface law']}", timeout=PATIENCE)
    distance = page.evaluate(
        f"""() => {{
            const law = {MODEL.format("law_shear_law.law")}.data_source.data
            const nodes = {MODEL.format("law_shear_law.stick")}.data_source.data
            const at = (s) => {{
                const part = (s - law.s[0]) / (law.s[1] - law.s[0]), i = Math.min(Math.floor(part), law.s.length - 2)
                return law.value[i] + (part - i) * (law.value[i + 1] - law.value[i])
            }}
            return Math.max(...[...nodes.s].map((s, i) => Math.abs(nodes.value[i] - at(s))))
        }}"""
    )
    assert distance < 5e-3  # displacement and traction came as int16


def test_fit_page_axes_show_the_current_run_before_a_measurement_is_loaded(look):
    page = look("?page=fit")
    figure = MODEL.format("fit_curve").replace("=== 'fit_curve'", "=== 'fit_curve' && model.y_range")
    page.wait_for_function(f"() => {figure}?.y_range.end > 100", timeout=PATIENCE)
    ends = page.evaluate(f"(({{ x_range, y_range }}) => [x_range.end, y_range.start])({figure})")
    assert ends[0] == pytest.approx(40) and ends[1] < page.evaluate("Math.min(...punch.run.shear('L'))")


def test_page_what_matters_marks_the_punch_only_while_it_is_open(look):
    page = look()
    colours = """(() => {
        const story = document.getElementById("story"), pen = story.getContext("2d")
        return [...pen.getImageData(0, 0, story.width, story.height).data].reduce((sum, value) => sum + value, 0)
    })()"""
    page.wait_for_function("!punch.fresh")
    alone = page.evaluate(colours)
    page.evaluate("document.querySelector('nav button[data-page=matters]').click()")
    page.locator("#matters-bars button").first.wait_for()
    names = page.locator("#matters-bars span").all_inner_texts()
    assert len(names) > 5 and not any("periodic cell" in name for name in names)
    page.wait_for_function(f"() => !punch.fresh && {colours} !== {alone}")
    page.evaluate("document.querySelector('nav button[data-page=\"\"]').click()")
    page.wait_for_function(f"() => !punch.fresh && {colours} === {alone}")


def test_close_button_and_back_close_a_page_and_undo_no_change(visit):
    page = visit("?u_x_max=4&du_x=0.5")
    finished(page)
    opened = "document.querySelector('.page').dataset.page"
    for leave in (page.go_back, lambda: page.locator("#fit .close").click()):
        page.evaluate("document.querySelector('nav button[data-page=fit]').click()")
        page.wait_for_function(
            "!document.getElementById('fit').dataset.drawing && !document.getElementById('fit').hidden"
        )
        leave()
        page.wait_for_function(f"{opened} === '' && !new URLSearchParams(location.search).has('page')")
    page.evaluate("document.querySelector('nav button[data-page=fit]').click()")
    page.fill("#E-entry", "90")
    page.keyboard.press("Enter")
    page.wait_for_function("punch.status.values.E === 90 && location.search.includes('E=90')")
    page.go_back()
    page.wait_for_function(f"{opened} === ''")
    assert page.evaluate("punch.status.values.E") == 90 and "E=90" in page.url and "page=" not in page.url
    page.evaluate("document.activeElement.blur()")
    page.locator("body").press("Control+z")
    page.wait_for_function("punch.status.values.E === 70")
    assert page.evaluate(opened) == ""


def test_choosing_the_same_parameter_for_both_map_axes_swaps_them(look):
    page = look("?page=regimes")
    page.wait_for_function("document.getElementById('regimes-text').textContent")
    page.select_option("#regimes-x", "phi_ratio")
    assert page.input_value("#regimes-y") == "delta_bar"
    page.wait_for_function("document.querySelector('#regimes-at').textContent.startsWith('Point')")
    page.select_option("#regimes-y", "phi_ratio")
    assert page.input_value("#regimes-x") == "delta_bar"


def test_a_rejected_file_keeps_the_measurement_in_use(look):
    page = look("?page=fit")
    curve = "U_x (nm),F (N/m)\n" + "".join(f"{k},{2.0 * k}\n" for k in range(1, 20))
    for name, text in (("good.csv", curve), ("bad.csv", "nonsense")):
        page.set_input_files("#measurement", {"name": name, "mimeType": "text/csv", "buffer": text.encode()})
        page.wait_for_function("() => document.getElementById('measurement').value === ''")
        assert page.inner_text("#fit-of") == "good.csv"
    assert page.inner_text("#fit-text").endswith("stays.")


@pytest.mark.thorough
def test_clicking_the_stick_slip_map_loads_that_flat_scene(visit):
    page = visit("?page=stickslip")
    finished(page)
    page.wait_for_function(f"() => {DRAWN['Stick-slip']}", timeout=PATIENCE)
    box = page.locator("#stickslip figure >> nth=2").locator(".view").bounding_box()
    page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.6 * box["height"])
    page.wait_for_function("() => punch.status.values.surface === 'flat'", timeout=PATIENCE)
    finished(page, run=2)
    assert "preset=fig4a-blue" in page.url and page.evaluate("punch.status.values.E") > 200


def test_stress_picture_follows_playback(visit):
    page = visit("?page=solid", **PLAYING)
    finished(page)
    page.wait_for_function(f"() => {DRAWN['Inside the solid']}", timeout=PATIENCE)
    data = f"{MODEL.format('solid_field.field')}.data_source.data.image[0]"
    first = page.evaluate(f"[...{data}].reduce((a, b) => a + b)")
    page.wait_for_function(f"() => [...{data}].reduce((a, b) => a + b) !== {first}", timeout=PATIENCE)
    assert "GPa" in page.inner_text("#solid-extent")


@pytest.mark.thorough
def test_a_preset_replaces_every_parameter_and_says_what_to_look_for(visit):
    page = visit("?delta_bar=0.3&nu=0.3")
    finished(page)
    page.select_option("#preset", "fig4a-red")
    finished(page, run=2)
    values = page.evaluate("punch.status.values")
    assert (values["surface"], values["E"], values["nu"], values["delta_bar"]) == ("flat", 140, 0.45, 0)
    assert "stiff" in page.inner_text("#look") and "preset=fig4a-red" in page.url and "nu=" not in page.url
    page.get_by_role("button", name="Reset", exact=True).click()
    finished(page, run=3)
    assert page.input_value("#preset") == "fig6" and "preset" not in page.url


@pytest.mark.thorough
def test_clicking_several_pages_quickly_draws_only_the_last_one(visit):
    page = visit()
    finished(page)
    ordered = page.evaluate(
        """() => {
            const wire = [...Bokeh.documents[0]._all_models.values()].find((model) => model.name === 'wire')
            window.ordered = []
            wire.properties.order.change.connect(() => ordered.push(wire.order))
            for (const name of ["stickslip", "law", "solid", "arealaws", "stickslip", "law"]) {
                document.querySelector(`nav button[data-page=${name}]`).click()
            }
            return getComputedStyle(document.querySelector("#law .figures"), "::after").content
        }"""
    )
    assert "drawing" in ordered
    page.wait_for_function(f"() => {DRAWN['Interface law']}", timeout=PATIENCE)
    page.wait_for_function("() => !document.querySelector('.sheet:not([hidden])[data-drawing]')", timeout=PATIENCE)
    assert page.evaluate("ordered.filter((o) => o.do === 'page').map((o) => o.page)") == ["law"]
    assert painted_pixels(page, "Interface law") > 8


@pytest.mark.thorough
def test_stress_colours_match_the_other_views_and_follow_the_theme_while_paused(visit):
    page = visit("?page=solid&theme=light")
    finished(page)
    page.wait_for_function(f"() => {DRAWN['Inside the solid']}", timeout=PATIENCE)
    page.select_option("#solid-quantity", "normal")
    page.wait_for_function("() => document.getElementById('solid-name').textContent.includes('σzz')", timeout=PATIENCE)
    caption = page.inner_text("#solid figcaption")
    assert "compression −" in caption and "GPa tension" in caption
    mapper = f"{MODEL.format('solid_field.field')}.glyph.color_mapper"
    style = "['--push-1', '--pull-1'].map((n) => getComputedStyle(document.documentElement).getPropertyValue(n).trim())"
    ends = f"[{mapper}.palette[0], {mapper}.palette.at(-1)]"
    light = page.evaluate(ends)
    assert light == page.evaluate(style)  # compression as repulsion, tension as attraction
    page.get_by_role("button", name="Switch between light and dark").click()
    assert page.evaluate(ends) == page.evaluate(style) != light


@pytest.mark.thorough
def test_maps_of_the_law_have_a_scale_and_a_legend_for_their_nodes(look):
    page = look("?page=law")
    page.wait_for_function(f"() => {DRAWN['Interface law']}", timeout=PATIENCE)
    for name in ("shear", "normal"):
        mapper = f"{MODEL.format(f'law_{name}_map.map')}.glyph.color_mapper"
        high = float(page.inner_text(f"#law_{name}_map-high").strip("+ GPa"))
        assert high == pytest.approx(page.evaluate(f"{mapper}.high"), rel=0.05)  # two digits
    assert "past the peak" in page.inner_text("#law")
    style = "getComputedStyle(document.querySelector('.key .{}')).backgroundColor"
    assert page.evaluate(style.format("stick")) != page.evaluate(style.format("repulsive"))
    assert int(page.inner_text("#law-open")) == page.evaluate(
        f"{MODEL.format('punch.free')}.data_source.data.gap.length"
    )
    image = f"{MODEL.format('law_shear_map.map')}.data_source.data.image[0]"
    right = page.evaluate(f"[...{image}].filter((_, i) => i % 160 === 159)")
    assert min(right) > 0.0  # up to half a spacing ahead of a site the law pulls back
