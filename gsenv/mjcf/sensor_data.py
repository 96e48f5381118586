"""Readings of the sensors of a model as MuJoCo's sensordata has them: in the sensor's own frame, with its cutoff."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial.initial_state import multiplied, turned_by
from .build import Names
from .frames import Pose
from .model import Actuator, MjcfModel, Sensor, Site
from .scene_sensors import ACCELERATION, ACTUATOR, AXES, BALL, FARTHEST, FRAME, JOINT, Reading
from .site_volumes import ray_meets
from .state import BACK, coordinates

if TYPE_CHECKING:
    from ..solver.api.world import World


POSITIVE = ("touch", "rangefinder")
UNIT = ("framequat", "ballquat", *AXES)  # have no cutoff


def sensor_data(world: World, model: MjcfModel, names: Names) -> dict[str, Array]:
    """Return the readings (world, number) of the model's sensors by name, each as in MuJoCo's ``sensordata``.

    Forces and accelerations are means over the last step, everything else is of the present state. Sensors that no
    Scene has are left out; ``"<kind> <index>"`` is the name of a sensor without one.

    Args:
        names: from ``build_scene(model)``, whose scene the world has.
    """
    reader = _Reader(world, model, names)
    return {reading.name: reader.read(model.sensors[k], reading) for k, reading in names.sensors.items()}


class _Reader:
    def __init__(self, world: World, model: MjcfModel, names: Names) -> None:
        self.world = world
        self.model = model
        self.names = names

    def read(self, sensor: Sensor, reading: Reading) -> Array:
        """Return a sensor's reading (world, number) within its cutoff."""
        if sensor.kind in JOINT:
            value = self._joint(sensor)
        elif sensor.kind in BALL:
            joint = next(one for one in self.model.joints if one.name == sensor.object)
            qpos, qvel = coordinates(self.world, self.model, self.names)
            q, v = joint.coordinate, joint.rate
            value = qpos[:, q : q + 4] if sensor.kind == "ballquat" else qvel[:, v : v + 3]
        elif sensor.kind in ACTUATOR:
            value = self._actuator(sensor)
        elif sensor.kind in FRAME:
            value = self._frame(sensor.kind, reading)
        elif sensor.kind in ACCELERATION:
            value = self._acceleration(sensor.kind, reading)
        elif sensor.kind == "rangefinder":
            distance = self.world.sensor(reading.name)
            value = np.where(distance >= FARTHEST, -1.0, distance)
        elif sensor.kind == "touch":
            value = self._touch(sensor, reading)
        else:
            value = self._load(sensor.kind, reading)
        if sensor.cutoff > 0.0 and sensor.kind not in UNIT:
            value = np.minimum(value, sensor.cutoff) if sensor.kind in POSITIVE else _clipped(value, sensor.cutoff)
        return value

    def _coordinate(self, joint: str) -> tuple[Array, Array]:
        """Return a coordinate and its rate (world,) in the model's terms."""
        number = next(k for k, one in enumerate(self.model.joints) if one.name == joint)
        at = self.names.joints[number]
        q = at.reference + at.sign * self.world.joint_coordinate(at.joint)
        return q, at.sign * self.world.joint_rate(at.joint)

    def _joint(self, sensor: Sensor) -> Array:
        q, rate = self._coordinate(sensor.object)
        return np.asarray((q if sensor.kind == "jointpos" else rate)[:, None])

    def _actuator(self, sensor: Sensor) -> Array:
        """Return length, speed or force of an actuator; the force is that of the present state."""
        number = next(k for k, one in enumerate(self.model.actuators) if one.name == sensor.object)
        actuator = self.model.actuators[number]
        q, rate = self._coordinate(actuator.target)
        length, speed = actuator.gear[0] * q, actuator.gear[0] * rate
        if sensor.kind == "actuatorfrc":
            column = self.world.model.actuator_names.index(self.names.actuators[number])
            return _force(actuator, self.world.control[:, column], length, speed)[:, None]
        return np.asarray((length if sensor.kind == "actuatorpos" else speed)[:, None])

    def _frame(self, kind: str, reading: Reading) -> Array:
        assert reading.pose is not None
        place, own, velocity, spin = self._motion(reading.name, reading.pose)
        if kind in ("velocimeter", "gyro"):
            return turned_by(own * BACK, velocity if kind == "velocimeter" else spin)
        if reading.reference:
            assert reading.reference_pose is not None
            at, turn, speed, turning = self._motion(reading.reference, reading.reference_pose)
            back = turn * BACK
            velocity = turned_by(back, velocity - speed - np.cross(turning, place - at))
            spin = turned_by(back, spin - turning)
            place, own = turned_by(back, place - at), multiplied(back, own)
        if kind in AXES:
            return turned_by(own, np.eye(3)[AXES.index(kind)])
        values = {"framepos": place, "framequat": own, "framelinvel": velocity, "frameangvel": spin}
        return values[kind]

    def _motion(self, name: str, pose: Pose) -> tuple[Array, Array, Array, Array]:
        """Return position, orientation, velocity and angular velocity of a sensor's frame in the world."""
        given = self.world.sensor(name)
        body = given[:, 3:7]
        own = multiplied(body, pose.orientation)
        return given[:, :3], own, turned_by(body, given[:, 7:10]), turned_by(body, given[:, 10:13])

    def _acceleration(self, kind: str, reading: Reading) -> Array:
        """Return the acceleration less gravity, as MuJoCo also does in framelinacc, or the angular acceleration."""
        assert reading.pose is not None
        given = self.world.sensor(reading.name)
        body = self.world.model.body_names.index(reading.carrier)
        orientation = self.world.orientation[:, body]
        if kind == "frameangacc":
            return turned_by(orientation, given[:, 3:])
        parameters = self.world.parameters
        borne = (1.0 - parameters.bodies["gravity_scale"][:, body])[:, None] * parameters.worlds["gravity"]
        own = given[:, :3] - turned_by(orientation * BACK, borne)
        if kind == "framelinacc":
            return turned_by(orientation, own)
        return turned_by(reading.pose.orientation * BACK, own)

    def _touch(self, sensor: Sensor, reading: Reading) -> Array:
        """Return the sum of the normal forces on the body whose lines of action meet the site's volume."""
        assert reading.pose is not None
        site = next(one for one in self.model.sites if one.name == sensor.object)
        body = self.world.model.body_names.index(reading.carrier)
        carrier = self.world.position[:, body], self.world.orientation[:, body]
        return np.array(
            [[self._touching(site, reading.pose, body, w, (carrier[0][w], carrier[1][w]))]
             for w in range(self.world.world_count)]
        )  # fmt: skip

    def _touching(self, site: Site, pose: Pose, body: int, w: int, carrier: tuple[Array, Array]) -> float:
        contacts = self.world.contacts(w)
        frame = Pose(*carrier).then(pose)
        total = 0.0
        for k in np.flatnonzero(((contacts.body_a == body) | (contacts.body_b == body)) & ~contacts.sensor):
            force = float(contacts.impulse[k, 0]) / self.world.timestep
            outward = contacts.normal[k] if contacts.body_a[k] == body else -contacts.normal[k]
            start, ahead = (contacts.point[k] - frame.position) @ frame.axes, outward @ frame.axes
            if force > 0.0 and ray_meets(site.kind, site.size, start, ahead):
                total += force
        return total

    def _load(self, kind: str, reading: Reading) -> Array:
        """Return force or torque of the parent on the body, about the site and in its frame; 0 of a free body."""
        assert reading.pose is not None
        world = self.world
        body = world.model.body_names.index(reading.carrier)
        orientation = world.orientation[:, body]
        place = world.position[:, body] + turned_by(orientation, reading.pose.position)
        force = np.zeros((world.world_count, 3))
        torque = np.zeros((world.world_count, 3))
        for name in reading.further:
            sensor = world.model.sensors[world.model.sensor_names.index(name)]
            anchor = world.parameters.joints["anchor_b"][:, sensor["joint"]]
            arm = world.position[:, body] + turned_by(orientation, anchor) - place
            given = world.sensor(name)[:, -6:]
            force += given[:, :3]
            torque += given[:, 3:] + np.cross(arm, given[:, :3])
        return turned_by(multiplied(orientation, reading.pose.orientation) * BACK, force if kind == "force" else torque)


def _clipped(value: Array, cutoff: float) -> Array:
    return np.clip(value, -cutoff, cutoff)


def _force(actuator: Actuator, control: Array, length: Array, speed: Array) -> Array:
    """Return the force (world,) of an affine actuator within its bounds."""
    lower, upper = actuator.control_range or (-np.inf, np.inf)
    force = actuator.gain * np.clip(control, lower, upper) + actuator.bias[0]
    force = force + actuator.bias[1] * length + actuator.bias[2] * speed
    bounds = actuator.force_range or (-np.inf, np.inf)
    return np.asarray(np.clip(force, *bounds))
