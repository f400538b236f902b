"""A class that answers, without a browser: who leads, one vote each, and what hostile students can change."""

import pytest
from visitor import Page

from app.features.lesson import feature as classes


@pytest.fixture
def visitors(pool):
    """Join a class as another visitor, of a browser of its own unless a secret is given."""
    pages = []

    def join(code="ABCD", secret="", **more):
        pages.append(Page(pool))
        pages[-1].order("join", code=code, secret=secret or f"browser {len(pages)}", **more)
        return pages[-1]

    yield join
    for page in pages:
        page.session.close()
    assert not classes._classes  # nothing is kept of a class that everybody has left


def told(page):
    """The state of the class that a visitor was sent last."""
    page.run_all()
    return [message for message in page.messages if message["kind"] == "lesson"][-1]


def test_the_first_visitor_of_a_code_leads_and_the_others_follow(visitors):
    teacher, student = visitors(), visitors()
    teacher.order("lead", stop=3, phase="ask")
    assert told(teacher)["leads"] and told(teacher)["here"] == 1
    late = visitors()
    assert not told(student)["leads"] and told(student)["stop"] == told(late)["stop"] == 3
    assert not {"here", "answered", "counts", "secret"} & told(student).keys()


def test_thirty_votes_are_counted_and_shown_once_the_teacher_shows_them(visitors):
    teacher = visitors()
    students = [visitors() for _ in range(30)]
    teacher.order("lead", stop=1, phase="ask")
    for k, student in enumerate(students):
        student.order("vote", answer=k % 3)
    assert told(teacher)["answered"] == 30 and told(teacher)["counts"] is None
    teacher.order("lead", stop=1, phase="shown")
    assert told(teacher)["counts"] == [10, 10, 10]
    students[0].order("vote", answer=1)  # too late
    assert told(teacher)["counts"] == [10, 10, 10]
    teacher.order("lead", stop=2, phase="ask")
    assert told(teacher)["answered"] == 0


def test_a_hostile_student_has_one_vote_and_leads_nobody(visitors):
    teacher, student, hostile = visitors(), visitors(), visitors()
    teacher.order("lead", stop=1, phase="ask")
    for _ in range(10_000):
        hostile.order("vote", answer=2)
    for forged in (
        {"stop": 9, "phase": "ask"},
        {"stop": -1, "phase": "ask"},
        {"stop": 1, "phase": "over"},
        {"stop": 1, "phase": "ask", "ask": "secret", "change": {"E": "1"}},
        {"stop": 1, "phase": "run"},
    ):
        hostile.order("lead", **forged)
    for answer in (3, -1, "1", 1.5, None):
        hostile.order("vote", answer=answer)
    hostile.order("join", code="ABCD", secret="guess")
    teacher.order("lead", stop=1, phase="shown")
    assert told(teacher)["counts"] == [0, 0, 1] and told(student)["stop"] == 1


@pytest.mark.parametrize("code", ["abcd", "ABC", "ABCDE", "AB1D", "", "ÄBCD", "ABCD\n"])
def test_a_code_of_anything_but_four_letters_is_refused(visitors, code):
    page = visitors(code)
    assert not page.messages and page.session.notes


def test_a_teacher_whose_page_is_opened_again_leads_again_and_others_do_not(visitors):
    teacher, student = visitors(secret="of the teacher"), visitors()
    assert not told(visitors(secret="of the teacher"))["leads"]  # a second page of that browser, to see a student's
    teacher.session.close()
    assert not told(student)["led"] and not told(visitors())["leads"]
    assert told(visitors(secret="of the teacher"))["leads"]
    assert told(student)["led"] and not told(student)["leads"]
    again = visitors(secret="of the teacher", was="teacher")  # loaded again: the last page may not have left yet
    assert told(again)["leads"] and not told(visitors(secret="guess", was="teacher"))["leads"]


def test_a_student_whose_page_comes_first_after_a_restart_of_the_server_does_not_lead(visitors):
    student = visitors(was="student")
    assert not told(student)["leads"] and told(visitors())["leads"]


@pytest.mark.parametrize("change", [None, {}, {"E": "1e9"}, {"E": "abc"}, {"path": "loop"}])
def test_a_question_that_no_run_answers_is_refused_with_the_value(visitors, change):
    teacher = visitors()
    teacher.order("lead", stop=0, phase="ask", ask="F_s", change=change)
    assert "stop" not in told(teacher) and "change = " in teacher.session.notes[0]


def test_a_full_class_is_named_and_its_students_stay(visitors, monkeypatch):
    monkeypatch.setattr(classes, "STUDENTS", 1)
    teacher, _ = visitors(), visitors()
    third = visitors()
    assert "has 1 students" in third.session.notes[0]
    assert told(teacher)["here"] == 1 and third.session.features["lesson"].of is None


def test_a_question_of_the_teacher_carries_the_scene_at_hand(visitors):
    teacher, student = visitors(), visitors()
    teacher.session.scene = teacher.session.scene.changed(E=35.0)
    teacher.order("lead", stop=0, phase="ask", ask="F_s", change={"phi_ratio": "0.5"})
    sent = told(student)
    assert sent["base"]["E"] == "35" and (sent["ask"], sent["change"]) == ("F_s", {"phi_ratio": "0.5"})
