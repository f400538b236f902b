"""The physics: the NP1 law, the elastic layer, and the surface between them as a problem for `continuation`.

cohesive_law  tractions and tangents of one NP1 spring, and of a node against a row of sites
layer         the layer's stiffness and compliance per Fourier mode, and products with them
contact       the nodes of a patch, with law and layer: tractions, tangents, the layer's response; counts evaluations
equilibrium   that contact as a problem; unknowns: a patch, one node for all, or a patch and the top under a held load
dense         the inverse of an equilibrium's tangent, as a preconditioner
disturbance   small disturbances of an equilibrium and the motion they obey, for the watch on stability
"""
