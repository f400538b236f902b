"""The tour: nine stops, each with a prediction before the run shows its future. Needs pages, history."""

PAGE = True
ORDER = 40
KEEPS = frozenset({"tour"})
