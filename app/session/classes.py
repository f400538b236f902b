"""Classes that answer: the visitors whose address has the same code. The first one is the teacher, who leads.

A class has one question at a time: a stop of the tour, or one that the teacher has written in the address. Each student
has one vote for it. A class has no names, and nothing of it is kept when its last visitor has left.
"""

import re
import secrets
from dataclasses import dataclass, field
from typing import Any

from app.session import orders
from app.session.controls import address_of
from app.session.orders import order

STUDENTS = 100  # of a class
CODE = re.compile(r"[A-Z]{4}")
PHASES = "ask", "shown", "run"  # students answer; their answers are on the teacher's screen; the run decides
ANSWERS = 3  # of a question
ASKED = "F_s", "U_s", "A_s", "L_s"  # what a teacher's own question may be about

_classes: dict[str, "Class"] = {}  # by code


@dataclass(eq=False)
class Class:
    """The visitors of one code, and the question they are at; votes: {visitor: number of the answer}."""

    code: str
    secret: str = field(default_factory=lambda: secrets.token_urlsafe(9))  # with which the teacher may come back
    teacher: "Attendance | None" = None
    students: set["Attendance"] = field(default_factory=set)
    stop: dict[str, Any] = field(default_factory=dict)
    votes: dict["Attendance", int] = field(default_factory=dict)
    asked: int = 0  # questions so far

    def tell(self, *others: "Attendance") -> None:
        """Send the state of the class to the teacher, and to other visitors."""
        for visitor in {*others, self.teacher} - {None}:
            visitor.tell_soon()  # type: ignore[union-attr]


class Attendance:
    """The part of one visitor in a class. Every method runs under the lock of the visitor's document."""

    def __init__(self, session: Any) -> None:
        self.session = session
        self.of: Class | None = None
        self.due = False  # whether the state of the class is about to be sent

    @property
    def leads(self) -> bool:
        """Whether this visitor is the teacher."""
        return self.of is not None and self.of.teacher is self

    @order("join", code=orders.is_text, secret=orders.is_text)
    def join(self, code: str, secret: str = "") -> None:
        """Join the class with a code: as its teacher if it is new, or with the teacher's secret."""
        if self.of or not CODE.fullmatch(code):
            raise orders.Refused
        leads = code not in _classes
        found = _classes.setdefault(code, Class(code))
        if leads or secrets.compare_digest(secret.encode(), found.secret.encode()):  # a page opened anew comes back
            found.teacher = self
        elif len(found.students) < STUDENTS:
            found.students.add(self)
        else:
            self.session.notes = [f"Class {code} has {STUDENTS} students. Open another code."]
            return
        self.of = found
        found.tell(self)

    @order("lead", stop=orders.is_whole, phase=PHASES.__contains__, ask=ASKED.__contains__, change=orders.are_entries)
    def lead(self, stop: int, phase: str, ask: str = "", change: Any = None) -> None:
        """Take the class to a stop of the tour, or to the next phase there; from others than the teacher it is refused.

        ask, change: the teacher's own question: what a change of parameters {name: text} does to a first slip.
        """
        if not self.leads:
            raise orders.Refused
        assert self.of is not None
        question = {"ask": ask, "change": change or {}} if ask else {}
        if phase == "ask":
            self.of.votes.clear()
            self.of.asked += 1
            base = address_of(self.session.scene, self.session.preset) if ask else {}
            self.of.stop = {"asked": self.of.asked, "stop": stop, "base": base} | question
        self.of.stop = self.of.stop | {"phase": phase}
        self.of.tell(*self.of.students)

    @order("vote", answer=orders.is_whole)
    def vote(self, answer: int) -> None:
        """Count the answer of a student: one for each question, and none once the answers are shown."""
        if self.of is None or self.leads or answer >= ANSWERS:
            raise orders.Refused
        if self not in self.of.votes and self.of.stop.get("phase") == "ask":
            self.of.votes[self] = answer
            self.of.tell()

    def tell_soon(self) -> None:
        """Send the state of the class under the lock of this visitor's document, once for many votes."""
        if not self.due:
            self.due = True
            self.session.later(self._tell)

    def _tell(self):
        """Send the state; how many chose each answer only to the teacher, once the answers are shown."""
        self.due = False
        if self.of is None:
            return
        content = {"code": self.of.code, "leads": self.leads} | self.of.stop
        if self.leads:
            votes = list(self.of.votes.values())
            shown = self.of.stop.get("phase") != "ask"
            content |= {"secret": self.of.secret, "here": len(self.of.students), "answered": len(votes)}
            content |= {"counts": [votes.count(k) for k in range(ANSWERS)] if shown else None}
        self.session.send("class", **content)

    def leave(self) -> None:
        """Leave the class with this visitor's vote."""
        left, self.of = self.of, None
        if left is None:
            return
        left.students.discard(self)
        left.votes.pop(self, None)
        if left.teacher is self:
            left.teacher = None
        if left.teacher is None and not left.students:
            _classes.pop(left.code, None)
        left.tell()
