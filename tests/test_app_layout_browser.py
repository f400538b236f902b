"""The page at every size of screen: nothing cut, nothing over something else, no plot too low to be read."""

import pytest
from test_app_serving import finished

pytestmark = pytest.mark.browser
pytest_plugins = ["test_app_serving"]  # its fixtures: server, visit

SIZES = (
    (360, 740),
    (390, 844),
    (844, 390),
    (768, 1024),
    (820, 1180),
    (1024, 768),
    (1280, 720),
    (1440, 900),
    (1920, 1080),
    (2560, 1440),
    (960, 600),  # 1440 x 900 at 150 %
    (720, 450),  # and at 200 %
)
# What is wrong with the page as it is laid out now, in sentences
FAULTS = """() => {
    const said = []
    const name = (e) => e.id ? `#${e.id}` : `${e.tagName.toLowerCase()} “${e.textContent.trim().slice(0, 30)}”`
    const seen = (e) => e.checkVisibility({ visibilityProperty: true }) && !e.closest('[hidden], .unseen')
    const all = (what) => [...document.querySelectorAll(what)].filter(seen)
    if (document.documentElement.scrollWidth > innerWidth) said.push(`${document.documentElement.scrollWidth} px wide`)
    for (const view of all('.view')) {
        if (view.clientHeight < 140) said.push(`${name(view.parentElement)} has a plot ${view.clientHeight} px high`)
    }
    const texts = [...document.querySelectorAll('.page *')].filter((e) => seen(e)
        && [...e.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim()))
    for (const e of new Set([...all('header *'), ...all('.about *'), ...all('.player *'), ...texts])) {
        const box = e.getBoundingClientRect()
        if (box.width && (box.left < -1 || box.right > innerWidth + 1)) said.push(`${name(e)} leaves the screen`)
    }
    for (const e of texts) {
        const clips = getComputedStyle(e).overflowX !== 'visible'
        if (clips && e.scrollWidth > e.clientWidth + 1) said.push(`${name(e)} is cut`)
        if (e.closest('.view, table, select')) continue
        const outer = e.closest('p, div, figcaption, header, form, section')?.getBoundingClientRect()
        for (const other of e.children) {
            const inner = other.getBoundingClientRect()
            if (outer && inner.width && inner.right > outer.right + 2) said.push(`${name(other)} leaves its box`)
        }
    }
    // what stays on the screen while the rest scrolls lies above the rest by intention
    const layer = (e) => e.closest('.player, .side, dialog')
    const controls = all('button, input, select, a, [role=slider]').map((e) => [e, e.getBoundingClientRect(), layer(e)])
    controls.forEach(([a, p, from], i) => {
        for (const [b, q, other] of controls.slice(i + 1)) {
            if (from !== other || a.contains(b) || b.contains(a)) continue
            const over = Math.min(p.right, q.right) - Math.max(p.left, q.left)
            const under = Math.min(p.bottom, q.bottom) - Math.max(p.top, q.top)
            if (over > 1 && under > 1) said.push(`${name(a)} and ${name(b)} overlap`)
        }
    })
    return [...new Set(said)]
}"""


def laid_out(page):
    """After the next picture of the screen, when Bokeh has followed a change of size."""
    page.evaluate("() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))")
    page.wait_for_function(  # the lens moves with the next drawing of the punch
        """() => {
            const [lens, view] = ['lens', 'punch-view'].map((id) => document.getElementById(id).getBoundingClientRect())
            return !lens.width || (lens.right <= view.right && lens.bottom <= view.bottom && lens.top >= view.top)
        }"""
    )


def faults_at_every_size(page):
    """{size: what is wrong there}"""
    found = {}
    for width, height in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        laid_out(page)
        if faults := page.evaluate(FAULTS):
            found[f"{width} x {height}"] = faults
    return found


def test_the_experiment_fits_every_screen(visit):
    page = visit()
    finished(page)
    page.get_by_role("button", name="Pause").click()
    page.keyboard.press("End")  # the longest readout
    assert not faults_at_every_size(page)


@pytest.mark.parametrize("title", ["Interface law", "Stick-slip", "Area laws", "Inside the solid"])
def test_a_page_beside_the_experiment_fits_every_screen(visit, title):
    page = visit()
    finished(page)
    page.get_by_role("button", name=title).click()
    page.wait_for_function("() => document.querySelector('.sheet:not([hidden]):not([data-drawing])')")
    assert not faults_at_every_size(page)


def test_on_a_phone_held_sideways_punch_and_sliders_are_side_by_side(visit):
    page = visit()
    page.set_viewport_size({"width": 844, "height": 390})
    finished(page)
    punch, slider, play = (page.locator(what).bounding_box() for what in ("figure >> nth=0", "#delta_bar", "#play"))
    assert punch["x"] + punch["width"] <= slider["x"]
    assert punch["height"] > 200
    assert play["y"] + play["height"] <= 390
