"""The contact map: normal traction over place and path."""

ORDER = 10
ALONE = True
