"""Sensors of a model as sensors of a Scene."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..solver.specification.scene import Scene
from ..solver.specification.sensors import ContactSensor, JointSensor, PoseSensor, VelocitySensor
from .errors import Notes
from .model import MjcfModel, Sensor

if TYPE_CHECKING:
    from .build import Names

JOINT = ("jointpos", "jointvel", "jointactuatorfrc", "jointlimitfrc")
POSE = ("framepos", "framequat", "framexaxis", "frameyaxis", "framezaxis")
VELOCITY = ("framelinvel", "frameangvel", "velocimeter", "gyro")
REACTION = ("force", "torque")
UNSUPPORTED = "sensors of this kind are not supported"
WHOLE = "a sensor of a site or geom reads the whole body that it is on"
RELATIVE = "a sensor reads in the world, not relative to a reference frame"


def add_sensors(scene: Scene, model: MjcfModel, names: Names, notes: Notes) -> None:
    """Add the sensors that a Scene has.

    A sensor of a joint reads coordinate and rate, force and torque at once; one of a frame position and quaternion, or
    velocity and angular velocity; a touch sensor whether the body touches, and the force.
    """
    for k, sensor in enumerate(model.sensors):
        name = sensor.name or f"{sensor.kind} {k}"
        title = f"{sensor.place}: {sensor.kind}" + (f" {sensor.name!r}" if sensor.name else "")
        if sensor.kind in JOINT:
            number = next((j for j, joint in enumerate(model.joints) if joint.name == sensor.object), -1)
            if number in names.joints:
                scene.add_sensor(name, JointSensor(names.joints[number].joint))
                continue
        body = _body(sensor, model)
        if body is None or sensor.kind not in (*POSE, *VELOCITY, *REACTION, "touch"):
            notes.add(UNSUPPORTED, title)
            continue
        if sensor.object_kind not in ("body", "xbody"):
            notes.add(WHOLE, title)
        if sensor.reference:
            notes.add(RELATIVE, title)
        carrier = names.bodies[body][0]
        if sensor.kind in REACTION:
            held = [
                names.joints[j].joint
                for j, joint in enumerate(model.joints)
                if joint.body == body and j in names.joints
            ]
            if not held:
                notes.add(UNSUPPORTED, title)
                continue
            scene.add_sensor(name, JointSensor(held[0].partition("/")[0]))
        elif sensor.kind == "touch":
            scene.add_sensor(name, ContactSensor(carrier))
        else:
            scene.add_sensor(name, PoseSensor(carrier) if sensor.kind in POSE else VelocitySensor(carrier))


def _body(sensor: Sensor, model: MjcfModel) -> int | None:
    """Return the index of the body that a sensor is on."""
    if sensor.object_kind in ("body", "xbody"):
        return next((k for k, body in enumerate(model.bodies) if body.name == sensor.object), None)
    if sensor.object_kind == "site":
        return next((site.body for site in model.sites if site.name == sensor.object), None)
    if sensor.object_kind == "geom":
        return next((geom.body for geom in model.geoms if geom.name == sensor.object), None)
    return None
