"""The physics: the NP1 law, the elastic layer, and the surface between them as a problem for `continuation`.

cohesive_law  tractions and tangents of one NP1 spring, and of a node against a row of sites
layer         the layer's stiffness and compliance per Fourier mode, and products with them
contact       the nodes of a patch, with law and layer: tractions, tangents, the layer's response; counts evaluations
equilibrium   that contact as a problem; unknowns: a patch, or one node for all
load_control  a held normal load, wrapped around such a problem; one more unknown: the height of the top
surface       the motion of the whole surface, whose rests are the equilibria
linearised    an equilibrium linearised: dT/du, the layer, and both together, in small disturbances of the surface
flutter       the damping above which waves of the contact cannot flutter, by a local criterion
dense         the inverse of an equilibrium's tangent, as a preconditioner
"""
