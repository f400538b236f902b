"""Continuation of the equilibria of a problem R(v; s) = 0 in its load s, and the slips where branches end.

problem      the contracts, as Protocols: of a problem, and of the methods that advance its states
state        an equilibrium, with what the next increment may use of those before it
compiled     the decorator of compiled functions, and calls of functions by address
vectors      compiled functions of vectors, and the loop of Anderson steps
anderson     secant (Anderson) acceleration of a fixed point
corrector    from a guess to the equilibrium, at fixed load or at fixed arc length
rest         whether an equilibrium is stable under the motion; if not, which mode grows, and how fast
inverse      solves with the tangent of an equilibrium; spaces in which modes are looked for
fold         the end of a branch where its load has a maximum: found near a guess, with both null vectors
onset        the end of a branch where a mode begins to grow, without a fold
arc          points along the arc of a branch
branch       a branch continued to the load asked for, or to its end before that
motion       time steps of the damped motion
quasistatic  the stepper that puts these together; gfmd: the stepper that knows nothing but the motion
transient    the motion from the end of a branch until Anderson steps finish it
landing      the equilibrium in which a slip lands, and whether that depends on details of the motion
trace        what a run has passed: branches, states between theirs, ends, and its period once it repeats itself
replay       an increment by a stepper, or by known states, moved on by lattice periods

Nothing here knows of contacts: tests run it on problems of one and two unknowns.
"""

# Raised by each change after which a run may have other events, states or counts of evaluations: docs/evidence.md is
# older than the solver where its entries have a smaller number
NUMERICS = 5
