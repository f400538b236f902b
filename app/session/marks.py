"""The marks beside a visitor's sliders: looked for in the background once a run has ended."""

from app.service import marks
from app.service.sweep import Sweep
from solver import SceneError


class Marks:
    """`told`: {slider: ((value, what happens there), ...)} as far as it is known for the scene on screen."""

    def __init__(self, session):
        self.session, self.sweep = session, Sweep(session, self._take)
        self.calls, self.told = [], {}

    def seek(self, scene):
        """Look for the marks that belong to a scene, unless that is done."""
        calls = []
        for name in marks.SLIDERS:
            try:
                key = marks.key(scene, name)
            except SceneError:  # no such run is possible: no marks
                continue
            if key is not None:
                calls.append((marks.of_slider, key, name))
        if calls != self.calls:
            self.sweep.cancel()
            kept = {call[2] for call in calls if call in self.calls}
            self.told = {name: found for name, found in self.told.items() if name in kept}
            self.calls = calls
            self.sweep.add(calls)

    def pause(self):
        """A hand moves: look for nothing more until its run has ended."""
        self.sweep.cancel()
        self.calls = [call for call in self.calls if call[2] in self.told]

    def close(self):
        """Look for nothing any longer."""
        self.sweep.cancel()

    def _take(self, call, found):
        if call in self.calls:
            self.told[call[2]] = () if isinstance(found, Exception) else found
            self.session.publish()
