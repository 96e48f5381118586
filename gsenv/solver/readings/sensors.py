"""The readings of a scene's sensors."""

from __future__ import annotations

import numpy as np

from ..dimension import dimension
from ..records.model import Array, Model
from ..records.parameters import ParameterArrays
from ..records.state import State


def read_sensors(
    model: Model, parameters: ParameterArrays, state: State, timestep: float, first: int, last: int
) -> Array:
    """Return the readings (world, number) of the sensors first .. last - 1 in columns; ``timestep`` in s."""
    sensors = model.sensors[first:last]
    out = np.zeros((len(state.worlds), int(sensors["count"].sum())))
    if len(sensors):
        dimension(model.dim).sensor_readings.read_into(out, model, parameters, state, timestep, sensors)
    return out
