"""Evaluations of frames and skeletons. No run needs them.

partial, sensitivities         derivatives of slips and curves by parameters and by nodes
prediction                     the curve of a skeleton, with its derivatives
interior                       stress and displacement inside the layer, mode by mode
friction_laws, area_laws       onset of sliding, critical moduli, force curves of flats; fits of Eqs. 8 and 9
regimes                        scenes of flats over stiffness and strength
cusp, boundary                 where stick-slip ends as a parameter changes
unstable                       the unstable branch that a slip jumps over
marks                          values of a parameter at which the behaviour changes
maps/                          the first slip and its regime over two parameters
peeling                        edges of contact and how far they peeled
toughness                      edges of the contact as crack tips
work                           of the stage
"""
