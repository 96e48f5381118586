"""Coordinates of a World in MuJoCo's terms: qpos and qvel."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial.initial_state import multiplied, turned_by
from ..solver.specification import check
from .build import Names
from .inertia import rigid_inertias, rigid_roots
from .kinematics import motions
from .model import MjcfModel

if TYPE_CHECKING:
    from ..solver.api.world import World

BACK = np.array([1.0, -1.0, -1.0, -1.0])  # q * BACK is the opposite rotation


def set_coordinates(
    world: World, model: MjcfModel, names: Names, qpos: Any, qvel: Any = None, worlds: Any = None
) -> None:
    """Set the poses and velocities of all bodies from joint coordinates, such as those of a keyframe.

    Args:
        names: from ``build_scene(model)``, whose scene the world has.
        qpos: (coordinate,), m, rad and quaternions; qvel: (rate,), default 0.
        worlds: None for all, an int, ints or a bool mask.

    Raises:
        ValueError: a wrong count of numbers, numbers that are not finite, a quaternion of 0; nothing is changed then.
    """
    positions = check.vector(qpos, model.coordinate_count, "set_coordinates: qpos")
    rates = check.vector(
        np.zeros(model.rate_count) if qvel is None else qvel, model.rate_count, "set_coordinates: qvel"
    )
    for joint in model.joints:
        first = joint.coordinate + (3 if joint.kind == "free" else 0)
        if joint.kind in ("free", "ball") and not positions[first : first + 4].any():
            raise ValueError(f"set_coordinates: the quaternion of joint {joint.name!r} in qpos must not be zero.")
    moved = motions(model, positions, rates)
    jointed = {joint.body for joint in model.joints}
    inertias = rigid_inertias(model.bodies, jointed)
    for index, root in enumerate(rigid_roots(model.bodies, jointed)):
        if root != index or index == 0:
            continue
        motion = moved[index]
        name = names.bodies[index][0]
        arm = motion.pose.axes @ inertias[index].center
        world.set_pose(name, position=motion.pose.position, orientation=motion.pose.orientation, worlds=worlds)
        linear = motion.velocity + np.cross(motion.spin, arm)
        world.set_velocity(name, linear=linear, angular=motion.spin, worlds=worlds)


def coordinates(world: World, model: MjcfModel, names: Names) -> tuple[Array, Array]:
    """Return qpos (world, coordinate) and qvel (world, rate) of all worlds."""
    qpos = np.zeros((world.world_count, model.coordinate_count))
    qvel = np.zeros((world.world_count, model.rate_count))
    for number, joint in enumerate(model.joints):
        q, v = joint.coordinate, joint.rate
        if number in names.joints:
            at = names.joints[number]
            qpos[:, q] = at.reference + at.sign * world.joint_coordinate(at.joint)
            qvel[:, v] = at.sign * world.joint_rate(at.joint)
        elif joint.kind == "free":
            motion = body_motion(world, names, joint.body)
            qpos[:, q : q + 3], qpos[:, q + 3 : q + 7] = motion.position, motion.orientation
            qvel[:, v : v + 3] = motion.velocity
            qvel[:, v + 3 : v + 6] = turned_by(motion.orientation * BACK, motion.spin)
        else:
            parent, own = (body_motion(world, names, k) for k in (model.bodies[joint.body].parent, joint.body))
            rest = multiplied(parent.orientation, model.bodies[joint.body].pose.orientation)
            turn = multiplied(rest * BACK, own.orientation)
            qpos[:, q : q + 4] = np.where(turn[:, :1] < 0.0, -turn, turn)
            qvel[:, v : v + 3] = turned_by(own.orientation * BACK, own.spin - parent.spin)
    return qpos, qvel


@dataclass(frozen=True, eq=False)
class BodyMotion:
    """Position (world, 3) m, orientation (world, 4), velocity of the origin m/s and angular velocity rad/s."""

    position: Array
    orientation: Array
    velocity: Array
    spin: Array


def body_motion(world: World, names: Names, index: int) -> BodyMotion:
    """Return the motion of a body of the model in all worlds, also of one that is part of another in the scene."""
    name, pose = names.bodies[index]
    body = world.model.body_names.index(name)
    carrier, spin = world.orientation[:, body], world.angular_velocity[:, body]
    position = world.position[:, body] + turned_by(carrier, pose.position)
    velocity = world.linear_velocity[:, body] + np.cross(spin, position - world.center_of_mass[:, body])
    return BodyMotion(position, multiplied(carrier, pose.orientation), velocity, spin)


def set_keyframe(world: World, model: MjcfModel, names: Names, key: str | int = 0, worlds: Any = None) -> None:
    """Set poses, velocities and controls to those of a keyframe.

    Args:
        names: from ``build_scene(model)``, whose scene the world has.
        key: name or index of the keyframe.
        worlds: None for all, an int, ints or a bool mask.

    Raises:
        ValueError: there is no such keyframe.
    """
    keys = [frame.name or k for k, frame in enumerate(model.keyframes)]
    index = keys.index(key) if key in keys else key
    if isinstance(index, str) or not 0 <= index < len(keys):
        raise ValueError(f"set_keyframe: there is no keyframe {key!r}, the file has {keys}.")
    frame = model.keyframes[index]
    set_coordinates(world, model, names, frame.coordinates, frame.rates, worlds)
    chosen = slice(None) if worlds is None else worlds
    for k, name in names.actuators.items():
        world.control[chosen, world.model.actuator_names.index(name)] = frame.controls[k]
