"""Adhesive contact of an elastic layer with a rigid flat under mixed-mode loading (doi:10.1016/j.jmps.2019.06.010).

Lengths in nm, moduli and tractions in GPa, works of separation in N/m. x runs along the interface, z up; the layer lies
above, its top is moved rigidly by (U_x, -delta). Arrays (2, m) hold x in row 0 and z in row 1.
Tractions are those on the layer: repulsion T_z > 0; F = -sum(T_x) a, L = sum(T_z) a, F_bar = F/(wE), L_bar = L/(wE).
Fourier: numpy's rfft signs and scaling; K_xz = -i K_c, K_zx = +i K_c; q = 0 is the uniform mode; Nyquist uncoupled.
The residual max |U + C T(u) - u| (nm) measures every method.

    for frame in load_path(Scene(delta_bar=0.2)): print(frame.U_x, frame.F_bar, frame.A_bar)
"""

from .carry import carry_on
from .continuation.state import NotConverged
from .frame import Frame, SlipEvent
from .loadpath import METHODS, Checkpoint, advance, load_path, summarize, whole_surface
from .measured import ProfileError, read_profile
from .scene import CHOICES, LIMITS, SURFACES, Scene, SceneError, scene_from_text
from .surface import Profile
from .work import Work, work_of

__version__ = "0.1.0"
__all__ = [
    "CHOICES",
    "LIMITS",
    "METHODS",
    "SURFACES",
    "Checkpoint",
    "Frame",
    "NotConverged",
    "Profile",
    "ProfileError",
    "Scene",
    "SceneError",
    "SlipEvent",
    "Work",
    "__version__",
    "advance",
    "carry_on",
    "load_path",
    "read_profile",
    "scene_from_text",
    "summarize",
    "whole_surface",
    "work_of",
]
