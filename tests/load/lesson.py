"""A class that answers, scripted: are all votes counted, how soon do students see the teacher's stop, what does a vote
cost the server?

`python tests/load/lesson.py [--students 30] [--stops 9] [--json FILE]` starts the server itself, on loopback. At each
stop every student votes; one hostile student votes 1,000 times more and sends orders of a teacher. One client process
plays all of them, so times have its share of the processor in them.
"""

import argparse
import asyncio
import time

from client import Server, Tab, summary, tell, told

FORGED = {"do": "lead", "stop": 9, "phase": "run"}
VOTES = 1000  # of the hostile student


class Pupil(Tab):
    """A visitor of the class; `lesson` is its last state, as the browser gets it."""

    async def join(self, changed):
        """Open the page of a class, and listen from now on; changed: a condition that each news notifies."""
        await self.arrive("?class=ABCD&u_x_max=1")
        self.lesson, self.changed = {}, changed
        await self.give({"do": "hello"})
        await self.give({"do": "join", "code": "ABCD", "secret": f"browser {id(self)}"})
        self.listens = asyncio.create_task(self._listen())
        await self.sees(lambda lesson: lesson)

    async def _listen(self):
        while True:
            try:
                message = await self.message("PATCH-DOC")
            except ConnectionError:  # it has left
                return
            for what, news in told(message):
                if what == "lesson":
                    self.lesson = news
                    async with self.changed:
                        self.changed.notify_all()

    async def sees(self, condition):
        """Wait until the state of the class fulfils a condition; the time then."""
        async with self.changed:
            await asyncio.wait_for(self.changed.wait_for(lambda: condition(self.lesson)), 60.0)
        return time.perf_counter()


async def lesson(server, options):
    """Everything measured, as a dictionary."""
    changed = asyncio.Condition()
    teacher, *students, hostile = (Pupil(server.port, k) for k in range(options.students + 2))
    for pupil in (teacher, *students, hostile):
        await pupil.join(changed)
    counted, waits, spent, given = [], [], 0.0, 0
    for stop in range(1, options.stops + 1):
        begun = time.perf_counter()
        await teacher.give({"do": "lead", "stop": stop, "phase": "ask"})
        at = await asyncio.gather(*(student.sees(lambda it: it.get("stop") == stop) for student in students))  # noqa: B023
        waits += [one - begun for one in at]
        before = server.processor_time()
        for k, student in enumerate(students):
            await student.give({"do": "vote", "answer": k % 3})
        await teacher.sees(lambda it: it["answered"] >= options.students)
        spent, given = spent + server.processor_time() - before, given + options.students
        for _ in range(VOTES // options.stops):
            await hostile.give({"do": "vote", "answer": 2})
            await hostile.give(FORGED)
        await teacher.sees(lambda it: it["answered"] == options.students + 1)
        await teacher.give({"do": "lead", "stop": stop, "phase": "shown"})
        await teacher.sees(lambda it: it.get("counts"))
        counted.append(sum(teacher.lesson["counts"]))
    for pupil in (teacher, *students, hostile):
        pupil.listens.cancel()
        pupil.leave()
    return {
        "students": options.students,
        "votes counted at each stop": counted,
        "of one hostile student": [count - options.students for count in counted],
        "s until students see a stop": summary(waits),
        "ms of the server a vote": round(1e3 * spent / given, 2),
        "tracebacks": server.tracebacks(),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--students", type=int, default=30, help="at most 99")
    parser.add_argument("--stops", type=int, default=9, help="at most 9")
    parser.add_argument("--json", help="file for what was measured")
    options = parser.parse_args()
    options.students, options.stops = min(options.students, 99), min(options.stops, 9)
    with Server() as server:
        report = asyncio.run(lesson(server, options))
    tell(report, options.json)


if __name__ == "__main__":
    main()
