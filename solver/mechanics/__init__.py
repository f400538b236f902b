"""The physics: the cohesive laws, the elastic layer, and the surface between them as a problem for `continuation`.

cohesive_law  tractions and tangents of a spring, and of nodes against all lattice sites in the window
kernels       compiled functions of law, layer, residual and force, and calls of the latter by address
fftw          plans of FFTW that compiled code can execute
layer         stiffness and compliance of the layer per Fourier mode, and products with them
contact       a patch of nodes with law and layer: tractions, tangents, response; counts force evaluations
equilibrium   the contact as a problem; under a held load the height of the top is one more unknown
surface       the transient of the whole surface, whose rests are the equilibria
linearised    an equilibrium linearised: dT/du, the layer, and dR/dv
flutter       the damping above which waves of the contact cannot flutter, by a local criterion
"""
