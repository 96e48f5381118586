"""GCar's wedges below see-saws as pictures show them: they stand on the ground, whatever the height of the hinge.

They touch nothing, so only pictures depend on their corners.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.car import scene
from gsenv.solver import World

FULCRA = scene.FIRST_FULCRUM + np.arange(scene.SEESAWS)
TALLEST_CUT = 0.9  # m, of the wedge's 1 m: more is below the ground only of wedges that are parked


def stand_on_ground(world: World, worlds: NDArray[Any]) -> None:
    """Move the lower corners of wedges along their sides up to the ground, in the worlds of the given indices."""
    shapes, parameters = world.model.shapes, world.parameters
    firsts = shapes["vertex_first"][np.isin(shapes["body"], FULCRA)]
    for w in worlds.tolist():
        corners = parameters.vertices["position"][w]
        foot = world.state.bodies["position"][w, FULCRA] - parameters.bodies["center"][w, FULCRA]
        ground = np.interp(foot[:, 0], *corners[: scene.VERTICES].T)
        cuts = np.clip(ground - foot[:, 1], 0.0, TALLEST_CUT)
        for first, cut in zip(firsts.tolist(), cuts.tolist(), strict=True):
            wedge, whole = corners[first : first + 3], world.model.nominal_vertices["position"][first : first + 3]
            low = whole[:, 1] == 0.0
            wedge[low, 0] = (1.0 - cut) * whole[low, 0]
            wedge[low, 1] = cut
