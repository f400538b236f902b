"""Error over run time and force evaluations, by the solver and the paper's GFMD. Needs lab."""

TITLE, ORDER = "Accuracy", 4
