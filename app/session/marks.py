"""The marks beside a visitor's sliders: followed in the background once a run has ended."""

from app.service import marks
from app.service.sweep import Sweep


class Marks:
    """`told`: {slider: ((value, what happens there), ...)} as far as it is known for the scene on screen."""

    def __init__(self, session):
        self.session, self.sweep = session, Sweep(session, self._take)
        self.calls, self.keys, self.told = {}, {}, {}

    def seek(self, scene, skeleton):
        """Look for the marks of a scene, whose run left this pickled Skeleton or None, unless they are known."""
        self.sweep.cancel()
        keys = {name: marks.key(scene, name) for name in marks.SLIDERS}
        self.told = {name: found for name, found in self.told.items() if found and keys[name] == self.keys[name]}
        calls, self.keys = marks.calls(scene, skeleton), keys
        self.calls = {call: name for name, call in calls.items() if name not in self.told}
        self.sweep.add(list(self.calls))

    def pause(self):
        """A hand moves: look for nothing more until its run has ended."""
        self.sweep.cancel()

    def close(self):
        """Look for nothing any longer."""
        self.sweep.cancel()

    def _take(self, call, found):
        self.told[self.calls[call]] = () if isinstance(found, Exception) else found
        self.session.publish()
