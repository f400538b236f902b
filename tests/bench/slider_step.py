"""What the server runs for one step of a held slider: functions of app/, and returns to a file already left.

    python tests/bench/slider_step.py [--list] [--json FILE]

From the parameter `scene`, which Panel sets, to the parameter `skeleton`, which it sends, in all threads, after a step
that has warmed everything up. A return is a call into another file that was called into before: whoever reads along
turns back to it. Calls of features that do nothing, and of the queue's own bookkeeping, count like all others. --list
prints the functions in their order.
"""

import sys
import threading
from pathlib import Path

from scenes import options, write

sys.path.insert(0, str(Path(__file__).parents[1] / "shared"))
from visitor import Page

from app.service.jobs import Jobs
from app.service.pool import Pool

APP = Path(__file__).parents[2] / "app"
STATED = {"<listcomp>", "<genexpr>", "<lambda>", "<dictcomp>", "<setcomp>", "<module>"}  # part of their function


class Calls:
    """The functions of app/ that are called between `begin` and `end`, as (file, name), in their order."""

    def __init__(self):
        self.made, self.on, self._lock = [], False, threading.Lock()

    def __call__(self, frame, event, _):
        code = frame.f_code
        if self.on and event == "call" and code.co_filename.startswith(str(APP)) and code.co_name not in STATED:
            with self._lock:
                self.made.append((str(Path(code.co_filename).relative_to(APP)), code.co_qualname))


def returns(calls):
    """How many calls go to another file than the one before, and to one that was called into earlier."""
    seen, last, count = set(), None, 0
    for file, _ in calls:
        count += file != last and file in seen
        seen.add(file)
        last = file
    return count


def main():
    parser = options(__doc__)
    parser.add_argument("--list", action="store_true", help="print the functions in their order")
    arguments, calls = parser.parse_args(), Calls()
    threading.setprofile(calls)  # of the threads of the pool
    pool = Pool(2)
    page = Page(pool, jobs=Jobs(pool))
    page.order("hello")
    page.until("finished")
    sys.setprofile(calls)
    for number, step in enumerate((70.5, 71.0, 71.5)):
        calls.made.clear()
        before, calls.on = len(page.messages), number > 1
        page.session.stage.param.update(scene={"n": 1000.0 + number, "values": {"E": f"{step}"}, "held": True})
        page.run_scheduled(lambda: any(new["kind"] == "skeleton" for new in page.messages[before:]))  # noqa: B023
        calls.on = False
    sys.setprofile(None)
    made = [*dict.fromkeys(calls.made)]
    if arguments.list:
        print("\n".join(f"{file:32}{name}" for file, name in calls.made), file=sys.stderr)
    print(f"{len(made)} functions in {len({file for file, _ in made})} files, {len(calls.made)} calls,", end=" ")
    print(f"{returns(calls.made)} returns to a file already left")
    write(arguments.json, {"functions": made, "calls": len(calls.made), "returns": returns(calls.made)})
    pool.close()


if __name__ == "__main__":
    main()
