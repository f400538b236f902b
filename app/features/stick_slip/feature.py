"""Friction of flat on flat at zero gap, from runs and in closed form (paper Figs. 4, 5, Eq. 7). Needs lab."""

TITLE, ORDER = "Stick-slip", 1
