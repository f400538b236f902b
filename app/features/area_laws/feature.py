"""Contact area over friction up to the onset of sliding (paper Fig. 8, Eqs. 8, 9). Needs lab."""

TITLE, ORDER = "Area laws", 2
