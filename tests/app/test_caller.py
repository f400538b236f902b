"""A call in another process gets its own answer, whatever happened to the call before."""

import subprocess
import sys

import pytest

from app.service.caller import Caller, Lost


def news(count):
    """A generator of `count` items, whose value is another word."""
    yield from range(count)
    return "end"


def twice(number):
    return 2 * number


@pytest.fixture
def caller():
    one = Caller()
    yield one
    one.end()


def test_items_are_heard_and_the_value_of_the_generator_is_the_result(caller):
    heard = []
    assert caller.call(news, 3, hear=heard.append) == "end" and heard == [0, 1, 2]
    assert caller.call(twice, 21) == 42


def test_a_generator_stops_at_its_next_item_and_leaves_the_process_to_the_next_call(caller):
    """A cancelled fit cost its worker, and the next one some seconds to start."""
    heard = []

    def hear(item):
        heard.append(item)
        caller.stop()

    assert caller.call(news, 10**9, hear=hear) is None and len(heard) < 10**6
    assert caller.call(twice, 21) == 42
    caller.stop()  # too late: nothing runs
    assert caller.call(twice, 4) == 8


@pytest.mark.parametrize("failure", [ValueError, OSError, KeyboardInterrupt])
def test_a_listener_that_fails_ends_the_process_so_that_no_later_call_gets_that_answer(caller, failure):
    def hear(item):
        raise failure(item)

    with pytest.raises(failure):
        caller.call(news, 3, hear=hear)
    assert not caller.alive()
    with pytest.raises(Lost) as lost:
        caller.call(twice, 21)
    assert lost.value.kind == "crash"


@pytest.mark.parametrize(("function", "argument"), [(twice, None), (lambda x: x, 1), (twice, lambda: 0)])
def test_a_call_that_fails_or_cannot_be_pickled_leaves_the_process_to_the_next_one(caller, function, argument):
    with pytest.raises(Lost) as lost:
        caller.call(function, argument)
    assert lost.value.kind == "error"
    assert caller.call(twice, 21) == 42


CALLS = """
from app.limits import increments_of
from app.service import pool
from app.service.caller import Caller
from solver import Scene
print(Caller().call(increments_of, Scene()) == increments_of(Scene()))
"""


@pytest.mark.parametrize("name", ["app/__init__.py", "solver.py", "numpy.py", "signal.py"])
def test_a_process_imports_nothing_of_the_folder_in_which_it_is_started(tmp_path, name):
    """A project of the user's may have modules of the same names."""
    script, own = tmp_path / "bin" / "script.py", tmp_path / "project" / name  # a script finds what is installed
    for file, text in ((script, CALLS), (own, "raise SystemExit('of the folder')")):
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    run = {"cwd": tmp_path / "project", "capture_output": True, "text": True, "timeout": 300}
    ended = subprocess.run([sys.executable, script], **run)
    assert (ended.stdout, ended.returncode) == ("True\n", 0), ended.stderr
