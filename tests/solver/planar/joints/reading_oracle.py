"""Joint errors and spring energies in plain numpy, joint by joint: what the kernel of diagnostics is held against."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gsenv.solver.api.parameters import Parameters
from gsenv.solver.records.model import Array, JointKind, Model
from gsenv.solver.records.state import State

EVERY = np.zeros(0)  # in place of a direction: the mean over all
SLIDING = (JointKind.PRISMATIC, JointKind.WHEEL)


class Ends(NamedTuple):
    """Of one joint in all worlds, m (world, 2): arms from the centres of mass, anchors' difference, and its axis."""

    arm_a: Array
    arm_b: Array
    apart: Array
    axis: Array


def ends_of(model: Model, parameters: Parameters, state: State, j: int) -> Ends:
    arms, points = [], []
    a, b = int(model.joints["body_a"][j]), int(model.joints["body_b"][j])
    for i, anchor in ((a, "anchor_a"), (b, "anchor_b")):
        offset = parameters.joints[anchor][:, j] - parameters.bodies["center"][:, i]
        arms.append(turned(state.bodies["angle"][:, i], offset))
        points.append(state.bodies["position"][:, i] + arms[-1])
    axis = turned(state.bodies["angle"][:, a], parameters.joints["axis"][:, j])
    return Ends(arms[0], arms[1], points[1] - points[0], axis)


def turned(angle: Array, vector: Array) -> Array:
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * vector[:, 0] - s * vector[:, 1], s * vector[:, 0] + c * vector[:, 1]], -1)


def left(vector: Array) -> Array:
    return np.stack([-vector[:, 1], vector[:, 0]], -1)


def joint_error(model: Model, parameters: Parameters, state: State) -> Array:
    """(world,) m, largest error of position of an enabled rigid joint: anchors apart, off the axis, a rod or
    rope too long."""
    worst = np.zeros(len(state.worlds))
    for j in range(len(model.joints)):
        kind = JointKind(int(model.joints["kind"][j]))
        p = parameters.joints[:, j]
        if kind in (JointKind.ROWS, JointKind.TARGET, JointKind.GEAR):
            continue
        ends = ends_of(model, parameters, state, j)
        if kind in SLIDING:
            error = np.abs((left(ends.axis) * ends.apart).sum(-1))
        elif kind == JointKind.DISTANCE:
            length = np.hypot(*ends.apart.T)
            error = np.maximum(p["lower"] - length, length - p["upper"])
            error = np.maximum(error, np.where(p["rigid"] != 0, np.abs(length - p["length"]), 0.0))
        else:
            error = np.hypot(*ends.apart.T)
            if kind == JointKind.WELD:
                soft = (p["frequency"] > 0.0) | (p["stiffness"] > 0.0) | (p["damping"] > 0.0)
                error = np.where(soft, 0.0, error)
        worst = np.maximum(worst, np.where(p["enabled"] != 0, error, 0.0))
    return worst


def spring_energy(model: Model, parameters: Parameters, state: State) -> Array:
    """(world,) J in the springs of enabled joints other than targets."""
    total = np.zeros(len(state.worlds))
    sprung = (parameters.joints["frequency"] > 0.0) | (parameters.joints["stiffness"] > 0.0)
    for j in np.flatnonzero(sprung.any(0)).tolist():
        kind = JointKind(int(model.joints["kind"][j]))
        if kind in (JointKind.ROWS, JointKind.TARGET, JointKind.GEAR):
            continue
        p = parameters.joints[:, j]
        ends = ends_of(model, parameters, state, j)
        angles = state.bodies["angle"]
        turn = angles[:, model.joints["body_b"][j]] - angles[:, model.joints["body_a"][j]] - p["reference_angle"]
        parts: list[tuple[Array, Array | None]] = []  # (stretch, direction or, about the angle, None)
        if kind == JointKind.WELD:
            parts = [(np.hypot(*ends.apart.T), EVERY)]
            parts.append((np.arctan2(np.sin(turn), np.cos(turn)), None))
        elif kind == JointKind.REVOLUTE:
            parts = [(turn - state.joints["rest"][:, j], None)]
        elif kind in SLIDING:
            parts = [((ends.axis * ends.apart).sum(-1) - state.joints["rest"][:, j], ends.axis)]
        elif not p["rigid"].any():
            parts = [(np.hypot(*ends.apart.T) - p["length"], EVERY)]
        for stretch, direction in parts:
            give = _give(model, parameters, j, ends, direction)
            omega = 2.0 * np.pi * p["frequency"]
            stiffness = np.where(p["stiffness"] > 0.0, p["stiffness"], omega**2 / np.maximum(give, 1e-300))
            total += np.where((p["enabled"] != 0) & (give > 0.0), 0.5 * stiffness * stretch**2, 0.0)
    return total


def _give(model: Model, parameters: Parameters, j: int, ends: Ends, direction: Array | None) -> Array:
    """J M^-1 J^T of a row along a direction, its mean over all, or about the angle; (world,) 1/kg or 1/(kg m^2)."""
    a, b = (parameters.bodies[:, model.joints[side][j]] for side in ("body_a", "body_b"))
    if direction is None:
        return np.asarray(a["inv_inertia"] + b["inv_inertia"])
    if direction is EVERY:
        near = ends._replace(apart=0.0 * ends.apart)
        gives = [_give(model, parameters, j, near, axis[None]) for axis in np.eye(2)]
        return np.asarray(0.5 * (gives[0] + gives[1]))
    reach_a = (left(ends.arm_a + ends.apart) * direction).sum(-1)
    reach_b = (left(ends.arm_b) * direction).sum(-1)
    give = a["inv_mass"] + b["inv_mass"] + a["inv_inertia"] * reach_a**2 + b["inv_inertia"] * reach_b**2
    return np.asarray(give)
