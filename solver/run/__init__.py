"""One experiment: load steps, the path through them, and the report of every increment.

load_steps           the path of the top under a load parameter: the steps of `path` and `hold` in order
loadpath             a run that owns its buffers and yields its Frames in order, to its end or `until` one; checkpoints
held_load            the indentation at which the approach reaches a load in N/m
slices               the same run, a few frames at a time, from one checkpoint to the next
frame, summary       what an increment reports: u, T, F, L, A, slip events; a run in a few numbers, and what it omitted
film                 the transient of one slip from the Frame before it, state by state
"""
