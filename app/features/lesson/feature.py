"""Classes that answer: the visitors of one code; the first one is the teacher, who leads. Needs tour.

A class has one question at a time: a stop of the tour, or one that the teacher has written in the address. Each student
has one vote for it. A class has no names, and nothing of it is kept when its last visitor has left.
"""

import re
from dataclasses import dataclass, field
from typing import Any

from app import interface
from app.session import controls, orders
from app.session.orders import order
from solver import LIMITS

STUDENTS = 100  # of a class
CODE = re.compile(r"[A-Z]{4}")
PHASES = "ask", "shown", "run"  # students answer; their answers are on the teacher's screen; the run decides
ANSWERS = 3  # of a question
ROLES = "student", "teacher"
ASKED = "F_s", "U_s", "A_s", "L_s"  # what a teacher's own question may be about

_classes: dict[str, "Class"] = {}  # by code
_several = False  # whether this process is one of --num-procs


@dataclass(eq=False)
class Class:
    """The visitors of one code, and the question they are at; votes: {visitor: number of the answer}.

    secret: of the browser of the teacher, who may come back with it. asked: number of questions so far.
    """

    code: str
    secret: str = ""
    teacher: "Feature | None" = None
    students: set["Feature"] = field(default_factory=set)
    stop: dict[str, Any] = field(default_factory=dict)
    votes: dict["Feature", int] = field(default_factory=dict)
    asked: int = 0

    def send(self, *others: "Feature") -> None:
        """Send the state of the class to the teacher, and to other visitors."""
        for visitor in {*others, self.teacher} - {None}:
            visitor.send_soon()  # type: ignore[union-attr]


class Feature(interface.Feature):
    """The part of one visitor in a class."""

    PAGE = True
    ORDER = 25
    PARAMS = {
        "lesson": "the class of this visitor: code, stop, phase, answered, counts",
        "join": "join a class: code, secret, was (role before)",
        "lead": "take a class to a stop: stop, phase, ask, change",
        "vote": "a student's answer: answer",
    }
    KEEPS = frozenset({"class", "ask", "change"})

    def __init__(self, session: Any) -> None:
        super().__init__(session)
        self.of: Class | None = None
        self.due = False  # whether the state of the class is about to be sent

    @classmethod
    def begin(cls, several: bool) -> None:
        """Remember whether this is one of several processes: each would have a class of the same code."""
        global _several
        _several = several

    def close(self) -> None:
        self.leave()

    @property
    def leads(self) -> bool:
        """Whether this visitor is the teacher."""
        return self.of is not None and self.of.teacher is self

    @order("join", code=orders.is_text, secret=orders.is_text, was=ROLES.__contains__)
    def join(self, code: str, secret: str, was: str = "") -> None:
        """Join the class with a code, as its teacher if it has none yet or if that one comes back.

        secret: of the browser; was: the role of this page before it was loaded again. A student never leads.
        """
        if self.of or not secret or not CODE.fullmatch(code):
            raise orders.Refused
        if _several:
            text = f"Class {code} cannot open: this server has several processes, and each would have its own"
            self.session.notes = [f"{text} class {code}. Start it without --num-procs."]
            return
        found = _classes.setdefault(code, Class(code))
        free = found.teacher is None or was == "teacher"  # its last page may not have left yet
        if was != "student" and free and found.secret in ("", secret):
            found.teacher, found.secret = self, secret
        elif len(found.students) < STUDENTS:
            found.students.add(self)
        else:
            self.session.notes = [f"Class {code} has {STUDENTS} students. Open another code."]
            return
        self.of = found
        found.send(self, *(found.students if found.teacher is self else ()))

    @order("lead", stop=orders.is_whole, phase=PHASES.__contains__, ask=ASKED.__contains__, change=orders.are_entries)
    def lead(self, stop: int, phase: str, ask: str = "", change: Any = None) -> None:
        """Take the class to a stop of the tour, or to the next phase there; only the teacher may.

        ask, change: the teacher's own question: what a change of parameters {name: text} does to a first slip.
        """
        if self.of is None or not self.leads:
            raise orders.Refused
        if phase != "ask":
            self.of.stop = self.of.stop | {"phase": phase}
        elif not ask or self._can_be_asked(change):
            self.of.votes.clear()
            self.of.asked += 1
            self.of.stop = {"asked": self.of.asked, "stop": stop, "phase": phase}
            if ask:
                base = controls.address_of(self.session.scene, self.session.preset)
                self.of.stop |= {"ask": ask, "change": change, "base": base}
        self.of.send(*self.of.students)

    def _can_be_asked(self, change: Any) -> bool:
        """Whether the scene at hand can be changed so; if not, a note names the value."""
        words = ", ".join(f"{name}:{value}" for name, value in (change or {}).items())
        if not change or not change.keys() <= LIMITS.keys():
            why = "allowed: numbers of parameters, as in change=phi_ratio:0.5"
        else:
            _, errors = controls.changed_scene(self.session.scene, change)
            why = " ".join(errors.values())
        self.session.notes = [f"change = {words or 'nothing'}: {why}"] if why else []
        return not why

    @order("vote", answer=orders.is_whole)
    def vote(self, answer: int) -> None:
        """Count the answer of a student: one for each question, and none once the answers are shown."""
        if self.of is None or self.leads or answer >= ANSWERS:
            raise orders.Refused
        if self not in self.of.votes and self.of.stop.get("phase") == "ask":
            self.of.votes[self] = answer
            self.of.send()

    def send_soon(self) -> None:
        """Send the state of the class under the lock of this visitor's document, once for many votes."""
        if not self.due:
            self.due = True
            self.session.later(self._send)

    def _send(self):
        """Send the state; how many chose each answer only to the teacher, once the answers are shown."""
        self.due = False
        if self.of is None:
            return
        content = {"code": self.of.code, "leads": self.leads, "led": self.of.teacher is not None} | self.of.stop
        if self.leads:
            votes = list(self.of.votes.values())
            shown = self.of.stop.get("phase") != "ask"
            content |= {"here": len(self.of.students), "answered": len(votes)}
            content |= {"counts": [votes.count(k) for k in range(ANSWERS)] if shown else None}
        self.session.send("lesson", **content)

    def leave(self) -> None:
        """Leave the class with this visitor's vote."""
        left, self.of = self.of, None
        if left is None:
            return
        left.students.discard(self)
        left.votes.pop(self, None)
        if left.teacher is self:
            left.teacher = None
            left.send(*left.students)
        if left.teacher is None and not left.students:
            _classes.pop(left.code, None)
        left.send()
