"""Box2D behind the common interface: the same bodies, shapes, masses and joints as in our Model.

Box2D keeps polygons apart by a skin of ``b2_polygonRadius`` around each, and lets contacts overlap by
``b2_linearSlop`` before it corrects them. The shapes are made smaller by the skin, as its manual
advises, so that skins touch where the true shapes do ("skin" 1), or by the skin less half the slop, so
that the overlap it aims at is reached where the true shapes touch ("skin" .75). Friction combines
as the geometric mean and restitution as the maximum, as in gsenv.

Settings: velocity, position: iterations; skin: see above; scale: lengths in Box2D's world over those of
the scene (its slop and thresholds are absolute; 1 is what its manual tunes for); sleep.
"""

from __future__ import annotations

import Box2D
import numpy as np
from Box2D import (
    b2CircleShape,
    b2DistanceJointDef,
    b2FixtureDef,
    b2MassData,
    b2PolygonShape,
    b2RevoluteJointDef,
    b2World,
)
from numpy.typing import NDArray

from gsenv.solver.planar.kinds import BOX, CIRCLE, HALF_PLANE
from gsenv.solver.records.model import BodyKind, JointKind, Model

from ..trajectory import STATE
from . import Setting, touching_shapes

Array = NDArray[np.float64]
GROUND_HALF = (40.0, 2.0)  # m, of the box that stands for a half-plane


def version() -> str:
    return str(Box2D.__version__)


class Simulation:
    """A b2World; one call of its Step for each step."""

    def __init__(self, model: Model, setting: Setting) -> None:
        values = setting.values
        self.scale = values.get("scale", 1.0)
        self.arguments = (setting.timestep, values["velocity"], values["position"])
        gravity = self.scale * model.nominal_world["gravity"]
        self.world = b2World(gravity=tuple(map(float, gravity)))
        self.world.SetAllowSleeping(values.get("sleep", False))  # the constructor's argument has no effect
        self.world.warmStarting = True
        self.world.continuousPhysics = False  # nothing here is fast enough to pass through anything
        skin = values.get("skin", 1.0) * Box2D.b2_polygonRadius / self.scale
        self.bodies = [self._body(model, index, skin) for index in range(len(model.bodies))]
        for index in range(len(model.joints)):
            self._joint(model, index)

    def _body(self, model: Model, index: int, skin: float) -> Box2D.b2Body:
        start = model.start_bodies[index]
        velocity = self.scale * start["velocity"][:2]
        place = {"position": self._point(start["position"]), "angle": float(start["angle"])}
        if model.bodies["kind"][index] == BodyKind.STATIC:
            body = self.world.CreateStaticBody(**place)
        else:
            body = self.world.CreateDynamicBody(
                **place, linearVelocity=tuple(map(float, velocity)), angularVelocity=float(start["velocity"][2])
            )
        for shape in touching_shapes(model, index):
            self._fixture(body, model, shape, skin)
        nominal = model.nominal_bodies[index]
        if model.bodies["kind"][index] == BodyKind.DYNAMIC:
            inertia = self.scale**2 * float(nominal["inertia"])
            body.massData = b2MassData(mass=float(nominal["mass"]), center=(0.0, 0.0), I=inertia)
        return body

    def _point(self, point: Array) -> tuple[float, float]:
        return float(self.scale * point[0]), float(self.scale * point[1])

    def _fixture(self, body: Box2D.b2Body, model: Model, index: int, skin: float) -> None:
        kind, shape = model.shapes["kind"][index], model.nominal_shapes[index]
        c, s = shape["local_rotation"]
        center, angle = self._point(shape["local_position"]), float(np.arctan2(s, c))
        if kind == CIRCLE:
            form = b2CircleShape(pos=center, radius=self.scale * float(shape["radius"]))
        elif kind == BOX:
            form = b2PolygonShape(box=(*self._point(shape["size"] - skin), center, angle))
        elif kind == HALF_PLANE:
            down = shape["local_position"] - (GROUND_HALF[1] + skin) * np.array([-s, c])
            form = b2PolygonShape(box=(*self._point(np.array(GROUND_HALF)), self._point(down), angle))
        else:
            raise ValueError(f"shape {model.shape_names[index]!r}: the benchmark has boxes, circles and half-planes.")
        body.CreateFixture(
            b2FixtureDef(
                shape=form, density=1.0,
                friction=float(shape["friction"]), restitution=float(shape["restitution"]),
            )
        )  # fmt: skip

    def _joint(self, model: Model, index: int) -> None:
        joint, nominal = model.joints[index], model.nominal_joints[index]
        ends = {
            "bodyA": self.bodies[joint["body_a"]],
            "bodyB": self.bodies[joint["body_b"]],
            "localAnchorA": self._point(nominal["anchor_a"]),
            "localAnchorB": self._point(nominal["anchor_b"]),
        }
        if joint["kind"] == JointKind.REVOLUTE:
            self.world.CreateJoint(b2RevoluteJointDef(**ends))
        elif joint["kind"] == JointKind.DISTANCE:
            spring = {"frequencyHz": float(nominal["frequency"]), "dampingRatio": float(nominal["damping_ratio"])}
            self.world.CreateJoint(b2DistanceJointDef(**ends, length=self.scale * float(nominal["length"]), **spring))
        else:
            raise ValueError(f"joint {model.joint_names[index]!r}: the benchmark has hinges and springs.")

    def step(self, count: int) -> None:
        step, (timestep, velocity, position) = self.world.Step, self.arguments
        for _ in range(count):
            step(timestep, velocity, position)

    def read(self) -> Array:
        out = np.empty((len(self.bodies), STATE))
        for row, body in zip(out, self.bodies, strict=True):
            x, y = body.position
            vx, vy = body.linearVelocity
            row[:] = x, y, body.angle, vx, vy, body.angularVelocity
        out[:, [0, 1, 3, 4]] /= self.scale
        return out
