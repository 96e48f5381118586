"""gsenv behind the common interface."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gsenv.solver
from gsenv.solver import Options, World
from gsenv.solver.jit import source_digest
from gsenv.solver.records.model import Model

from ..trajectory import STATE, STATE3
from . import Setting

Array = NDArray[np.float64]


def version() -> str:
    """Changes with every edit of the solver."""
    return source_digest((Path(gsenv.solver.__file__).parent,))[:12]


class Simulation:
    """A World of one scene; one call takes any number of steps."""

    def __init__(self, model: Model, setting: Setting) -> None:
        self.world = World(model, options=Options(timestep=setting.timestep, **setting.values))
        self.world.step(0)  # makes the work space: part of building
        self.step = self.world.step

    def read(self) -> Array:
        bodies = self.world.state.bodies[0]
        out = np.empty((len(bodies), STATE))
        out[:, 0:2] = bodies["position"]
        out[:, 2] = bodies["angle"]
        out[:, 3:6] = bodies["velocity"]
        return out


class Simulation3D(Simulation):
    """The same of a spatial scene."""

    def read(self) -> Array:
        bodies = self.world.state.bodies[0]
        out = np.empty((len(bodies), STATE3))
        out[:, 0:3] = bodies["position"]
        out[:, 3:7] = bodies["rotation"]
        out[:, 7:13] = bodies["velocity"]
        return out
