"""One experiment: load steps, the path through them, and what is reported of every increment.

loading, load_steps  the path of the top under a load parameter, and the steps of `path` and `hold` in order
loadpath             a run that owns its buffers and gives one Frame after the other; checkpoints
slices               the same, a few frames at a time, from one checkpoint to the next
frame, summary       what an increment reports: u, T, F, L, A, slip events; and a run in a few numbers
carry                going on under other parameters from the state reached
film                 the motion of one slip, state by state
shortcuts            what a scene does not need, and which of it a run left out
"""
