"""Compares the last predicted picture of a drag with the exact run that replaces it."""

import logging
from math import isfinite

from app.service import metrics
from app.service.following import AGREE_F, AGREE_U, SHOWN, compared
from app.service.pool import LATER
from app.service.requests import Requests

log = logging.getLogger("app")
OFF = "What was shown while the slider moved"  # a note begins with it


class Comparison(Requests):
    """The comparisons of one visitor. Every method runs under the lock of the document."""

    def compare(self, skeleton, scene, blocks):
        """Compare the Skeleton of a picture with the packed exact run of the same scene."""
        self.ask((compared, skeleton, tuple(blocks)), lambda off: self._report(off, scene), rank=LATER)

    def _report(self, off, scene):
        """Count the outcome, and show a note if the picture was off."""
        if off is None:
            return
        off_U, off_F = off
        agreed = off_U <= AGREE_U and off_F <= AGREE_F
        metrics.count("agreed" if agreed else "disagreed")
        if not agreed:
            where = {name: getattr(scene, name) for name in SHOWN}
            log.info("a followed run was off: slips by %.2g nm, F by %.2g of its largest, %s", off_U, off_F, where)
            if self.session.scene == scene:
                how = f"by {off_U:.2g} nm at a slip" if isfinite(off_U) else "by a slip more or less"
                self.session.notes = [f"{OFF} was off {how}; the exact run has taken its place."]
                self.session.publish()
