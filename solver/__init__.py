"""Adhesive contact of an elastic layer with a rigid flat under mixed-mode loading (doi:10.1016/j.jmps.2019.06.010).

    result = simulate(Scene(delta_bar=0.2))
    print(result.table, result.slips)

Lengths are in nm, moduli and tractions in GPa, works of separation in N/m. x runs along the interface, z up. The layer
lies above; its top is moved rigidly by (U_x, -delta). Arrays (2, m) hold x in row 0 and z in row 1.
Tractions T act on the layer, so repulsion is T_z > 0. Over the node spacing a, the width w and Young's modulus E,
F = -sum(T_x) a, L = sum(T_z) a, F_bar = F/(wE), L_bar = L/(wE).
Fourier fields have the signs and scaling of numpy's rfft: K_xz = -i K_c, K_zx = +i K_c. q = 0 is the uniform mode; the
Nyquist mode is uncoupled. The residual max |U + C T(u) - u| (nm) is the error measure of every method.

What each module and folder holds; none imports from a line below its own:
schema, surfaces                parameters with ranges and choices, shapes of the surface
scene                           the Scene
text, presets                   scenes from text, named scenes
continuation/                   branches of equilibria, their ends, the motion between them, for any problem
mechanics/                      the physics: NP1 law, elastic layer, contact
threads, executors              one BLAS thread, errors as by default; many calls on an executor of `concurrent.futures`
run/                            load steps, increments, Frames, summaries
following/                      a sliding run continued to other parameters
cautions, plots                 sentences on choices that affect a result; plots
analysis/                       derivatives, maps, stress inside the layer, work of the stage, laws of friction
measured/                       files of measured surfaces and curves, comparison with a run, fits
results, sweeps                 a run as tables and plots; the first slips of many scenes
accuracy/                       error against run time of one scene
files                           the files of a run: CSV, NPZ, JSON
cli/                            the command line
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from .analysis.work import work_of
from .continuation.state import NotConverged
from .following.certify import Certificate, certify
from .following.follow import follow
from .following.from_run import skeleton_from, skeleton_of
from .following.moved import NotFollowed
from .following.skeleton import Skeleton
from .results import Result, simulate
from .run.frame import Frame, SlipEvent
from .run.loadpath import METHODS, Checkpoint, load_path
from .run.slices import advance
from .run.summary import summarize, whole_surface
from .scene import CHOICES, LIMITS, SURFACES, Scene, SceneError
from .surfaces import DataError, Profile
from .sweeps import sweep
from .text import scene_from_text

if TYPE_CHECKING:
    from .analysis.boundary import Boundary, boundary
    from .analysis.maps import Axis, Map, explore_map
    from .analysis.sensitivities import sensitivities
    from .analysis.toughness import release_rates, toughness
    from .analysis.unstable import UnstableBranch, unstable_branch
    from .measured.curves import read_measurement
    from .measured.fit import fit
    from .measured.profile import read_profile

__version__ = "0.2.0.dev0"
__all__ = [
    "CHOICES",
    "LIMITS",
    "METHODS",
    "SURFACES",
    "Axis",
    "Boundary",
    "Certificate",
    "Checkpoint",
    "DataError",
    "Frame",
    "Map",
    "NotConverged",
    "NotFollowed",
    "Profile",
    "Result",
    "Scene",
    "SceneError",
    "Skeleton",
    "SlipEvent",
    "UnstableBranch",
    "__version__",
    "advance",
    "boundary",
    "certify",
    "explore_map",
    "fit",
    "follow",
    "load_path",
    "read_measurement",
    "read_profile",
    "release_rates",
    "scene_from_text",
    "sensitivities",
    "simulate",
    "skeleton_from",
    "skeleton_of",
    "summarize",
    "sweep",
    "toughness",
    "unstable_branch",
    "whole_surface",
    "work_of",
]
LAZY = {  # {name: module}, imported when first asked for: a run does not need them
    "Axis": "analysis.maps",
    "Boundary": "analysis.boundary",
    "Map": "analysis.maps",
    "UnstableBranch": "analysis.unstable",
    "boundary": "analysis.boundary",
    "explore_map": "analysis.maps",
    "fit": "measured.fit",
    "read_measurement": "measured.curves",
    "read_profile": "measured.profile",
    "release_rates": "analysis.toughness",
    "sensitivities": "analysis.sensitivities",
    "toughness": "analysis.toughness",
    "unstable_branch": "analysis.unstable",
}


def __getattr__(name: str) -> Any:
    if name not in LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{LAZY[name]}", __name__), name)


def __dir__() -> list[str]:
    return [*globals(), *LAZY]
