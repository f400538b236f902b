"""Whatever a visitor does: what is drawn, said and entered belongs to one scene and increment, or the page marks it."""

import random

import pytest
from playwright.sync_api import TimeoutError as TookTooLong
from served import PLAYING
from tabs import imported

# Looks at the page before each picture of the screen, where everything is drawn: `pictures` counts, `wrong` lists
WATCH = """() => {
    const { sentence: { nowSentence, phaseSentence } } = modules
    const by = (id) => document.getElementById(id)
    const HOLD = 2600 // ms for which a sentence may stay while pictures follow each other, until the next picture
    const EVENT = /^(slip|in|off|part) / // keys of sentences that take the place of others at once
    Object.assign(window, { pictures: 0, wrong: [] })
    let last = null, at = 0, before = 0 // the last picture, when it and the one before it came, ms
    // {time, key, text} of what was true. The sentence that is there already counts as true now
    let recent = [{ time: performance.now(), key: "", text: by("sentence").textContent }]
    const entered = (run) => ["delta_bar", "phi_ratio", "E"].filter((name) => {
        const entry = by(`${name}-entry`), typed = entry === document.activeElement || !by(`${name}-error`).hidden
        return !typed && Math.abs(Number(entry.value) - Number(run.scene[name])) > 1e-9
    })
    const look = () => {
        requestAnimationFrame(look)
        const { picture, charted, lost, dragging, playing, instead, fresh } = punch
        if (instead || lost || !picture || !charted?.scene || !picture.run.scene) return
        const { run, k } = picture, moving = playing || dragging, time = performance.now()
        const tell = (what) => { if (wrong.length < 20) wrong.push(`${what} [picture ${pictures}, increment ${k}]`) }
        const now = moving ? phaseSentence(run, k) : nowSentence(run, k)
        if (picture !== last) [before, at] = [at, time]
        recent = recent.filter((each) => each.time > before - HOLD)
        recent.push(...[now, nowSentence(run, k), phaseSentence(run, k)].map((each) => ({ ...each, time })))
        if (picture !== last) pictures++
        last = picture
        if (fresh) return // more of it is being drawn
        for (const [of, seen, what] of [[run, ".hero", "the punch"], [charted, "figure.forces", "the curves"]]) {
            const other = entered(of)
            if (!other.length || document.querySelector(seen).ariaBusy === "true" || (dragging && of.followed)) continue
            tell(`${what}: ${other.map((name) => [name, of.scene[name], "entered", by(`${name}-entry`).value])}`)
        }
        const { x, y } = charts.punch.parts.surface, { gap } = run.frame(k)
        if (x.length && (y.length !== gap.length || [0, 0.25, 0.5, 1].some((part) => {
            const i = Math.round(part * (gap.length - 1))
            return y[i] !== gap[i]
        }))) tell("the surface is that of another increment")
        const scrubbed = Number(by("scrub").value)
        if (run === punch.run && !run.followed && scrubbed !== k) tell(`scrubbed to ${scrubbed}`)
        const said = by("sentence").textContent, known = recent.filter(({ text }) => text === said)
        if (!moving && said !== now.text) tell(`at rest: “${said}”, true: “${now.text}”`)
        if (moving && !known.length) tell(`not true for ${HOLD} ms: “${said}”, true: “${now.text}”`)
        if (moving && EVENT.test(now.key) && !known.some(({ key }) => key === now.key))
            tell(`in place of “${now.text}”: “${said}”`)
    }
    look()
}"""
TYPED = {"E": ("35", "70", "140", "300"), "delta_bar": ("-0.2", "0", "0.3", "-0.9"), "phi_ratio": ("0.1", "0.5", "1")}
KEYS = "Space", "Space", "Home", "End", "ArrowRight", "Shift+ArrowRight", "Shift+ArrowLeft"
PRESETS = "fig6", "fig7-case1", "fig7-case3", "fig4a-blue", "no-load"


def drag(page, dice):
    box = page.locator(f"#{dice.choice([*TYPED])}").bounding_box()
    if not box:
        return  # not in sight at this stop of the tour
    x, y = box["x"] + dice.uniform(0.2, 0.8) * box["width"], box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for _ in range(dice.randint(3, 12)):
        x = min(max(x + dice.uniform(-30, 30), box["x"] + 2), box["x"] + box["width"] - 2)
        page.mouse.move(x, y)
        page.evaluate("() => new Promise(requestAnimationFrame)")
    page.mouse.up()


def write(page, dice):
    name = dice.choice([*TYPED])
    entry = page.locator(f"#{name}-entry")
    if entry.is_visible():
        try:
            entry.fill(dice.choice(TYPED[name]), timeout=10_000)
        except TookTooLong:  # a stop of the tour, or a key before, has hidden it meanwhile
            assert not entry.is_visible()
            return
        entry.press("Enter")
        page.evaluate("document.activeElement.blur()")


def choose(page, dice):
    if page.locator("#preset").is_visible():
        page.select_option("#preset", dice.choice(PRESETS))


def tour(page, dice):
    page.evaluate(f"modules.tour.openTour({dice.randint(1, 9)})")
    if dice.random() < 0.7:
        page.locator("#tour-card button.answer").first.wait_for()
        page.keyboard.press(dice.choice("123"))
        show(page, dice)
    page.get_by_role("button", name="End tour").click()


def press(page, dice):
    page.locator("body").press(dice.choice(KEYS))


def show(page, dice):
    """Let it play for some pictures, or until it rests."""
    before = page.evaluate("pictures")
    page.wait_for_function(
        f"() => pictures >= {before + dice.randint(5, 40)} || !punch.playing && !punch.dragging && !punch.stale"
    )


@pytest.mark.once
@pytest.mark.parametrize("most", [30, 2000])
def test_every_picture_sentence_and_entry_are_of_one_scene_and_increment_or_marked(visit, most):
    page = visit("?more=1", **PLAYING)
    imported(page, "features/sentence/sentence", "features/tour/tour").evaluate(WATCH)
    dice = random.Random(most)
    actions = [drag, drag, write, press, press, choose, tour]
    while page.evaluate("pictures") < most:
        dice.choice(actions)(page, dice)
        show(page, dice)
        assert page.evaluate("wrong") == []


WAITS = """() => {
    const { picture: { run, k }, at } = punch, { sentence: { nowSentence } } = modules
    punch.playing = false // in one go with a run on its way that has not got there
    punch.run = Object.create(run, { length: { value: Math.floor(at / 2) }, sheared: { value: -1 } })
    return nowSentence(run, k).text
}"""


def test_the_sentence_of_a_picture_comes_to_rest_while_the_run_to_come_has_not_got_there(visit):
    page = visit("?more=1", **PLAYING)
    imported(page, "features/sentence/sentence")
    page.locator("#sentence", has_text="Sliding in jerks").wait_for()
    rests = page.evaluate(WAITS)
    page.wait_for_function("!punch.fresh")
    assert page.locator("#sentence").text_content() == rests != "Sliding in jerks"
