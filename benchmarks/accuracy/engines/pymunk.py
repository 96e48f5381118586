"""pymunk (Chipmunk) behind the common interface: the same bodies, shapes, masses and joints as in our Model.

Friction and elasticity multiply in Chipmunk: a friction is given as its square root, whose product is
the geometric mean of gsenv, and static shapes are fully elastic, so that the product is the
moving body's restitution. Half-planes are large boxes: towers on a Segment wander off sideways.

Settings: iterations; slop (m, overlap that is left alone); bias: part of an overlap or joint gap that is
left after 1/60 s; sleep.
"""

from __future__ import annotations

import numpy as np
import pymunk
from numpy.typing import NDArray
from pymunk._chipmunk_cffi import lib

from gsenv.solver.planar.kinds import BOX, CIRCLE, HALF_PLANE
from gsenv.solver.records.model import BodyKind, JointKind, Model

from ..trajectory import STATE
from . import Setting, touching_shapes

Array = NDArray[np.float64]
GROUND_HALF = (40.0, 2.0)  # m, of the box that stands for a half-plane
SLEEP_TIME = 0.5  # s at rest, as in the other engines; Chipmunk itself has no default


def pair(vector: Array) -> tuple[float, float]:
    return float(vector[0]), float(vector[1])


def version() -> str:
    return f"{pymunk.version} (Chipmunk {pymunk.chipmunk_version})"


class Simulation:
    """A Space; one call of cpSpaceStep for each step, without the Python around it."""

    def __init__(self, model: Model, setting: Setting) -> None:
        values = setting.values
        self.timestep = setting.timestep
        space = self.space = pymunk.Space()
        space.gravity = pair(model.nominal_world["gravity"])
        space.iterations = values["iterations"]
        space.collision_slop = values["slop"]
        space.collision_bias = values["bias"] ** 60.0  # what is left after 1 s
        if values.get("sleep", False):
            space.sleep_time_threshold = SLEEP_TIME
        self.bodies = [self._body(model, index) for index in range(len(model.bodies))]
        for index in range(len(model.joints)):
            constraint = self._joint(model, index)
            constraint.collide_bodies = False
            constraint.error_bias = space.collision_bias
            space.add(constraint)

    def _body(self, model: Model, index: int) -> pymunk.Body:
        start, nominal = model.start_bodies[index], model.nominal_bodies[index]
        if model.bodies["kind"][index] == BodyKind.STATIC:
            body = pymunk.Body(body_type=pymunk.Body.STATIC)
        else:
            body = pymunk.Body(float(nominal["mass"]), float(nominal["inertia"]))
            body.velocity = pair(start["velocity"])
            body.angular_velocity = float(start["velocity"][2])
        body.position = pair(start["position"])
        body.angle = float(start["angle"])
        self.space.add(body, *(self._shape(body, model, shape) for shape in touching_shapes(model, index)))
        return body

    def _shape(self, body: pymunk.Body, model: Model, index: int) -> pymunk.Shape:
        kind, shape = model.shapes["kind"][index], model.nominal_shapes[index]
        c, s = map(float, shape["local_rotation"])
        center = shape["local_position"]
        along, up = np.array([c, s]), np.array([-s, c])
        form: pymunk.Shape
        if kind == CIRCLE:
            form = pymunk.Circle(body, float(shape["radius"]), pair(center))
        elif kind in (BOX, HALF_PLANE):
            hx, hy = shape["size"] if kind == BOX else GROUND_HALF
            if kind == HALF_PLANE:
                center = center - hy * up
            signs = ((-1, -1), (1, -1), (1, 1), (-1, 1))
            form = pymunk.Poly(body, [pair(center + x * hx * along + y * hy * up) for x, y in signs])
        else:
            raise ValueError(f"shape {model.shape_names[index]!r}: the benchmark has boxes, circles and half-planes.")
        static = model.bodies["kind"][model.shapes["body"][index]] == BodyKind.STATIC
        form.friction = float(np.sqrt(shape["friction"]))
        form.elasticity = 1.0 if static else float(shape["restitution"])
        return form

    def _joint(self, model: Model, index: int) -> pymunk.Constraint:
        joint, nominal = model.joints[index], model.nominal_joints[index]
        ends = (
            self.bodies[joint["body_a"]], self.bodies[joint["body_b"]],
            pair(nominal["anchor_a"]), pair(nominal["anchor_b"]),
        )  # fmt: skip
        if joint["kind"] == JointKind.REVOLUTE:
            return pymunk.PivotJoint(*ends)
        if joint["kind"] == JointKind.DISTANCE:
            mass = float(model.nominal_bodies["mass"][joint["body_b"]])  # hangs by its centre, from a static body
            w, z = 2.0 * np.pi * float(nominal["frequency"]), float(nominal["damping_ratio"])
            return pymunk.DampedSpring(*ends, float(nominal["length"]), mass * w**2, 2.0 * z * w * mass)
        raise ValueError(f"joint {model.joint_names[index]!r}: the benchmark has hinges and springs.")

    def step(self, count: int) -> None:
        step, space, timestep = lib.cpSpaceStep, self.space._space, self.timestep
        for _ in range(count):
            step(space, timestep)

    def read(self) -> Array:
        out = np.empty((len(self.bodies), STATE))
        for row, body in zip(out, self.bodies, strict=True):
            row[:] = *body.position, body.angle, *body.velocity, body.angular_velocity
        return out
