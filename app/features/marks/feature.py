"""Marks beside the sliders show where the behaviour changes; a click goes there. All visitors share them."""

from typing import Any

from app import interface
from app.session.controls import NAMES
from solver import Scene, SceneError
from solver.analysis import marks
from solver.following.skeleton import Skeleton
from solver.run.load_steps import lifts

MEANINGS = {  # {slider: what its marks show}
    "delta_bar": "Marks beside the slider show where the surfaces jump into contact, and where no load is needed to"
    " hold the punch.",
    "phi_ratio": "A mark shows above what ratio it slips; below, sliding is smooth.",
    "E": "A mark shows beyond what stiffness sliding is smooth, without slips.",
}


def mark_calls(scene: Scene, skeleton: Skeleton | None) -> dict[str, tuple]:
    """Return {slider: (function, *arguments)} that compute the marks, for a Scene and its Skeleton or None."""
    made: dict[str, tuple] = {}
    if skeleton is not None:
        made = {name: (marks.of_skeleton, skeleton, name) for name in NAMES}
    if scene.surface == "flat" and scene.delta_bar == 0.0 and not lifts(scene):
        made |= {name: (marks.of_flat, scene, name) for name in marks.ENDS}
    return made


def _without(scene, name):
    """Return the scene with a fixed value of a slider: what its marks depend on."""
    try:
        return scene.changed(**{name: 0.0 if name == "delta_bar" else marks.ENDS[name][0]})
    except SceneError:  # the scene does not allow this value
        return scene


class Feature(interface.Feature):
    """The marks of one visitor; `values`: {slider: ((value, label), ...)} of those found so far."""

    def __init__(self, session: Any) -> None:
        super().__init__(session, self._made)
        self.calls, self.keys, self.values = {}, {}, {}

    @classmethod
    def declared(cls, root: str) -> dict[str, Any]:
        return {"mark_meanings": MEANINGS}

    def requested(self, scene: Scene) -> None:
        """Search none until the run has ended."""
        self.cancel()

    def ended(self, run: Any, skeleton: Skeleton | None) -> None:
        """Search the unknown marks of a run."""
        self.cancel()  # a prediction at rest ends in an exact run without another request
        scene = run.scene
        keys = {name: _without(scene, name) for name in NAMES}
        self.values = {name: values for name, values in self.values.items() if values and keys[name] == self.keys[name]}
        calls, self.keys = mark_calls(scene, skeleton), keys
        self.calls = {call: name for name, call in calls.items() if name not in self.values}
        self.add(list(self.calls))

    def status(self) -> dict[str, Any]:
        return {"marks": self.values}

    def _made(self, call, values):
        # a new dictionary, as what was published is compared with it
        self.values = self.values | {self.calls[call]: () if isinstance(values, Exception) else values}
        self.session.publish()
