"""Adhesive contact of an elastic layer with a rigid flat under mixed-mode loading (doi:10.1016/j.jmps.2019.06.010).

Lengths in nm, moduli and tractions in GPa, works of separation in N/m. x runs along the interface, z up; the layer lies
above, its top is moved rigidly by (U_x, -delta). Arrays (2, m) hold x in row 0 and z in row 1.
Tractions are those on the layer: repulsion T_z > 0; F = -sum(T_x) a, L = sum(T_z) a, F_bar = F/(wE), L_bar = L/(wE).
Fourier: numpy's rfft signs and scaling; K_xz = -i K_c, K_zx = +i K_c; q = 0 is the uniform mode; Nyquist uncoupled.
The residual max |U + C T(u) - u| (nm) measures every method.

    for frame in load_path(Scene(delta_bar=0.2)): print(frame.U_x, frame.F_bar, frame.A_bar)

scene (schema), surfaces, profile, presets  what is computed: parameters with ranges, shapes, files, named scenes
text            the one reader of parameters given as text
mechanics/      the physics: NP1 law, elastic layer, contact
continuation/   branches of equilibria, their ends, the motion between them; knows nothing of contacts
run/            load steps, increments, frames
following/      a run followed to other parameters, as a branch is to the next load
cautions        when a result depends on a choice
cli, mapping, derivatives, reports, command, files    the command line and what it writes
isolated, cluster                           calls with a deadline in processes of their own, or on a cluster
threads                                     one thread of linear algebra while something is computed
analysis/  validation/    not needed to run anything: stress inside, derivatives and fits; checks against independent
                          calculations, error against run time
"""

from .analysis.energy_balance import Work, work_of
from .continuation.state import NotConverged
from .following.branch import NotFollowed
from .following.follow import follow
from .following.from_frames import skeleton_from, skeleton_of
from .following.skeleton import Skeleton
from .profile import ProfileError, read_profile
from .run.carry import carried_path, carry_on
from .run.frame import Frame, SlipEvent
from .run.loadpath import METHODS, Checkpoint, load_path
from .run.slices import advance
from .run.summary import summarize, whole_surface
from .scene import CHOICES, LIMITS, SURFACES, Scene, SceneError
from .surfaces import Profile
from .text import scene_from_text

__version__ = "0.1.0"
__all__ = [
    "CHOICES",
    "LIMITS",
    "METHODS",
    "SURFACES",
    "Checkpoint",
    "Frame",
    "NotConverged",
    "NotFollowed",
    "Profile",
    "ProfileError",
    "Scene",
    "SceneError",
    "Skeleton",
    "SlipEvent",
    "Work",
    "__version__",
    "advance",
    "carried_path",
    "carry_on",
    "follow",
    "load_path",
    "read_profile",
    "scene_from_text",
    "skeleton_from",
    "skeleton_of",
    "summarize",
    "whole_surface",
    "work_of",
]
