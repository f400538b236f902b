"""All that the live sentence says, read from its text and checked against the solver over the slider ranges."""

import base64
import os
import re
from dataclasses import asdict, dataclass
from functools import cache

import numpy as np
import pytest
from visitor import slices

from app.session.controls import CONTROLS
from solver import Scene, load_path
from solver.presets import presets

SCENES = 1  # of the default suite
MANY = int(os.environ.get("SENTENCES", "30"))  # of the thorough one
POINTS = 18  # frames of a run at which the sentence is read, besides those at slips
ROUNDED = 2e-3  # what the packed fields are good for
WRITTEN = 6e-3  # and numbers in three digits
WEAK = 0.11  # of the peak attraction, as WEAK of run.js, with its rounding
READ = """async ({ now, before, at }) => {
    const { changeSentence, nowSentence, phaseSentence } = await import("http://scripts/features/sentence/sentence.js")
    const run = await runOf(now), other = before && (await runOf(before))
    const said = at.flatMap((k) => [nowSentence(run, k), phaseSentence(run, k)])
    return { said, change: other && changeSentence(run, other) }
}"""


@dataclass
class Whole:
    """All frames of a run, and its packed blocks."""

    scene: Scene
    frames: list
    blocks: list

    @property
    def sheared(self):
        return next(k for k, frame in enumerate(self.frames) if frame.stage != "approach")

    def first_slip(self):
        slips = (
            k for k, frame in enumerate(self.frames) if frame.slips and k > self.sheared and frame.stage == "shear"
        )
        return next(slips, None)


@cache
def whole(scene):
    """The run of a scene, or None where it fails."""
    blocks = []
    for piece in slices(scene, 5.0):
        if piece.failure:
            return None
        blocks += [base64.b64encode(block).decode() for block in piece.blocks]
    return Whole(scene, list(load_path(scene)), blocks)


def read(tab, run, before=None):
    last = len(run.frames) - 1
    slips = [k for k, frame in enumerate(run.frames) if frame.slips][:4]
    at = sorted({*map(int, np.linspace(0, last, POINTS)), *slips, *(min(k + 3, last) for k in slips)})
    found = tab.evaluate(READ, {"now": run.blocks, "before": before and before.blocks, "at": at})
    # a phase is never that at rest while the top moves; a retraction is played from its approach on
    lifted = run.scene.path == "unload"
    phases = [each if lifted and each < run.sheared else min(max(each, run.sheared + 1), last) for each in at]
    frames = [k for both in zip(at, phases, strict=True) for k in both]
    return list(zip(frames, found["said"], strict=True)), found["change"]


def A_of(frame):
    return frame.A_bar * frame.scene.width


def edges(frame):
    """Outermost places of repulsion in node spacings, with fractions, from the tractions themselves."""
    T = frame.T[1]
    held = np.flatnonzero(T > 0)
    i, j = held[0], held[-1]
    left = i - (T[i] / (T[i] - T[i - 1]) if i else 0)
    right = j + (T[j] / (T[j] - T[j + 1]) if j + 1 < T.size else 0)
    return frame.first + left, frame.first + right


def moved(before, now, spacing):
    """By how many sites most of the nodes in reach have moved."""
    first, last = max(before.first, now.first), min(before.first + before.u.shape[1], now.first + now.u.shape[1])
    pick = lambda frame: frame.u[0, first - frame.first : last - frame.first]  # noqa: E731
    felt = FELT * now.scene.phi_n / now.scene.delta_n
    largest = np.abs(now.T[:, first - now.first : last - now.first]).max(axis=0)  # one of the two may pass zero
    steps = np.rint((pick(now) - pick(before)) / spacing)[largest > felt]
    return abs(np.median(steps))


def event_force(frame):
    """F (N/m) at the located begin of the slip that led to a frame."""
    return frame.slips[0].F_bar * frame.scene.E * frame.scene.width


def apart(frame):
    """Whether no traction exceeds a share of the peak attraction."""
    return np.abs(frame.T).max() <= WEAK * frame.scene.phi_n / (np.e * frame.scene.delta_n)


def near(a, b, scale=1.0):
    """Whether a is b as a sentence writes it; a length in nm has the scale 10: tenths."""
    return abs(a - b) <= WRITTEN * max(abs(a), abs(b), scale)


NUMBER = r"(−?[\d.]+)"
FELT = 4.5e-4  # of phi_n/delta_n: the traction at a gap of 10 delta_n, beyond which no node slips by sites
SITES = {"no": 0, "one": 1, "two": 2, "three": 3, "four": 4, "five": 5, "six": 6}


def real(text):
    return float(text.replace("−", "-"))


class At:
    """What is true at a frame of a run, by the solver: `k`, that of the slip that its sentence is about, if any."""

    def __init__(self, run, k):
        self.run, self.k, self.frame, self.before = run, k, run.frames[k], run.frames[max(0, k - 1)]
        self.way = -1 if self.frame.stage == "back" else 1
        self.small = 1e-6 * max(abs(frame.F) for frame in run.frames) + 1e-9

    @property
    def slips(self):
        return bool(self.frame.slips)

    @property
    def rises(self):
        return self.way * self.frame.F >= self.way * self.before.F - ROUNDED * abs(self.frame.F) or bool(
            self.before.slips
        )

    @property
    def eases(self):
        return self.way * self.frame.F <= self.way * self.before.F + ROUNDED * abs(self.frame.F)

    def area(self, change):
        now, before = A_of(self.frame), A_of(self.before)
        return {"more": now > before, "less": now < before, "none": now == 0, "some": now > 0}[change]

    def forces(self, match):
        return near(abs(event_force(self.frame)), real(match[1])) and near(abs(self.frame.F), real(match[2]))

    def moved(self, sites, nm):
        spacing = self.run.scene.spacing
        return moved(self.before, self.frame, spacing) == sites and near(sites * spacing, nm, 10.0)

    def jerks(self, nm):
        """Whether the first two slips of the stage are by so many nm."""
        first = [
            k for k, f in enumerate(self.run.frames) if f.slips and k > self.run.sheared and f.stage == self.frame.stage
        ]
        spacing = self.run.scene.spacing
        return all(
            near(moved(self.run.frames[k - 1], self.run.frames[k], spacing) * spacing, nm, 10.0) for k in first[:2]
        )

    def swings(self, low, high):
        """Whether it slides without slips, with F between these from its first top on."""
        F = [frame.F for frame in self.run.frames]
        top = self.run.sheared + 1
        while F[top + 1] >= F[top]:
            top += 1
        wide = WRITTEN * max(abs(low), abs(high))
        return self.run.first_slip() is None and all(low - wide <= force <= high + wide for force in F[top:])

    def peeled(self, where, more=""):
        begun, frames = self.k, self.run.frames
        while begun > self.run.sheared and not frames[begun].slips and frames[begun - 1].stage == self.frame.stage:
            begun -= 1
        return _peeled(frames, begun, self.k, where, more)


TRUE = (  # what a sentence says, and whether it is so
    ("a faint pull", lambda at, _: apart(at.frame)),
    ("^(It|A part of the contact) slips|^It lets go|lets go at once|^It jumps", lambda at, _: at.slips),
    (rf"slips by (\w+) sites?, {NUMBER} nm", lambda at, m: at.moved(SITES.get(m[1]) or int(m[1]), real(m[2]))),
    (rf"from {NUMBER} to {NUMBER} N/m", lambda at, m: at.forces(m)),
    ("contact comes back|jumps into contact|the contact grows", lambda at, _: at.area("more")),
    ("contact is lost", lambda at, _: at.area("less")),
    ("nothing is pressed together|Nothing is pressed together", lambda at, _: at.area("none")),
    ("does not let go|Lowered onto", lambda at, _: at.area("some")),
    ("jumps closer", lambda at, _: at.frame.L < at.before.L),
    ("does not let go|hangs on attraction", lambda at, _: at.frame.L < 0),
    ("still pressed together", lambda at, _: -at.small < at.frame.L),
    ("nothing pulls sideways yet", lambda at, _: at.k <= at.run.sheared),
    (rf"swings by ±{NUMBER}", lambda at, m: at.swings(-real(m[1]), real(m[1]))),
    (rf"swings between {NUMBER} and {NUMBER}", lambda at, m: at.swings(real(m[1]), real(m[2]))),
    (rf"in jerks: it sticks, slips {NUMBER} nm", lambda at, m: at.jerks(real(m[1]))),
    ("Still bent|Friction eases", lambda at, _: at.eases),
    ("lean out of the punch", lambda at, _: at.way * at.frame.F < at.small),
    ("^It sticks|carries the friction", lambda at, _: at.rises),
    ("lets go behind", lambda at, _: at.peeled("behind")),
    ("lets go in front", lambda at, _: at.peeled("front")),
    ("let go, more behind", lambda at, _: at.peeled("both", "behind")),
    ("let go, more in front", lambda at, _: at.peeled("both", "front")),
    (r"Both edges of the contact let go\.", lambda at, _: at.peeled("both")),
)


def wrong_in(run, k, said):
    """What a sentence {key, text} says of frame k that is not so; its key names the slip that it is about."""
    slip = re.fullmatch(r"(?:slip|in|off|part) (\d+)", said["key"])
    at = At(run, int(slip[1]) if slip else k)
    found = [(pattern, check, re.search(pattern, said["text"])) for pattern, check in TRUE]
    checked = [(pattern, check(at, match)) for pattern, check, match in found if match]
    assert checked or said["key"] in ("film", "jerks") or "another shape" in said["text"], said
    return [pattern for pattern, true in checked if not true]


def wrong_of_change(run, before, text):
    """What the sentence on a change says that is not so."""
    now, then = run.first_slip(), before.first_slip()
    U = lambda whole, k: whole.frames[k].slips[0].load  # noqa: E731
    F = lambda whole, k: event_force(whole.frames[k])  # noqa: E731
    area = lambda whole: A_of(whole.frames[whole.sheared])  # noqa: E731
    steep = lambda whole, k: F(whole, k) / U(whole, k)  # noqa: E731
    gap = lambda whole, k: whole.frames[k - 1].u[1, 0]  # noqa: E731
    least = lambda whole: min(frame.L for frame in whole.frames)  # noqa: E731
    rules = (
        ("do not hold on", lambda _: all(map(apart, run.frames)) and not all(map(apart, before.frames))),
        ("now the surfaces hold on", lambda _: not all(map(apart, run.frames)) and all(map(apart, before.frames))),
        ("no slip any more", lambda _: now is None and then is not None),
        (rf"now it slips, first at {NUMBER} nm", lambda m: then is None and near(U(run, now), real(m[1]), 10.0)),
        (
            rf"at {NUMBER} nm instead of {NUMBER} nm",
            lambda m: near(U(run, now), real(m[1]), 10.0) and near(U(before, then), real(m[2]), 10.0),
        ),
        ("slips earlier", lambda _: U(run, now) < U(before, then)),
        ("slips later", lambda _: U(run, now) > U(before, then)),
        (
            rf"(?:, |slips at ){NUMBER} N/m instead of {NUMBER} N/m",
            lambda m: near(F(run, now), real(m[1])) and near(F(before, then), real(m[2])),
        ),
        (
            rf"takes up to {NUMBER} N/m instead of {NUMBER} N/m",
            lambda m: near(-least(run), real(m[1])) and near(-least(before), real(m[2])),
        ),
        (
            rf"swings by ±{NUMBER} N/m instead of by ±{NUMBER} N/m",
            lambda m: all(At(of, of.sheared).swings(-real(m[i]), real(m[i])) for i, of in ((1, run), (2, before))),
        ),
        ("builds up more force", lambda _: steep(run, now) > steep(before, then)),
        ("builds up less force", lambda _: steep(run, now) < steep(before, then)),
        ("closer together", lambda _: gap(run, now) < gap(before, then)),
        ("farther apart", lambda _: gap(run, now) > gap(before, then)),
        ("more contact to hold", lambda _: area(run) > area(before)),
        ("less contact to hold", lambda _: area(run) < area(before)),
        ("springs hold longer", lambda _: F(run, now) > F(before, then)),
        ("springs give way sooner", lambda _: F(run, now) < F(before, then)),
        ("hardly a difference", lambda _: True),
    )
    checked = [(pattern, check(match)) for pattern, check in rules if (match := re.search(pattern, text))]
    assert checked, text
    return [pattern for pattern, true in checked if not true]


def _peeled(frames, begun, k, where, more):
    """Whether the edges have moved inward where it is said so: half a site is worth a word, 1.3 times as far is more.

    Both with a margin: a page's tractions are right to packing.FINE of the largest, twice, which is a site where they
    are small.
    """
    (left, right), (start, end) = edges(frames[k]), edges(frames[begun])
    inward = (left - start, end - right)
    behind, front = inward[::-1] if frames[k].stage == "back" else inward
    let_go = {"both": min(behind, front), "behind": behind, "front": front}[where]
    further = {"": 1.0, "behind": behind - 1.1 * front, "front": front - 1.1 * behind}[more]
    return let_go > 0.3 and further > 0.0


def drawn(seed):
    """A scene of the sliders' box, and the same with one of them moved."""
    random = np.random.default_rng(seed)
    values = {control.name: float(random.choice(control.positions)) for control in CONTROLS}
    moved = CONTROLS[random.integers(len(CONTROLS))]
    scene = Scene(**values, nodes=512, u_x_max=25.0, du_x=0.2, du_z=0.5)
    return scene, scene.changed(**{moved.name: float(random.choice(moved.positions))})


def false_in(tab, run, before=None):
    said, change = read(tab, run, before)
    wrong = [(k, one["text"], claims) for k, one in said if (claims := wrong_in(run, k, one))]
    if change and (claims := wrong_of_change(run, before, change["text"])):
        wrong.append(("change", change["text"], claims))
    return wrong


@pytest.mark.once(2)
@pytest.mark.parametrize("name", presets())
def test_sentences_about_presets_are_true(tab, name):
    scene = presets()[name].scene
    run = whole(scene.changed(du_x=max(scene.du_x, 0.2), u_x_max=min(scene.u_x_max, 20.0)))
    assert not false_in(tab, run)


@pytest.mark.once(SCENES)
@pytest.mark.parametrize("seed", range(SCENES + MANY))
def test_sentences_are_true_for_random_slider_settings(tab, seed):
    scene, changed = drawn(seed)
    before, run = whole(scene), whole(changed)
    if before and run:  # a run given up has no sentence but the remedy (tests/validation/test_stability.py)
        assert not false_in(tab, run, before)


FLAT, SMOOTH, RAISED = (presets()[name].scene for name in ("fig4a-blue", "fig4b-stiff", "unload"))
CHANGES = [  # a scene, what is changed, and what that is said to do
    (FLAT.changed(delta_bar=0.0), {"delta_bar": 0.3}, "closer together, its springs hold on more firmly"),
    (FLAT.changed(delta_bar=0.3), {"delta_bar": 0.1}, "farther apart, its springs hold on less firmly"),
    (SMOOTH, {"phi_ratio": 0.02}, "friction swings by ±71.4 N/m instead of by ±357 N/m"),
    (RAISED, {"E": 70.0}, "raising it takes up to"),
    (Scene(nodes=512), {"radius": 2.0}, "A sharper punch: it slips earlier"),
]


@pytest.mark.thorough
@pytest.mark.parametrize(("scene", "change", "said"), CHANGES)
def test_sentences_explain_changes_of_flats_smooth_sliding_and_retraction(tab, scene, change, said):
    before, run = whole(scene), whole(scene.changed(**change))
    assert said in read(tab, run, before)[1]["text"]
    assert not false_in(tab, run, before)


@pytest.mark.thorough
@pytest.mark.parametrize("depth", [-0.56, -0.52, -0.48])
def test_the_sentence_on_a_change_does_not_contradict_the_one_beside_it(tab, depth):
    before, run = (whole(Scene(nodes=512, u_x_max=4.0, delta_bar=at)) for at in (-0.7, depth))
    said, change = read(tab, run, before)
    far = all("faint pull" in one["text"] for k, one in said if k >= run.sheared)
    assert far == ("now the surfaces hold on" not in (change or {"text": ""})["text"])


PLAYED = """async ({ now, speed }) => {
    const { phaseSentence } = await import("http://scripts/features/sentence/sentence.js")
    const { paceAt } = await import("http://scripts/static/js/player.js")
    const run = await runOf(now), seen = [], DT = 0.02
    for (let at = run.beginning; at < run.length - 1; at += (DT * paceAt(run, at, speed)) / run.head.step) {
        const { key, text } = phaseSentence(run, Math.floor(at))
        if (seen.at(-1)?.key === key) seen.at(-1).seconds += DT
        else seen.push({ key, text, seconds: DT })
    }
    return seen
}"""


def test_each_phase_of_playback_has_one_sentence_long_enough_to_read(tab):
    seen = tab.evaluate(PLAYED, {"now": whole(Scene(u_x_max=25.0)).blocks, "speed": 4.0})
    texts = [one["text"] for one in seen]
    assert texts == [
        "It sticks: the punch leans over, and friction grows with the pull.",
        "It sticks and leans over. The contact lets go behind.",
        "It sticks and leans over. Both edges of the contact let go, more behind than in front.",
        "It slips by one site, 2.4 nm: friction drops, and contact comes back.",
        "Sliding in jerks: it sticks, slips 2.4 nm, sticks again.",
    ]
    assert sum(one["seconds"] for one in seen[:3]) >= 5.0  # of one first stick, which would take 2.7 s
    assert all(one["seconds"] >= 2.5 for one in seen[3:])


@pytest.mark.thorough
def test_smooth_sliding_is_one_phase_with_its_force_range(tab):
    seen = tab.evaluate(PLAYED, {"now": whole(SMOOTH).blocks, "speed": 4.0})
    assert seen[-1]["text"] == "It slides without slips: friction swings by ±357 N/m in every lattice period."


def test_a_retraction_is_not_called_raised_before_it_is(tab):
    """It was played from its approach on, and said all the way down that adhesion holds the raised punch."""
    seen = tab.evaluate(PLAYED, {"now": whole(Scene(path="unload", du_x=0.2, du_z=0.2)).blocks, "speed": 4.0})
    texts = [one["text"] for one in seen]
    raised = next(k for k, text in enumerate(texts) if text.startswith("Raised"))
    assert texts[0].startswith("The punch comes down")
    assert raised > 1 and texts[raised - 1].startswith(("Lowered", "It jumps"))


def test_a_run_that_pulls_off_says_so_at_its_end(visit):
    """It said that it slides without slips, in every lattice period, and ended within the first."""
    page = visit("?hold=load&delta_bar=-0.2&phi_ratio=0.5&nodes=64&width=160&radius=0.2&u_x_max=10")
    page.wait_for_function("punch.run?.whole && punch.status.state === 'finished'")
    page.evaluate(
        """() => {
            const scrub = document.getElementById('scrub')
            scrub.value = punch.run.length - 1
            scrub.dispatchEvent(new Event('input', { bubbles: true }))
        }"""
    )
    page.wait_for_function("document.getElementById('sentence').textContent.startsWith('It pulls off')")


def test_a_friction_that_vanishes_has_no_range_of_zero(tab):
    """It swung by ±0 N/m."""
    tab.evaluate("async () => { window.swing = (await import('http://scripts/features/sentence/sentence.js')).swing }")
    assert tab.evaluate("swing({ low: -1e-6, high: 1e-6 })") == "too little to be shown"
    assert tab.evaluate("swing({ low: -71.4, high: 71.4 })") == "by ±71.4 N/m"


LEAP = """async ({ now }) => {
    const { saidNext } = await import("http://scripts/features/sentence/sentence.js")
    const run = await runOf(now), before = { key: "near", text: "nothing is pressed together yet", k: 3, since: 0, run }
    const next = { key: "stick", text: "It sticks." }
    return [5, 200].map((k) => saidNext(before, next, { moving: true, k, time: 100, run }).text)
}"""


def test_a_sentence_does_not_stay_where_the_picture_jumps_to_another_place(tab):
    """It said for 2.5 s that nothing is pressed together, over a contact of 206 nm."""
    said = tab.evaluate(LEAP, {"now": whole(Scene(u_x_max=25.0)).blocks})
    assert said == ["nothing is pressed together yet", "It sticks."]


TURN = """async ({ now }) => {
    const { saidNext } = await import("http://scripts/features/sentence/sentence.js")
    const run = await runOf(now), next = { key: "held", text: "Raised." }
    const before = { key: "in 1", text: "It jumps closer.", k: run.sheared - 1, since: 0, run }
    return saidNext(before, next, { moving: true, k: run.sheared, time: 100, run }).text
}"""


def test_a_sentence_ends_where_the_top_turns(tab):
    """Over a raised punch it still said that it jumps closer."""
    scene = Scene(path="unload", du_x=0.2, du_z=0.2)
    assert tab.evaluate(TURN, {"now": whole(scene).blocks}) == "Raised."


LOOPS = """async ({ now, speed, loops }) => {
    const { phaseSentence, saidNext } = await import("http://scripts/features/sentence/sentence.js")
    const run = await runOf(now), seen = [], MS = 20
    let said = { key: "", text: "", k: 0, since: -Infinity }, time = 0
    for (let loop = 0; loop < loops; loop++) {
        for (let at = run.beginning; at < run.length; at += (speed * MS) / 1000 / run.head.step, time += MS) {
            const k = Math.floor(at)
            said = saidNext(said, phaseSentence(run, k), { moving: true, k, time })
            seen.push([loop, k - run.sheared, said.text])
        }
    }
    return { seen, slips: run.frames((k) => run.curves.slip[k] && k > run.sheared).map((k) => k - run.sheared) }
}"""


def test_every_loop_of_playing_says_the_slip_and_never_says_sticking_through_one(tab):
    """At full speed: only the first way through a run is slowed down."""
    played = tab.evaluate(LOOPS, {"now": whole(Scene(u_x_max=25.0)).blocks, "speed": 4.0, "loops": 3})
    first = played["slips"][0]
    for loop in range(3):
        said = {k: text for of, k, text in played["seen"] if of == loop}
        assert "slips by one site" in said[first], loop
        assert all(said[k].startswith("It sticks") for k in range(2, first)), loop
        assert not any(said[k].startswith("It sticks") for k in said if k > first), loop


def test_forces_and_their_ranges_have_one_unit_however_small_they_are(tab):
    numbers = tab.evaluate(
        """import("http://scripts/static/js/quantities.js").then(({ number, withUnit, named, spoken }) => [
            number("F", -0.0856), withUnit("F", 0.0946), withUnit("F", 12345.6), named("E", 70), spoken("F", 0.5),
            withUnit("A", 97.25)])"""
    )
    said = ["−0.0856", "0.0946 N/m", "12300 N/m", "E = 70 GPa", "0.5 newtons per metre", "97.3 nm"]
    assert numbers == said


def test_every_parameter_of_a_scene_is_told_with_its_value_also_where_that_is_a_word(tab):
    names = list(asdict(Scene()))
    told = tab.evaluate(
        """(names) => import("http://scripts/static/js/quantities.js").then(({ named }) => (
            names.map((name) => named(name, "xu-needleman"))))""",
        names,
    )
    assert not [text for text in told if " = xu-needleman" not in text]


COUNTED = """async (now) => {
    const { Run } = await import("http://scripts/static/js/run.js")
    const { phaseSentence } = await import("http://scripts/features/sentence/sentence.js")
    const run = await runOf(now)
    let decoded = 0
    const frame = Run.prototype.frame
    Run.prototype.frame = function (k) { decoded++; return frame.call(this, k) }
    const counts = run.frames(() => true).map((k) => {
        decoded = 0
        phaseSentence(run, k)
        return decoded
    })
    Run.prototype.frame = frame
    return counts
}"""


@pytest.mark.once
@pytest.mark.parametrize("name", ["unload", "fig6"])
def test_a_sentence_decodes_a_few_frames_however_many_nodes_there_are(tab, name):
    """Decoding once per node took seconds for a picture near a jump."""
    scene = presets()[name].scene.changed(u_x_max=20.0, nodes=256, width=625.0)
    counts = tab.evaluate(COUNTED, whole(scene).blocks)
    assert max(counts) <= 8 and sorted(counts)[len(counts) // 2] <= 2
