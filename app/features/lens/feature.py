"""The lens: nodes, lattice sites and springs at the trailing edge, to scale."""

ALONE = True
