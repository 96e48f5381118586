"""Sensors of a model as sensors of a Scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..solver.specification.scene import Scene
from ..solver.specification.sensors import (
    AccelerationSensor,
    ContactForceSensor,
    FrameSensor,
    JointSensor,
    RaySensor,
)
from .errors import Notes
from .frames import Pose
from .model import MjcfModel, Sensor

if TYPE_CHECKING:
    from .build import Names

JOINT = ("jointpos", "jointvel")
BALL = ("ballquat", "ballangvel")
ACTUATOR = ("actuatorpos", "actuatorvel", "actuatorfrc")
AXES = ("framexaxis", "frameyaxis", "framezaxis")
FRAME = ("framepos", "framequat", *AXES, "framelinvel", "frameangvel", "velocimeter", "gyro")
ACCELERATION = ("accelerometer", "framelinacc", "frameangacc")
REACTION = ("force", "torque")
FARTHEST = 1e4  # m, of the ray of a rangefinder
UNSUPPORTED = "sensors of this kind are not supported"
PRINCIPAL = "an orientation is that of the body's own frame, not that of its principal axes"
OF_FILE = "the frame of a mesh is that of its file, not that of its principal axes"


@dataclass(frozen=True, eq=False)
class Reading:
    """Where a sensor of the model is in the scene.

    Attributes:
        name: of the scene's sensor, and of the reading in ``sensor_data``.
        carrier: name of the body of the scene that it is on, or empty.
        pose: of the sensor's frame in its carrier's.
        reference: name of a scene's sensor of the frame that it is relative to, or empty.
        reference_pose: of that frame in its own carrier.
        further: scene's sensors of joints that share the load of the first.
    """

    name: str
    carrier: str = ""
    pose: Pose | None = None
    reference: str = ""
    reference_pose: Pose | None = None
    further: tuple[str, ...] = ()


def add_sensors(scene: Scene, model: MjcfModel, names: Names, notes: Notes) -> None:
    """Add the sensors that a Scene has, and enter each in ``names.sensors``."""
    builder = _Sensors(scene, model, names, notes)
    for k, sensor in enumerate(model.sensors):
        reading = builder.add(sensor, sensor.name or f"{sensor.kind} {k}")
        if reading is None:
            notes.add(UNSUPPORTED, title_of(sensor))
        else:
            names.sensors[k] = reading


def title_of(sensor: Sensor) -> str:
    """Return place, kind and name for messages."""
    return f"{sensor.place}: {sensor.kind}" + (f" {sensor.name!r}" if sensor.name else "")


class _Sensors:
    def __init__(self, scene: Scene, model: MjcfModel, names: Names, notes: Notes) -> None:
        self.scene = scene
        self.model = model
        self.names = names
        self.notes = notes

    def add(self, sensor: Sensor, name: str) -> Reading | None:
        """Add a sensor to the scene; None where a Scene has none of its kind."""
        if sensor.kind in JOINT:
            return self._of_joint(name, sensor.object)
        if sensor.kind in BALL:
            return self._of_ball(name, sensor.object)
        if sensor.kind in ACTUATOR:
            return self._of_actuator(name, sensor.object)
        found = self._frame(sensor.object_kind, sensor.object)
        if found is None:
            return None
        body, carrier, pose = found
        self._note_orientation(sensor, sensor.object_kind, sensor.object)
        reading = Reading(name, carrier, pose)
        position = pose.position
        if sensor.kind in FRAME:
            self.scene.add_sensor(name, FrameSensor(carrier, position=position))
            return self._relative(sensor, reading)
        if sensor.kind in ACCELERATION:
            self.scene.add_sensor(name, AccelerationSensor(carrier, position=position, subtract_gravity=True))
            return reading
        if sensor.kind == "rangefinder":
            ahead = pose.axes[:, 2]
            self.scene.add_sensor(name, RaySensor(carrier, directions=[ahead], length=FARTHEST, position=position))
            return reading
        if sensor.kind == "touch":
            self.scene.add_sensor(name, ContactForceSensor(carrier))
            return reading
        return self._of_load(reading, body) if sensor.kind in REACTION else None

    def _of_joint(self, name: str, joint: str) -> Reading | None:
        number = next((k for k, one in enumerate(self.model.joints) if one.name == joint), -1)
        if number not in self.names.joints:
            return None
        self.scene.add_sensor(name, JointSensor(self.names.joints[number].joint))
        return Reading(name)

    def _of_ball(self, name: str, joint: str) -> Reading | None:
        body = next((one.body for one in self.model.joints if one.name == joint and one.kind == "ball"), -1)
        if body not in self.names.holders:
            return None
        self.scene.add_sensor(name, JointSensor(self.names.holders[body][0]))
        return Reading(name)

    def _of_actuator(self, name: str, actuator: str) -> Reading | None:
        number = next((k for k, one in enumerate(self.model.actuators) if one.name == actuator), -1)
        if number not in self.names.actuators:
            return None
        return self._of_joint(name, self.model.actuators[number].target)

    def _of_load(self, reading: Reading, body: int) -> Reading | None:
        """Add the sensors of all joints that hold a body; a free body has none."""
        if self.model.joints_of(body) == []:
            return None  # part of its parent
        further = []
        for k, joint in enumerate(self.names.holders.get(body, [])):
            further.append(reading.name if k == 0 else f"{reading.name} ({k + 1})")
            self.scene.add_sensor(further[-1], JointSensor(joint))
        return Reading(reading.name, reading.carrier, reading.pose, further=tuple(further))

    def _relative(self, sensor: Sensor, reading: Reading) -> Reading:
        """Add a sensor of the frame that another is relative to."""
        found = self._frame(sensor.reference_kind, sensor.reference) if sensor.reference else None
        if found is None:
            return reading
        self._note_orientation(sensor, sensor.reference_kind, sensor.reference)
        name = f"{reading.name} reference"
        self.scene.add_sensor(name, FrameSensor(found[1], position=found[2].position))
        return Reading(reading.name, reading.carrier, reading.pose, name, found[2])

    def _frame(self, kind: str, name: str) -> tuple[int, str, Pose] | None:
        """Return the body of a named frame, the scene's body that carries it, and its pose in that."""
        model = self.model
        lists = {"site": model.sites, "geom": model.geoms, "camera": model.cameras}
        if kind in ("body", "xbody"):
            index = next((k for k, body in enumerate(model.bodies) if body.name == name), None)
            if index is None:
                return None
            carrier, pose = self.names.bodies[index]
            center = model.bodies[index].inertia.center if kind == "body" else np.zeros(3)
            return index, carrier, Pose(pose.point(center), pose.orientation)
        one = next((one for one in lists.get(kind, ()) if one.name == name), None)  # type: ignore[attr-defined]
        if one is None:
            return None
        carrier, pose = self.names.bodies[one.body]
        return one.body, carrier, pose.then(one.pose)

    def _note_orientation(self, sensor: Sensor, kind: str, name: str) -> None:
        if kind == "body" and (sensor.kind in ("framequat", *AXES) or name == sensor.reference):
            self.notes.add(PRINCIPAL, title_of(sensor))
        if kind == "geom" and any(geom.name == name and geom.kind == "mesh" for geom in self.model.geoms):
            self.notes.add(OF_FILE, title_of(sensor))
