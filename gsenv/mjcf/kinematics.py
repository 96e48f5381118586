"""Poses and velocities of all bodies from joint coordinates, as MuJoCo defines them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..solver.records.model import Array
from .frames import Pose, about, product
from .model import RATES, Joint, MjcfModel


@dataclass(frozen=True, eq=False)
class Motion:
    """Pose of a body in the world, velocity of its origin (3,) m/s and angular velocity (3,) rad/s in the world."""

    pose: Pose
    velocity: Array
    spin: Array


def motions(model: MjcfModel, coordinates: Array, rates: Array) -> list[Motion]:
    """Return the motion of each body.

    Args:
        coordinates: (coordinate,) qpos; rates: (rate,) qvel.
    """
    found: list[Motion] = []
    joints: list[list[Joint]] = [[] for _ in model.bodies]
    for joint in model.joints:
        joints[joint.body].append(joint)
    for index, body in enumerate(model.bodies):
        if index == 0:
            found.append(Motion(body.world_pose, np.zeros(3), np.zeros(3)))
            continue
        parent = found[body.parent]
        pose = parent.pose.then(body.pose)
        spin = parent.spin
        velocity = parent.velocity + np.cross(spin, pose.position - parent.pose.position)
        for joint in joints[index]:
            pose, velocity, spin = _moved(joint, pose, velocity, spin, coordinates, rates)
        found.append(Motion(pose, velocity, spin))
    return found


def _moved(
    joint: Joint, pose: Pose, velocity: Array, spin: Array, coordinates: Array, rates: Array
) -> tuple[Pose, Array, Array]:
    """Return pose and velocities after one joint; those before it are of the body's origin without the joint."""
    q, v = joint.coordinate, joint.rate
    if joint.kind == "free":
        turn = coordinates[q + 3 : q + 7]
        pose = Pose(np.array(coordinates[q : q + 3], float), turn / np.linalg.norm(turn))
        return pose, np.array(rates[v : v + 3], float), pose.axes @ rates[v + 3 : v + 6]
    axis = pose.axes @ joint.axis
    before = pose.position
    if joint.kind == "slide":
        pose = Pose(before + axis * (coordinates[q] - joint.reference), pose.orientation)
        return pose, velocity + np.cross(spin, pose.position - before) + axis * rates[v], spin
    anchor = pose.point(joint.position)
    if joint.kind == "hinge":
        turn = about(joint.axis, float(coordinates[q] - joint.reference))
    else:
        turn = coordinates[q : q + 4] / np.linalg.norm(coordinates[q : q + 4])
    orientation = product(pose.orientation, turn)
    turned = Pose(np.zeros(3), orientation).axes
    pose = Pose(anchor - turned @ joint.position, orientation)
    own = axis * rates[v] if joint.kind == "hinge" else turned @ rates[v : v + 3]
    velocity = velocity + np.cross(spin, pose.position - before) + np.cross(own, pose.position - anchor)
    return pose, velocity, spin + own


def mass_matrix(model: MjcfModel, coordinates: Array) -> Array:
    """Return the matrix (rate, rate) of the kinetic energy, with the armatures.

    Args:
        coordinates: (coordinate,) qpos.
    """
    momenta = np.zeros((model.rate_count, 6 * len(model.bodies)))  # of unit rates, in units of sqrt(2 J)
    for k, rates in enumerate(np.eye(model.rate_count)):
        for b, (body, motion) in enumerate(zip(model.bodies, motions(model, coordinates, rates), strict=True)):
            inertia, axes = body.inertia, motion.pose.axes
            of_center = motion.velocity + np.cross(motion.spin, axes @ inertia.center)
            values, principal = np.linalg.eigh(inertia.tensor)
            turn = np.sqrt(np.maximum(values, 0.0)) * (principal.T @ axes.T @ motion.spin)
            momenta[k, 6 * b : 6 * b + 6] = [*(np.sqrt(inertia.mass) * of_center), *turn]
    armatures = np.zeros(model.rate_count)
    for joint in model.joints:
        armatures[joint.rate : joint.rate + RATES[joint.kind]] = joint.armature
    return momenta @ momenta.T + np.diag(armatures)
