"""The readings of a scene's sensors."""

from __future__ import annotations

import numpy as np

from ..core import sensor_readings
from ..core.rays import surroundings
from ..dimension import dimension
from ..records.model import Array, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..records.sensors import JOINT, ray_dtype
from ..records.state import State


def read_sensors(
    model: Model, parameters: ParameterArrays, state: State, timestep: float, first: int, last: int
) -> Array:
    """Return the readings (world, number) of the sensors first .. last - 1 in columns; ``timestep`` in s."""
    sensors = model.sensors[first:last]
    out = np.zeros((len(state.worlds), int(sensors["count"].sum())))
    if (sensors["kind"] != JOINT).any():
        seen = fan = None
        if len(model.sensor_rays):
            seen = surroundings(model, parameters, state)
            fan = as_records(np.zeros(int(sensors["count"].max()), ray_dtype(model.dim)))
        arrays = (state.worlds, state.bodies, state.contacts, parameters.bodies, parameters.worlds)
        states = sensor_readings.States(*(as_records(array) for array in arrays))
        motions = as_records(state.motions)
        sensor_readings.read_sensors(out, timestep, as_records(sensors), states, motions, model.sensor_rays, seen, fan)
    for sensor in sensors[sensors["kind"] == JOINT]:
        column, joint = int(sensor["column"] - sensors[0]["column"]), int(sensor["joint"])
        reading = out[:, column : column + int(sensor["count"])]
        dimension(model.dim).sensor_readings.read_joint(reading, model, parameters, state, timestep, joint)
    return out
