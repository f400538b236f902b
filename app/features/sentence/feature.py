"""The live sentence: what happens, and what the last change has done, in plain words and true numbers."""

ORDER = 30
ALONE = True
