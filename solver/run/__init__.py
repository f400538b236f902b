"""One experiment: load steps, the path through them, and what is reported of every increment.

loading, load_steps  the path of the top under a load parameter, and the steps of `path` and `hold` in order
loadpath             a run that owns its buffers and gives one Frame after the other; checkpoints
frame                what an increment reports: F, L, A, edges, slip events
carry                going on from a state under other parameters
shortcuts            what a scene does not need, and what leaving it out saved
"""
