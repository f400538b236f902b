"""Error against run time of the solver. No run needs this package.

compare        the work of a run, and its distance from a reference
measure        runs of one scene over the tolerance and the increment, by `fast` and by the paper's GFMD
report         their meaning in words, tables and plain data
"""
