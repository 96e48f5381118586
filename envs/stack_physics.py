"""GStack's and tower_v0's quantities that may be randomised, and how a world takes them on."""

from __future__ import annotations

from gsenv.envs import stack_scene as scene
from gsenv.envs.arguments import Quantity
from gsenv.solver.jit import njit

QUANTITIES = (
    Quantity("friction", "friction of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("mass", "mass of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("force", "bounds of the gripper's drive, times", 1.0, 0.5, 3.0),
    Quantity("gravity", "gravity", 9.81, 0.5, 30.0, "m/s^2"),
)

_MAX_BLOCKS = scene.MAX_BLOCKS


@njit
def apply_physics(  # type: ignore[no-untyped-def]
    worlds, physics, world_parameters, body_parameters, shape_parameters, joint_parameters,
    first_block, first_shape, drives,
):  # fmt: skip
    """Physics (world, quantity) of worlds whose blocks have just been made; joints 0..drives-1 are drives."""
    for i in range(len(worlds)):
        w = worlds[i]
        friction, mass, force, gravity = physics[w, 0], physics[w, 1], physics[w, 2], physics[w, 3]
        for k in range(_MAX_BLOCKS):
            shape_parameters[w, first_shape + k].friction *= friction
            shape_parameters[w, first_shape + k].density *= mass
            body = body_parameters[w, first_block + k]
            body.mass *= mass
            body.inertia *= mass
            body.inv_mass /= mass
            body.inv_inertia /= mass
        for j in range(drives):
            joint_parameters[w, j].max_force *= force
            joint_parameters[w, j].max_torque *= force
        world_parameters[w].gravity[1] = -gravity
