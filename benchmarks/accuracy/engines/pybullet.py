"""PyBullet (Bullet 3) behind the common interface: the same bodies, shapes and masses as in our Model.

Friction and restitution multiply in Bullet: a friction is given as its square root, static shapes are fully elastic.
Its default damping of velocities is taken off.

Settings: iterations; maximal: plain rigid bodies in place of Featherstone's; erp: part of an overlap taken back per
step; slop: overlap that is left alone; cone: friction as a cone, in place of two directions. Linkages are
Featherstone's with spherical joints.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import metadata
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import BodyKind, Model
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE, SPHERE

from ..geometry3d import conjugate, multiply, rotated
from ..trajectory import STATE3, ball_joints
from . import Setting, touching_shapes

Array = NDArray[np.float64]


@contextmanager
def quiet() -> Iterator[None]:
    """Bullet prints where it was built whenever it is loaded."""
    sys.stdout.flush()
    kept, sink = os.dup(1), os.open(os.devnull, os.O_WRONLY)
    os.dup2(sink, 1)
    try:
        yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
        os.close(sink)


with quiet():
    import pybullet


def version() -> str:
    return metadata.version("pybullet")


def xyzw(q: Array) -> list[float]:
    return [float(q[1]), float(q[2]), float(q[3]), float(q[0])]


class Simulation:
    """A physics server inside this process; one call of stepSimulation for each step."""

    client = -1

    def __init__(self, model: Model, setting: Setting) -> None:
        values = setting.values
        self.source, self.values = model, values
        if Simulation.client >= 0:
            pybullet.disconnect(Simulation.client)  # servers are few
        Simulation.client = self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(*map(float, model.nominal_world["gravity"]), physicsClientId=self.client)
        pybullet.setPhysicsEngineParameter(
            fixedTimeStep=setting.timestep,
            numSolverIterations=values["iterations"],
            numSubSteps=0,
            erp=values.get("erp", 0.2),
            contactERP=values.get("erp", 0.2),
            frictionERP=values.get("erp", 0.2),
            contactSlop=values.get("slop", 1e-5),
            enableConeFriction=int(values.get("cone", False)),
            restitutionVelocityThreshold=1e-3,
            solverResidualThreshold=values.get("residual", 0.0),
            deterministicOverlappingPairs=1,
            physicsClientId=self.client,
        )
        self.parent = {int(model.joints["body_b"][j]): int(j) for j in ball_joints(model)}
        self.places: list[tuple[int, int]] = [(-1, -1)] * len(model.bodies)  # (Bullet's body, its link)
        for index in range(len(model.bodies)):
            if index not in self.parent:
                self._tree(index)

    def _shape(self, index: int) -> int:
        shapes = touching_shapes(self.source, index)
        if not shapes:
            return -1
        (only,) = shapes
        kind, shape = int(self.source.shapes["kind"][only]), self.source.nominal_shapes[only]
        origin = self.source.nominal_bodies["center"][index]
        if index in self.parent:  # a link's frame is at its joint
            origin = self.source.nominal_joints[self.parent[index]]["anchor_b"]
        place = {
            "collisionFramePosition": (shape["local_position"] - origin).tolist(),
            "collisionFrameOrientation": xyzw(shape["local_rotation"]),
        }
        if kind == SPHERE:
            form: dict[str, Any] = {"shapeType": pybullet.GEOM_SPHERE, "radius": float(shape["radius"]), **place}
        elif kind == BOX:
            form = {"shapeType": pybullet.GEOM_BOX, "halfExtents": shape["size"].tolist(), **place}
        elif kind == CYLINDER:
            form = {
                "shapeType": pybullet.GEOM_CYLINDER, "radius": float(shape["radius"]),
                "height": 2.0 * float(shape["size"][2]), **place,
            }  # fmt: skip
        elif kind == PLANE:
            normal = rotated(shape["local_rotation"], np.array([0.0, 0.0, 1.0]))
            form = {"shapeType": pybullet.GEOM_PLANE, "planeNormal": normal.tolist()}
        else:
            raise ValueError(f"shape {self.source.shape_names[only]!r}: the benchmark has no such shapes.")
        return int(pybullet.createCollisionShape(**form, physicsClientId=self.client))

    def _chain(self, root: int) -> list[int]:
        """The bodies that hang from ``root``, parents first."""
        out = [root]
        for body in out:
            out += [b for b, j in self.parent.items() if int(self.source.joints["body_a"][j]) == body]
        return out[1:]

    def _tree(self, root: int) -> None:
        start, nominal = self.source.start_bodies[root], self.source.nominal_bodies[root]
        links = self._chain(root)
        dynamic = self.source.bodies["kind"][root] == BodyKind.DYNAMIC
        number = pybullet.createMultiBody(
            baseMass=float(nominal["mass"]) if dynamic else 0.0,
            baseCollisionShapeIndex=self._shape(root),
            basePosition=start["position"].tolist(),
            baseOrientation=xyzw(start["rotation"]),
            useMaximalCoordinates=int(self.values.get("maximal", False) and not links),
            flags=pybullet.URDF_USE_SELF_COLLISION if links else 0,
            physicsClientId=self.client,
            **self._links(root, links),
        )
        self.places[root] = (number, -1)
        for k, body in enumerate(links):
            self.places[body] = (number, k)
            free = {"targetPosition": [0, 0, 0, 1], "positionGain": 0, "velocityGain": 0, "force": [0, 0, 0]}
            pybullet.setJointMotorControlMultiDof(
                number, k, pybullet.POSITION_CONTROL, **free, physicsClientId=self.client
            )
        for body in (root, *links):
            self._dynamics(body)
        if dynamic:
            velocity = start["velocity"].tolist()
            pybullet.resetBaseVelocity(number, velocity[:3], velocity[3:], physicsClientId=self.client)

    def _links(self, root: int, links: list[int]) -> dict[str, Any]:
        """A link's frame is at its joint; its centre of mass, and its shape, where the anchor says."""
        model = self.source
        out: dict[str, list[Any]] = {name: [] for name in LINK_WORDS}
        for body in links:
            joint = self.parent[body]
            above = int(model.joints["body_a"][joint])
            anchors = model.nominal_joints[joint]
            # the parent link's frame is at its own joint, a base's at its centre of mass
            origin = np.zeros(3) if above == root else model.nominal_joints[self.parent[above]]["anchor_b"]
            back = conjugate(model.start_bodies[above]["rotation"])
            turn = multiply(back, model.start_bodies[body]["rotation"])
            out["linkMasses"].append(float(model.nominal_bodies[body]["mass"]))
            out["linkCollisionShapeIndices"].append(self._shape(body))
            out["linkVisualShapeIndices"].append(-1)
            out["linkPositions"].append((anchors["anchor_a"] - origin).tolist())
            out["linkOrientations"].append(xyzw(turn))
            out["linkInertialFramePositions"].append((-anchors["anchor_b"]).tolist())
            out["linkInertialFrameOrientations"].append([0, 0, 0, 1])
            out["linkParentIndices"].append(0 if above == root else links.index(above) + 1)
            out["linkJointTypes"].append(pybullet.JOINT_SPHERICAL)
            out["linkJointAxis"].append([0, 0, 1])
        return out if links else {}

    def _dynamics(self, body: int) -> None:
        model = self.source
        number, link = self.places[body]
        shapes = touching_shapes(model, body)
        static = model.bodies["kind"][body] == BodyKind.STATIC
        changes: dict[str, Any] = {"linearDamping": 0.0, "angularDamping": 0.0, "jointDamping": 0.0}
        if shapes:
            shape = model.nominal_shapes[shapes[0]]
            changes["lateralFriction"] = math.sqrt(float(shape["friction"]))
            changes["restitution"] = 1.0 if static else float(shape["restitution"])
            changes["rollingFriction"] = changes["spinningFriction"] = 0.0
        if not static:
            changes["mass"] = float(model.nominal_bodies[body]["mass"])
            changes["localInertiaDiagonal"] = model.nominal_bodies[body]["inertia"].tolist()
        pybullet.changeDynamics(number, link, **changes, physicsClientId=self.client)

    def step(self, count: int) -> None:
        step, client = pybullet.stepSimulation, self.client
        for _ in range(count):
            step(client)

    def read(self) -> Array:
        out = np.empty((len(self.places), STATE3))
        for row, (number, link) in zip(out, self.places, strict=True):
            if link < 0:
                place, turn = pybullet.getBasePositionAndOrientation(number, physicsClientId=self.client)
                velocity, spin = pybullet.getBaseVelocity(number, physicsClientId=self.client)
            else:
                state = pybullet.getLinkState(number, link, 1, 1, physicsClientId=self.client)
                place, turn, velocity, spin = state[0], state[1], state[6], state[7]
            row[0:3], row[3:7] = place, (turn[3], *turn[:3])
            row[7:10], row[10:13] = velocity, spin
        return out


LINK_WORDS = (
    "linkMasses", "linkCollisionShapeIndices", "linkVisualShapeIndices", "linkPositions", "linkOrientations",
    "linkInertialFramePositions", "linkInertialFrameOrientations", "linkParentIndices", "linkJointTypes",
    "linkJointAxis",
)  # fmt: skip
