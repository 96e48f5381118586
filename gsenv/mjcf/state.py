"""Coordinates of a World in MuJoCo's terms: qpos and qvel."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..solver.records.model import Array
from .build import Names
from .inertia import rigid_inertias, rigid_roots
from .kinematics import motions
from .model import MjcfModel

if TYPE_CHECKING:
    from ..solver.api.world import World


def set_coordinates(
    world: World, model: MjcfModel, names: Names, qpos: Any, qvel: Any = None, worlds: Any = None
) -> None:
    """Set the poses and velocities of all bodies from joint coordinates, such as those of a keyframe.

    Args:
        names: from ``build_scene(model)``, whose scene the world has.
        qpos: (coordinate,), m, rad and quaternions; qvel: (rate,), default 0.
        worlds: None for all, an int, ints or a bool mask.

    Raises:
        ValueError: a wrong count of numbers.
    """
    positions = np.asarray(qpos, float)
    rates = np.zeros(model.rate_count) if qvel is None else np.asarray(qvel, float)
    if positions.shape != (model.coordinate_count,) or rates.shape != (model.rate_count,):
        counts = f"({model.coordinate_count},) and ({model.rate_count},)"
        raise ValueError(f"set_coordinates: qpos and qvel must be {counts}, got {positions.shape} and {rates.shape}.")
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
    """Return qpos (world, coordinate) and qvel (world, rate) of all worlds.

    Those of a ball joint, whose coordinates a World does not have, are NaN.
    """
    qpos = np.full((world.world_count, model.coordinate_count), np.nan)
    qvel = np.full((world.world_count, model.rate_count), np.nan)
    for number, joint in enumerate(model.joints):
        q, v = joint.coordinate, joint.rate
        if number in names.joints:
            at = names.joints[number]
            qpos[:, q] = at.reference + at.sign * world.joint_coordinate(at.joint)
            qvel[:, v] = at.sign * world.joint_rate(at.joint)
        elif joint.kind == "free":
            body = world.model.body_names.index(names.bodies[joint.body][0])
            qpos[:, q : q + 3], qpos[:, q + 3 : q + 7] = world.position[:, body], world.orientation[:, body]
    return qpos, qvel
