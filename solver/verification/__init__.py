"""Whether results are right, by code that shares nothing with the solver. Not needed to run anything.

closed_forms, cylinder, wave   problems with known answers, and how close the solver comes
long_double, spectrum          residual in extended precision, and the dense spectrum of the motion, of any frame
conditioning                   how near to round-off each formula is
atlas, robustness, atlas_report  stiff and extreme scenes, their verdicts, and the page that shows them
"""
