"""MuJoCo behind the common interface: the same bodies, shapes, masses and joints as in our Model.

Bodies on ball joints are nested in a tree, MuJoCo's own way, so that its joints cannot open; others are free. Friction
coefficients are equal on both sides in all scenes, so that MuJoCo's larger one is gsenv's mean. MuJoCo has no
restitution: where it is asked for, contacts are springs whose damping ratio gives it (solref in its direct form,
solimp all but 1), ``contact_steps`` timesteps to a bounce.

Settings: integrator; cone; solver, iterations; timeconst: solref's, in timesteps (2 is its floor); dmax: of solimp,
both ends; noslip: iterations; contact_steps: see above.
"""

from __future__ import annotations

import math

import mujoco
import numpy as np
from numpy.typing import NDArray

from gsenv.solver.records.model import BodyKind, Model
from gsenv.solver.spatial.kinds import BOX, CYLINDER, PLANE, SPHERE

from ..geometry3d import conjugate, multiply, rotated
from ..trajectory import STATE3, ball_joints
from . import Setting, touching_shapes

Array = NDArray[np.float64]
INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}
SOLVERS = {"Newton": mujoco.mjtSolver.mjSOL_NEWTON, "CG": mujoco.mjtSolver.mjSOL_CG, "PGS": mujoco.mjtSolver.mjSOL_PGS}
CONES = {"elliptic": mujoco.mjtCone.mjCONE_ELLIPTIC, "pyramidal": mujoco.mjtCone.mjCONE_PYRAMIDAL}
GEOMS = {
    SPHERE: mujoco.mjtGeom.mjGEOM_SPHERE,
    BOX: mujoco.mjtGeom.mjGEOM_BOX,
    CYLINDER: mujoco.mjtGeom.mjGEOM_CYLINDER,
    PLANE: mujoco.mjtGeom.mjGEOM_PLANE,
}
STIFF = 0.9999  # of solimp where contacts are springs of their own


def version() -> str:
    return str(mujoco.__version__)


class Simulation:
    """An mjModel and its mjData; one call takes any number of steps."""

    def __init__(self, model: Model, setting: Setting) -> None:
        self.setting, self.source = setting, model
        spec = mujoco.MjSpec()
        self._options(spec, model)
        self.made: dict[int, mujoco.MjsBody] = {}
        self.tree: dict[int, int] = {}  # joint by body_b
        for j in ball_joints(model):
            self.tree[int(model.joints["body_b"][j])] = int(j)
        for index in range(len(model.bodies)):
            self._body(spec, index)
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        self.rows = np.array([self.model.body(f"b{i}").id for i in range(len(model.bodies))])
        self._start()

    def _options(self, spec: mujoco.MjSpec, model: Model) -> None:
        values, option = self.setting.values, spec.option
        option.timestep = self.setting.timestep
        option.gravity = model.nominal_world["gravity"]
        option.integrator = INTEGRATORS[values["integrator"]]
        option.cone = CONES[values.get("cone", "pyramidal")]
        option.solver = SOLVERS[values.get("solver", "Newton")]
        option.iterations = values.get("iterations", 100)
        option.noslip_iterations = values.get("noslip", 0)
        option.impratio = values.get("impratio", 1.0)

    def _body(self, spec: mujoco.MjSpec, index: int) -> None:
        model, start = self.source, self.source.start_bodies[index]
        place, turn = start["position"].copy(), start["rotation"].copy()
        parent = spec.worldbody
        joint = self.tree.get(index)
        if joint is not None:
            other = int(model.joints["body_a"][joint])
            parent = self.made[other]
            back = conjugate(model.start_bodies[other]["rotation"])
            place = rotated(back, place - model.start_bodies[other]["position"])
            turn = multiply(back, turn)
        body = self.made[index] = parent.add_body(name=f"b{index}", pos=place, quat=turn)
        if model.bodies["kind"][index] == BodyKind.DYNAMIC:
            nominal = model.nominal_bodies[index]
            body.explicitinertial = True
            body.mass = float(nominal["mass"])
            body.inertia = nominal["inertia"]
            body.ipos, body.iquat = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0)  # else they become pos and quat
            if joint is None:
                body.add_freejoint()
            else:
                anchor = model.nominal_joints[joint]["anchor_b"] - nominal["center"]
                body.add_joint(type=mujoco.mjtJoint.mjJNT_BALL, pos=anchor)
        for shape in touching_shapes(model, index):
            self._geom(body, index, shape)

    def _geom(self, body: mujoco.MjsBody, owner: int, index: int) -> None:
        kind, shape = int(self.source.shapes["kind"][index]), self.source.nominal_shapes[index]
        if kind not in GEOMS:
            raise ValueError(f"shape {self.source.shape_names[index]!r}: the benchmark has no such shapes.")
        size = {
            SPHERE: (shape["radius"], 0.0, 0.0),
            BOX: tuple(shape["size"]),
            CYLINDER: (shape["radius"], shape["size"][2], 0.0),
            PLANE: (0.0, 0.0, 1.0),
        }[kind]
        values = self.setting.values
        dmax = values.get("dmax", 0.95)
        geom = body.add_geom(
            type=GEOMS[kind],
            size=size,
            pos=shape["local_position"] - self.source.nominal_bodies["center"][owner],
            quat=shape["local_rotation"],
            friction=(float(shape["friction"]), 0.0, 0.0),
            condim=3 if shape["friction"] > 0.0 else 1,
            solref=(values.get("timeconst", 2.0) * self.setting.timestep, 1.0),
            solimp=(min(values.get("dmin", 0.9), dmax), dmax, 0.001, 0.5, 2.0),
        )
        bounce = float(self.source.nominal_shapes["restitution"].max())
        if bounce > 0.0:
            geom.solref = spring(bounce, values.get("contact_steps", 8.0) * self.setting.timestep)
            geom.solimp = (STIFF, STIFF, 0.001, 0.5, 2.0)

    def _start(self) -> None:
        """Velocities of free joints: linear in the world, angular in the body; of ball joints, the latter alone."""
        model, data = self.source, self.data
        mujoco.mj_forward(self.model, data)
        for index in np.flatnonzero(model.bodies["kind"] == BodyKind.DYNAMIC).tolist():
            start = model.start_bodies[index]
            velocity = start["velocity"]
            if not velocity.any():
                continue
            first = self.model.jnt_dofadr[self.model.body_jntadr[self.rows[index]]]
            if index in self.tree:
                if model.bodies["kind"][model.joints["body_a"][self.tree[index]]] != BodyKind.STATIC:
                    raise ValueError("the benchmark's linkages start at rest but for what is held by a static body.")
            else:
                data.qvel[first : first + 3] = velocity[:3]
                first += 3
            data.qvel[first : first + 3] = rotated(conjugate(start["rotation"]), velocity[3:])
        mujoco.mj_forward(self.model, data)

    def step(self, count: int) -> None:
        mujoco.mj_step(self.model, self.data, count)

    def read(self) -> Array:
        mujoco.mj_forward(self.model, self.data)  # poses and velocities of the end of the step
        out = np.zeros((len(self.rows), STATE3))
        velocity = np.zeros(6)
        for row, body in zip(out, self.rows, strict=True):
            row[0:3] = self.data.xpos[body]
            row[3:7] = self.data.xquat[body]
            mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_BODY, body, velocity, 0)
            row[7:10], row[10:13] = velocity[3:], velocity[:3]
        return out


def spring(restitution: float, duration: float) -> tuple[float, float]:
    """solref in its direct form, (-stiffness, -damping) per unit of mass: a bounce of ``duration`` s that keeps
    ``restitution`` of the speed."""
    log = -math.log(restitution)
    damping_ratio = log / math.hypot(math.pi, log)
    omega = math.pi / (duration * math.sqrt(1.0 - damping_ratio**2))
    return -(omega**2) * STIFF, -2.0 * damping_ratio * omega
