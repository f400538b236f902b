"""A class that answers, in Chromium: a teacher's screen and two students."""

import pytest

pytestmark = pytest.mark.thorough


@pytest.fixture
def room(visit):
    """The pages of a teacher and two students."""
    pages = []
    for _ in range(3):
        pages.append(visit("?class=quad&more=0"))
        pages[-1].wait_for_function("window.punch?.lesson")
    return pages


def vote(page, text):
    page.locator("button.answer", has_text=text).click()
    page.get_by_text("Your answer counts.").wait_for()


def test_votes_are_counted_shown_and_decided_by_the_run(room):
    teacher, one, other = room
    assert [page.evaluate("punch.lesson.leads") for page in room] == [True, False, False]
    teacher.get_by_text("2 here").wait_for()
    teacher.locator("#tour").click()
    vote(one, "proportion")
    teacher.get_by_text("1 of 2 answered").wait_for()
    assert not one.locator("button.answer:enabled").count()  # one vote
    vote(other, "jump")
    teacher.get_by_text("2 of 2 answered").wait_for()
    assert not teacher.locator(".votes").count()
    teacher.get_by_role("button", name="Show the answers").click()
    teacher.get_by_role("button", name="Run", exact=True).wait_for()
    assert sorted(teacher.locator(".votes").all_inner_texts()) == ["0", "1", "1"]
    for page in room:
        page.evaluate("punch.speed = 40")
    teacher.get_by_role("button", name="Run", exact=True).click()
    said = [page.locator("#tour-card [role=status]") for page in room]
    for page in said:
        page.wait_for()
    texts = [page.inner_text() for page in said]
    assert texts[0].startswith("1 of 2 chose the right answer.") and {text[:4] for text in texts[1:]} == {
        "Yes.",
        "Not ",
    }
    teacher.get_by_role("button", name="Next: The edges").click()
    for page in (one, other):
        page.get_by_role("heading", name="2 of 9: The edges").wait_for()


def test_a_late_student_joins_at_the_stop_of_the_class_and_may_leave_it(room, visit):
    teacher = room[0]
    teacher.locator("#tour").click()
    late = visit("?class=QUAD&more=0", rests=False)
    late.get_by_role("heading", name="1 of 9: First").wait_for()
    late.get_by_role("button", name="End tour").click()
    assert late.locator("#scrub").is_visible() and late.locator("#E").is_enabled()


def test_the_teachers_own_question_is_answered_by_the_runs_of_both_scenes(visit):
    teacher = visit("?class=OWNQ&more=0&u_x_max=16&ask=F_s&change=phi_ratio:0.5", rests=False)
    student = visit("?class=OWNQ&more=0", rests=False)
    student.get_by_text("How large is the friction when it slips").wait_for()
    vote(student, "lower")
    teacher.get_by_role("button", name="Show the answers").click()
    for page in (teacher, student):
        page.evaluate("punch.speed = 40")
    teacher.get_by_role("button", name="Run", exact=True).click()
    student.get_by_text("Yes. It is 141.9 N/m instead of").wait_for()
    assert student.evaluate("punch.status.values.u_x_max") == 16


def test_the_menu_opens_a_class_of_four_letters(visit):
    page = visit("?u_x_max=4&more=0")
    page.locator("#menu").click()
    page.locator("#class").click()
    page.wait_for_function("punch.lesson?.leads && /class=[A-Z]{4}/.test(location.search)")
    assert page.evaluate("punch.lesson.code") in page.inner_text("#lesson")


def test_a_teacher_who_loads_the_page_again_leads_the_class_on_from_its_stop(room):
    teacher, one, _ = room
    teacher.locator("#tour").click()
    teacher.get_by_text("0 of 2 answered").wait_for()
    vote(one, "proportion")
    teacher.reload()
    teacher.get_by_text("1 of 2 answered").wait_for()
    one.get_by_role("button", name="End tour").click()
    one.locator("#tour").click()  # back to the class's stop, where it has answered
    one.get_by_text("Your answer counts.").wait_for()
    teacher.get_by_role("button", name="Show the answers").focus()
    teacher.get_by_role("button", name="Show the answers").press("Enter")
    teacher.wait_for_function("document.activeElement.textContent === 'Run'")
    other = room[2]
    other.locator("button.answer").first.wait_for()
    other.wait_for_function("!document.querySelector('button.answer:enabled')")  # the answers are shown: too late


@pytest.mark.parametrize(
    ("address", "said"),
    [
        ("?class=12&u_x_max=4", "class = 12: allowed: four letters"),
        ("?class=ODDA&u_x_max=4&ask=foo", "ask = foo: allowed: U_s, F_s, L_s, A_s"),
        ("?class=ODDC&u_x_max=4&ask=F_s&change=E:1e9", "change = E:1e9"),
    ],
)
def test_a_wrong_code_or_question_is_named_with_its_value(visit, address, said):
    visit(address, rests=False).locator("[role=alert]").get_by_text(said).wait_for()
