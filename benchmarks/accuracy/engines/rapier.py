"""Rapier in 3D behind the common interface: the same bodies, shapes, masses and joints as in our Model.

Its package for Python, rapier3d, computes in single precision; a world has one thread. Friction is the average, which
for equal coefficients is gsenv's, and the larger restitution counts, as in gsenv. Bodies don't sleep. Velocities and
their corrections have no limit.

Settings: substeps; contact_softness, static_contact_softness: (Hz, damping ratio) of the springs that contacts are;
cone: Coulomb's friction at each point, in place of one for the manifold; reduced: linkages in joint coordinates, in
place of impulses.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import rapier3d
from numpy.typing import NDArray

from gsenv.solver.records.model import BodyKind, Model
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE, SPHERE

from ..geometry3d import conjugate, multiply, rotated
from ..trajectory import STATE3, ball_joints
from . import Setting, touching_shapes

Array = NDArray[np.float64]
UP = np.array([math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0])  # takes y, the axis of its cylinders, to z
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])
LIMIT = 1e9  # m/s, of what it caps


def version() -> str:
    return str(rapier3d.__version__)


class Simulation:
    """A PhysicsWorld; one call of its step for each step."""

    def __init__(self, model: Model, setting: Setting) -> None:
        self.source = model
        self.world = rapier3d.PhysicsWorld(gravity=model.nominal_world["gravity"].tolist())
        self.world.set_num_threads(1)
        self._parameters(setting)
        self.handles = [self._body(index) for index in range(len(model.bodies))]
        self.bodies = self.world.rigid_bodies
        for joint in ball_joints(model):
            self._joint(int(joint), bool(setting.values.get("reduced", False)))

    def _parameters(self, setting: Setting) -> None:
        values, parameters = setting.values, self.world.integration_parameters
        parameters.dt = setting.timestep
        parameters.num_solver_iterations = values["substeps"]
        parameters.normalized_max_linear_velocity = LIMIT
        if values.get("cone", False):
            parameters.friction_model = rapier3d.FrictionModel.COULOMB
        for name in ("contact_softness", "static_contact_softness"):
            if name in values:
                setattr(parameters, name, rapier3d.SpringCoefficients(*values[name]))
                parameters.normalized_max_corrective_velocity = LIMIT

    def _body(self, index: int) -> Any:
        model, start = self.source, self.source.start_bodies[index]
        dynamic = model.bodies["kind"][index] == BodyKind.DYNAMIC
        body = rapier3d.RigidBody.dynamic() if dynamic else rapier3d.RigidBody.fixed()
        body = body.position(placed(start["position"], start["rotation"])).can_sleep(False).ccd_enabled(False)
        if dynamic:
            velocity, nominal = start["velocity"].tolist(), model.nominal_bodies[index]
            mass = rapier3d.MassProperties((0.0, 0.0, 0.0), float(nominal["mass"]), nominal["inertia"].tolist())
            body = body.linvel(velocity[:3]).angvel(velocity[3:]).additional_mass_properties(mass)
            body = body.gyroscopic_forces(True).allow_fast_rotation(True)
        return self.world.add_body(body, [self._collider(index, shape) for shape in touching_shapes(model, index)])

    def _collider(self, owner: int, index: int) -> Any:
        kind, shape = int(self.source.shapes["kind"][index]), self.source.nominal_shapes[index]
        turn = shape["local_rotation"]
        if kind == SPHERE:
            collider = rapier3d.Collider.ball(float(shape["radius"]))
        elif kind == BOX:
            collider = rapier3d.Collider.cuboid(*shape["size"].tolist())
        elif kind == CYLINDER:
            collider = rapier3d.Collider.cylinder(float(shape["size"][2]), float(shape["radius"]))
            turn = multiply(turn, UP)
        elif kind == PLANE:
            collider = rapier3d.Collider.halfspace(rotated(turn, np.array([0.0, 0.0, 1.0])).tolist())
            turn = IDENTITY
        else:
            raise ValueError(f"shape {self.source.shape_names[index]!r}: the benchmark has no such shapes.")
        collider = collider.position(
            placed(shape["local_position"] - self.source.nominal_bodies["center"][owner], turn)
        )
        collider = collider.density(0.0).friction(float(shape["friction"])).restitution(float(shape["restitution"]))
        return collider.restitution_combine_rule(rapier3d.CoefficientCombineRule.MAX)

    def _joint(self, index: int, reduced: bool) -> None:
        joint, nominal = self.source.joints[index], self.source.nominal_joints[index]
        a, b = int(joint["body_a"]), int(joint["body_b"])
        centers, turns = self.source.nominal_bodies["center"], self.source.start_bodies["rotation"]
        ball = rapier3d.SphericalJoint.builder().contacts_enabled(False)
        # the joint's coordinates are 0 at the start, whatever they are
        ball = ball.local_frame1(placed(nominal["anchor_a"] - centers[a], multiply(conjugate(turns[a]), turns[b])))
        ball = ball.local_frame2(placed(nominal["anchor_b"] - centers[b], IDENTITY))
        joints: Any = self.world.multibody_joints if reduced else self.world.impulse_joints
        handle = joints.insert(self.handles[a], self.handles[b], ball.build())
        if reduced:
            linkage = joints.multibody(handle)
            linkage.set_damping([0.0] * linkage.ndofs)

    def step(self, count: int) -> None:
        step = self.world.step
        for _ in range(count):
            step()

    def read(self) -> Array:
        out = np.empty((len(self.handles), STATE3))
        for row, handle in zip(out, self.handles, strict=True):
            body = self.bodies[handle]
            place, turn, velocity, spin = body.translation, body.rotation, body.linvel, body.angvel
            row[0:3], row[3:7] = (place.x, place.y, place.z), (turn.w, turn.i, turn.j, turn.k)
            row[7:10], row[10:13] = (velocity.x, velocity.y, velocity.z), (spin.x, spin.y, spin.z)
        return out


def placed(position: Array, turn: Array) -> Any:
    """Return a pose of rapier."""
    return rapier3d.Isometry3(position.tolist(), rapier3d.Rotation3(*turn.tolist()))
