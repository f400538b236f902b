"""The maps of the page: their axes, and the grid of points around a scene."""

from solver import Scene
from solver.analysis.maps import Axis, Map

COLUMNS, ROWS = 33, 25
AXES = {  # axes to choose from: label, low, high, whether logarithmic, ticks
    "delta_bar": ("press depth δ/δ₀", -0.8, 1.0, False, (-0.8, -0.6, -0.4, -0.2, 0.0, 0.2, 0.4, 0.6, 0.8, 1.0)),
    "phi_ratio": ("friction / adhesion φₜ/φₙ", 0.01, 2.0, True, (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)),
    "E": ("stiffness E (GPa)", 15.0, 1000.0, True, (20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)),
    "phi_n": ("adhesion φₙ (N/m)", 0.5, 5.0, True, (0.5, 1.0, 2.0, 5.0)),
    "nu": ("Poisson's ratio ν", 0.1, 0.45, False, (0.1, 0.2, 0.3, 0.4)),
}
FIRST = "delta_bar", "phi_ratio"  # axes of a map that is opened


def grid_of(scene: Scene, names: tuple[str, str], path: str) -> Map:
    """Return the Map of a scene over these axes, for any of its values of them; raises SceneError."""
    base = scene.changed(path=path, **{name: AXES[name][1] for name in names})
    counts = zip(names, (COLUMNS, ROWS), strict=True)
    return Map(base, *(Axis(name, *AXES[name][1:3], count, AXES[name][3]) for name, count in counts))
