"""Two processes compute the line of static friction.

A sweep takes any executor of `concurrent.futures`. Here two processes compute eight first slips, from tension to
compression. Friction force over contact area is a straight line (Eq. 9 of the paper), with R² = 0.998.
"""

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np

from solver import Scene, sweep

values = {"delta_bar": np.linspace(-0.1, 0.6, 8).round(2).tolist()}
if __name__ != "__mp_main__":  # a started process imports the script under this name, and must not start others
    with ProcessPoolExecutor(2, get_context("spawn")) as executor:
        table = sweep(Scene(), executor, **values)
    area, force = table["A_s (nm)"], table["F_s (N/m)"]
    number = float(np.corrcoef(area, force)[0, 1] ** 2)


def draw(ax):
    """F_s over A_s, and the line of least squares."""
    ax.plot(area, force, "o", label="first slips")
    ax.plot(area, np.polyval(np.polyfit(area, force, 1), area), label="F_s = tau A_s + F_0")
    ax.set(xlabel="A_s (nm)", ylabel="F_s (N/m)")
    ax.legend()
