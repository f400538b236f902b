"""The marks beside a visitor's sliders: followed in the background once a run has ended."""

from app.service import marks
from app.service.sweep import Sweep


class Marks(Sweep):
    """`told`: {slider: ((value, what happens there), ...)} as far as it is known for the scene on screen."""

    def __init__(self, session):
        super().__init__(session, self._made)
        self.calls, self.keys, self.told = {}, {}, {}

    def seek(self, scene, skeleton):
        """Look for the marks of a scene, whose run left this pickled Skeleton or None, unless they are known."""
        self.cancel()
        keys = {name: marks.key(scene, name) for name in marks.SLIDERS}
        self.told = {name: found for name, found in self.told.items() if found and keys[name] == self.keys[name]}
        calls, self.keys = marks.calls(scene, skeleton), keys
        self.calls = {call: name for name, call in calls.items() if name not in self.told}
        self.add(list(self.calls))

    def _made(self, call, found):
        self.told[self.calls[call]] = () if isinstance(found, Exception) else found
        self.session.publish()
