"""The engine: scenes of rigid bodies, and one sparse solver of all their constraint rows.

It imports numpy and numba only, and nothing of environments, rewards or rendering. Shapes, joints and sensors are in
``gsenv.solver.planar`` and ``gsenv.solver.spatial``.
"""

from .api.options import Options
from .api.parameters import Parameters
from .api.world import World
from .problem.problem import ContactRows, Problem, Solution, solve
from .readings.diagnostics import Contacts, Diagnostics
from .readings.rays import RayHits
from .records.model import Model
from .records.state import Snapshot, State
from .specification.handles import Handle
from .specification.scene import Scene

__all__ = [
    "ContactRows",
    "Contacts",
    "Diagnostics",
    "Handle",
    "Model",
    "Options",
    "Parameters",
    "Problem",
    "RayHits",
    "Scene",
    "Snapshot",
    "Solution",
    "State",
    "World",
    "solve",
]
