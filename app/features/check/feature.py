"""Check: whether a device does what the page needs, in words that can be photographed."""

PAGE = True
KEEPS = frozenset({"check"})
