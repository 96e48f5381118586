"""The engine: scenes of rigid bodies, and one sparse solver that makes all their rows true.

Imports numpy and numba only; knows nothing of environments, rewards or drawing.
"""

from .diagnostics import Contacts, Diagnostics
from .model import Model
from .options import Options
from .parameters import Parameters
from .planar.shapes import Box, Capsule, Circle, HalfPlane, Polygon, Terrain
from .problem import ContactRows, Problem, Solution, solve
from .scene import Handle, Scene
from .sensors import RayHits
from .state import Snapshot
from .world import World

__all__ = [
    "Box",
    "Capsule",
    "Circle",
    "ContactRows",
    "Contacts",
    "Diagnostics",
    "HalfPlane",
    "Handle",
    "Model",
    "Options",
    "Parameters",
    "Polygon",
    "Problem",
    "RayHits",
    "Scene",
    "Snapshot",
    "Solution",
    "Terrain",
    "World",
    "solve",
]
