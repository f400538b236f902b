"""Numbers: the increment on screen with its units, also for those who hear the page."""

ALONE = True
