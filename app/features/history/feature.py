"""History: the address names scene and increment, and Back goes to the change before."""

PAGE = True
ORDER = 5
KEEPS = frozenset({"k"})
