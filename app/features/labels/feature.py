"""Labels over the punch: forces, friction, contact, and how far its edges have peeled."""

ORDER = 3
ALONE = True
