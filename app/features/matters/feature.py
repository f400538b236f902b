"""What matters: how the first slip changes with each parameter and with the strength of each node. Needs pages."""

ORDER = 15
