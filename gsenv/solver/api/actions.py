"""Methods of World that act on bodies and joints between steps."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..dimension import Dimension
from ..records.model import Array, JointKind, Model
from ..records.state import State
from ..specification import check
from ..specification.handles import Reference, find
from .joint_poses import Move, bodies_beyond, move_bodies
from .one_thread import OneThread
from .parameters import Parameters, of_world


class Actions:
    """Setters of forces, poses, velocities, motors and targets; a base class of World, which sets these attributes."""

    model: Model
    parameters: Parameters
    state: State
    world_count: int
    _dimension: Dimension
    _use: OneThread

    def _joint(self, joint: Reference, where: str) -> int:
        return find(joint, "joint", self.model.joint_names, where)

    @of_world
    def apply_force(
        self,
        body: Reference,
        *,
        force: Any = None,
        torque: Any = None,
        point: Any = None,
        worlds: Any = None,
    ) -> None:
        """Add a force or torque that acts during the next step and is constant over it.

        Args:
            force: N, (dim,) or (chosen world, dim).
            torque: N m, one number or (chosen world,); in 3D (3,) or (chosen world, 3).
            point: m, world point that the force acts at, (dim,) or (chosen world, dim); None is the centre of mass.
            worlds: None for all, an int, ints or a bool mask.
        """
        b = find(body, "body", self.model.body_names, "apply_force")
        where = f"apply_force on body {self.model.body_names[b]!r}"
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        n = len(chosen)
        dim = self.model.dim
        if force is None and (torque is None or point is not None):
            raise ValueError(f"{where}: force is missing.")
        f = check.vectors(np.zeros(dim) if force is None else force, (n, dim), f"{where}: force")
        t = np.zeros((n, 2 * dim - 3))
        if torque is not None:
            t += self._angular(torque, n, f"{where}: torque").reshape(n, -1)
        with np.errstate(all="ignore"):
            if point is not None:
                arm = check.vectors(point, (n, dim), f"{where}: point") - self.state.bodies["position"][chosen, b]
                turn = arm[:, 0] * f[:, 1] - arm[:, 1] * f[:, 0] if dim == 2 else np.cross(arm, f)
                t += turn.reshape(n, -1)
            total = self.state.bodies["force"][chosen, b] + np.concatenate([f, t], 1)
        if not (np.abs(total) <= check.LARGEST).all():
            raise ValueError(f"{where}: the sum of forces and torques must not exceed {check.LARGEST:g}.")
        self.state.bodies["force"][chosen, b] = total
        self._wake(chosen, b)

    @of_world
    def set_pose(
        self,
        body: Reference,
        *,
        position: Any = None,
        angle: Any = None,
        orientation: Any = None,
        worlds: Any = None,
    ) -> None:
        """Set the pose of a body; what is not given does not change.

        Args:
            position: m, of the body's own frame, (dim,) or (chosen world, dim).
            angle: rad, in 2D, one number or (chosen world,).
            orientation: quaternion (w, x, y, z), in 3D, (4,) or (chosen world, 4), of any length but 0.
            worlds: None for all, an int, ints or a bool mask.
        """
        b = find(body, "body", self.model.body_names, "set_pose")
        where = f"set_pose of body {self.model.body_names[b]!r}"
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        shape = (len(chosen), self.model.dim)
        place = None if position is None else check.vectors(position, shape, f"{where}: position")
        turn = self._rotation(angle, orientation, len(chosen), where)
        record = self.state.bodies
        center = self.parameters.bodies["center"][chosen, b]
        rotated = self._dimension.joint_readings.rotated
        if place is None:
            place = record["position"][chosen, b] - rotated(record["rotation"][chosen, b], center)
        if turn is not None:
            if self.model.dim == 2:
                record["angle"][chosen, b] = turn
            record["rotation"][chosen, b] = [self._dimension.initial_state.rotation_of(one) for one in turn]
        record["position"][chosen, b] = place + rotated(record["rotation"][chosen, b], center)
        self.state.forget_impulses(chosen, b)
        self._wake(chosen)

    def _angular(self, value: Any, count: int, what: str) -> Array:
        """Return checked numbers (count,), or in 3D vectors (count, 3)."""
        return check.values(value, (count,), what) if self.model.dim == 2 else check.vectors(value, (count, 3), what)

    def _rotation(self, angle: Any, orientation: Any, count: int, where: str) -> Array | None:
        """Return checked angles (count,) in rad, or quaternions (count, 4), or None where neither is given."""
        if self.model.dim == 2:
            if orientation is not None:
                raise ValueError(f"{where}: a body in 2D has an angle, not an orientation.")
            return None if angle is None else check.values(angle, (count,), f"{where}: angle")
        if angle is not None:
            raise ValueError(f"{where}: a body in 3D has an orientation (w, x, y, z), not an angle.")
        if orientation is None:
            return None
        turn = check.vectors(orientation, (count, 4), f"{where}: orientation")
        if not ((turn * turn).sum(-1) > 1e-24).all():
            raise ValueError(f"{where}: orientation must be a quaternion other than zero.")
        return turn

    @of_world
    def set_velocity(self, body: Reference, *, linear: Any = None, angular: Any = None, worlds: Any = None) -> None:
        """Set the velocity of a body; what is not given does not change.

        Args:
            linear: m/s, of the centre of mass, (dim,) or (chosen world, dim).
            angular: rad/s, one number or (chosen world,); in 3D (3,) or (chosen world, 3), in the world's axes.
            worlds: None for all, an int, ints or a bool mask.
        """
        b = find(body, "body", self.model.body_names, "set_velocity")
        where = f"set_velocity of body {self.model.body_names[b]!r}"
        if self.model.bodies["kind"][b] == 0:
            raise ValueError(f"{where}: it is static.")
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        n = len(chosen)
        dim = self.model.dim
        v = None if linear is None else check.vectors(linear, (n, dim), f"{where}: linear")
        w = None if angular is None else self._angular(angular, n, f"{where}: angular")
        if v is not None:
            self.state.bodies["velocity"][chosen, b, :dim] = v
        if w is not None:
            self.state.bodies["velocity"][chosen, b, dim:] = w.reshape(n, -1)
        self._wake(chosen, b)

    @of_world
    def set_motor(self, joint: Reference, *, speed: Any = None, rest: Any = None, worlds: Any = None) -> None:
        """Set the set point of a joint's motor or spring; one number or (chosen world,).

        Args:
            speed: rad/s or m/s, of the motor.
            rest: rad or m, coordinate at which the spring is relaxed.
            worlds: None for all, an int, ints or a bool mask.
        """
        j = self._joint(joint, "set_motor")
        where = f"set_motor of joint {self.model.joint_names[j]!r}"
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        checked = {
            name: check.values(value, (len(chosen),), f"{where}: {word}")
            for name, word, value in (("motor_speed", "speed", speed), ("rest", "rest", rest))
            if value is not None
        }
        parameters = self.parameters.joints[:, j]
        if speed is not None and not (parameters["motor_effort"] > 0.0).any():
            raise ValueError(f"{where}: it has no motor.")
        if rest is not None and not ((parameters["frequency"] > 0.0) | (parameters["stiffness"] > 0.0)).any():
            raise ValueError(f"{where}: it has no spring.")
        for name, values in checked.items():
            self.state.joints[name][chosen, j] = values
        self._wake(chosen)

    @of_world
    def set_joint(self, joint: Reference, *, coordinate: Any = None, rate: Any = None, worlds: Any = None) -> None:
        """Set the coordinate of a joint, its rate or both; all bodies beyond the joint move with it.

        All other coordinates and rates stay; what is not given does not change. Which body is beyond
        the joint: the one that is farther from the fixed bodies, or from the first body of a free tree.

        Args:
            joint: revolute, hinge, prismatic, slider or wheel, or a coordinate such as "hip/turn_x", in no loop.
            coordinate: rad or m, as ``World.joint_coordinate``, one number or (chosen world,); limits do not bound it.
            rate: rad/s or m/s, likewise.
            worlds: None for all, an int, ints or a bool mask.

        Raises:
            ValueError: a joint without a coordinate, in a loop or disabled; numbers that are not finite.
        """
        j = self._joint(joint, "set_joint")
        where = f"set_joint of joint {self.model.joint_names[j]!r}"
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        given = {
            word: check.values(value, (len(chosen),), f"{where}: {word}")
            for word, value in (("coordinate", coordinate), ("rate", rate))
            if value is not None
        }
        enabled = self.parameters.joints["enabled"][chosen]
        groups = [(row, np.flatnonzero((enabled == row).all(1))) for row in np.unique(enabled, axis=0)]
        beyond = [bodies_beyond(self.model, row, j) for row, _ in groups]
        for (_, members), bodies in zip(groups, beyond, strict=True):
            change = [np.zeros(len(members))] * 2
            readings = self._dimension.joint_readings
            for k, (word, read) in enumerate((("coordinate", readings.coordinate), ("rate", readings.rate))):
                if word in given:
                    change[k] = given[word][members] - read(self.model, self.parameters, self.state, j)[chosen[members]]
            move = Move(j, chosen[members], bodies, *change)
            move_bodies(self._dimension, self.model, self.parameters, self.state, move)
        self._wake(chosen)

    @of_world
    def set_target(
        self,
        joint: Reference,
        *,
        position: Any = None,
        angle: Any = None,
        orientation: Any = None,
        linear: Any = None,
        angular: Any = None,
        worlds: Any = None,
    ) -> None:
        """Set the pose that a target joint pulls its body to; what is not given does not change.

        Args:
            position: m, (dim,) or (chosen world, dim).
            angle: rad, in 2D, one number or (chosen world,).
            orientation: quaternion (w, x, y, z), in 3D, (4,) or (chosen world, 4), of any length but 0.
            linear, angular: m/s and rad/s, velocity of the pose; shapes as in ``set_velocity``.
            worlds: None for all, an int, ints or a bool mask.
        """
        j = self._joint(joint, "set_target")
        where = f"set_target of joint {self.model.joint_names[j]!r}"
        if self.model.joints["kind"][j] != JointKind["TARGET"]:
            raise ValueError(f"{where}: it is not a target joint.")
        chosen = check.worlds(worlds, self.world_count, f"{where}: worlds")
        n, dim = len(chosen), self.model.dim
        place = None if position is None else check.vectors(position, (n, dim), f"{where}: position")
        turn = self._rotation(angle, orientation, n, where)
        v = None if linear is None else check.vectors(linear, (n, dim), f"{where}: linear")
        w = None if angular is None else self._angular(angular, n, f"{where}: angular")
        record = self.state.joints
        if place is not None:
            record["target_position"][chosen, j] = place
        if turn is not None and dim == 2:
            record["target_angle"][chosen, j] = turn
        elif turn is not None:
            record["target_rotation"][chosen, j] = [self._dimension.initial_state.rotation_of(one) for one in turn]
        if v is not None:
            record["target_velocity"][chosen, j, :dim] = v
        if w is not None:
            record["target_velocity"][chosen, j, dim:] = w.reshape(n, -1)

    def _wake(self, chosen: Array, body: int | None = None) -> None:
        """Wake a body, or all bodies of the chosen worlds, whose supports may have changed."""
        which = slice(None) if body is None else body
        for name in ("asleep", "sleep_time"):
            self.state.bodies[name][chosen, which] = 0
