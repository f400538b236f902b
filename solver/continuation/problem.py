"""The contract between the methods of this folder and what they are applied to.

A problem is an equilibrium R(v; s) = 0 in unknowns v (size,) under a load s that enters R as a constant, together with
a motion whose rests the equilibria are. `mechanics.equilibrium` and tests/toys.py fulfil it. It must offer:

1.  `size`, `unit` (the length over which the interaction changes), `tolerance` (of max |R|) and `evaluations`, a count
    that each force evaluation adds one to.
2.  `residual(v, active, s, out)`: fill out (size,) with R, return its largest magnitude. Only `active` nodes interact.
3.  `direction`: dR/ds, (size,), constant.
4.  `active_of(v, s)`: the nodes that interact in v; `admitted(v, active, settled)`: `active` itself while no node has
    clearly crossed the edge, else a new set in which those of `settled` stay as they are.
5.  `smoother(v, active)`: None, or an approximation of the inverse of -dR/dv for what secants do not know.
    `inverse(v, active)`: a function close to that inverse, or None where that would be dear.
6.  `crowded(v, active, s)`: whether more unknowns are needed; then `grown(v, active, s)` gives (problem, v, active);
    and so where `hides(v, active)`: modes grow that these unknowns do not show.
7.  `tangent(v, active)`: the function w -> dR/dv w, each (size,). `oriented(mode)`: the mode with the sign in which a
    start that does not rest is left. `translated(v, distance)`: v moved on, if the problem repeats itself so.
    `place`: whatever tells what v describes, for those who read a slip later.
8.  `motion()`: the Dynamics below.

Dynamics: u'' = K (U - u) + T(u) - gamma u' in coordinates y, complex (2, modes), in which K is diagonal but for 2 x 2
blocks [[xx, -i c], [i c, zz]] per mode, given as rows xx, zz, c of (3, modes). It must offer:

9.  `stiffness` (3, modes) and `critical`, the friction gamma that is critical for the slowest mode; `top(s)`, U (2,).
10. `start(v, active, s)`: y at rest; `unknowns(y, s)`: v of y; `displacement(y)`: the lengths, nm, in y.
11. `force(y, active)`: T in the same coordinates, a buffer; counts as an evaluation.
12. `interface(v, active)`: the largest stiffness of the interaction in v, a bound on dT/du by row sums.
13. `disturbance(v, active)`: the Maps below, of one equilibrium at a time.

Maps: a small disturbance x, N real numbers in coordinates in which every mode has unit mass and their inner product is
Euclid's, obeys x'' = (J - K) x - gamma x'. They must offer:

14. `size` N; `product(x)`, (J - K) x, a new array; `seen(x)`: its unknowns (size,).
    That is enough up to `stability.LIMITS.dense` numbers. Beyond it:
15. `load(f)`: what a force f (N,) adds to R, (size,); `spread(w, f)`: x (N,) at rest with unknowns w under the force f.
16. `flutter(critical)`: the damping, over `critical`, above which no mode but those near zero can be complex and grow;
    for `flutter.deep` where that is more than the motion has: `stiffness`; `stiffest`, its largest; `interface`, the
    largest of |J|; `asymmetry`, of |J_xz - J_zx|/2; `filtered(x, blocks)`: x through blocks like the stiffness's.
"""
