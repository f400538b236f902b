"""The contract between the methods of this folder and what they are applied to.

A problem is an equilibrium R(v; s) = 0 in unknowns v (size,) under a load s, in which R is linear, together with a
motion whose rests are the equilibria. `mechanics.equilibrium` and tests/toys.py fulfil the contract. It must offer:

1.  `size`, `unit` (the length over which the interaction changes), `tolerance` (of max |R|) and `evaluations`, a count
    that each force evaluation adds one to.
2.  `residual(v, active, s, out)`: fill out (size,) with R, return its largest magnitude. Only `active` nodes interact.
3.  `direction`: dR/ds, (size,), constant.
4.  `undeformed(s)`: v if nothing interacts. `active_of(v, s)`: the nodes that interact in v; `admitted(v, active,
    settled)`: `active` itself while no node has clearly crossed the edge of the interaction, else a new set in which
    those of `settled` stay as they are.
5.  `smoother(v, active)`: None, or a rough inverse of -dR/dv, for the part of a residual that no secant pair knows.
    `inverse(v, active)`: a function close to that inverse, or None where forming it would take too long.
6.  `crowded(v, active, s)`: whether more unknowns are needed; `hides(v, active)`: whether modes grow that these
    unknowns cannot show. In both cases `grown(v, active, s)` gives (problem, v, active) with more unknowns.
7.  `tangent(v, active)`: the function w -> dR/dv w, each (size,). `oriented(mode)`: the mode with the sign in which the
    motion shall leave a state that does not rest. `translated(v, distance)`: v moved on by a period of the problem.
    `place`: whatever tells later which unknowns the v of a slip held.
8.  `motion()`: the Dynamics below.

Dynamics: u'' = K (U - u) + T(u) - gamma u' in coordinates y, complex (2, modes), in which K is diagonal but for 2 x 2
blocks [[xx, -i c], [i c, zz]] per mode, given as rows xx, zz, c of (3, modes). It must offer:

9.  `stiffness` (3, modes) and `critical`, the friction gamma that is critical for the slowest mode; `top(s)`, U (2,).
10. `start(v, active, s)`: y at rest; `unknowns(y)`: v of y; `displacement(y)`: the displacements, nm, of y.
11. `force(y, active)`: T in the same coordinates, a buffer; counts as an evaluation.
12. `interface(v, active)`: the largest stiffness of the interaction in v, a bound on dT/du by row sums.
13. `disturbance(v, active)`: the Maps below, valid until the next call.

Maps: a small disturbance x, N real numbers in coordinates in which every mode has unit mass and their inner product is
Euclid's, obeys x'' = (J - K) x - gamma x'. They must offer:

14. `size` N; `product(x)`, (J - K) x, a new array; `seen(x)`: the unknowns (size,) of x.
    No more is needed up to N = `stability.LIMITS.dense`. Beyond:
15. `load(f)`: what a force f (N,) adds to R, (size,); `spread(w, f)`: the x (N,) that rests, with unknowns w, under f.
16. `alike()`: whether every mode is a wave. If so, `waves()`: mu (waves, 2) and amplitudes (waves, 2, 2) in columns of
    all of them, and `wave(q, amplitude)`: the x of one, complex.
17. `flutter(critical)`: the damping, over `critical`, above which no mode with mu far from zero can grow. Where the
    motion has less, `flutter.deep` needs `stiffness`; `stiffest`, its largest; `interface`, the largest |J|;
    `asymmetry`, the largest |J_xz - J_zx|/2; `filtered(x, blocks)`: every mode of x times its block, as of `stiffness`;
    `of_patch()`: (mu, modes in columns) of the `patch_size` numbers of x where J is not zero, the others held still;
    `embedded(mode)`: such a mode (patch_size,) as x; `shifted(mu)`: the function f -> x with (J - K - mu) x = f.
"""
