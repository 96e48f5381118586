"""GStack's, tower_v0's and GStack3D's quantities that may be randomised, and how a world takes them on."""

from __future__ import annotations

from gsenv.envs.core.arguments import Quantity
from gsenv.solver.core.edit import set_mass
from gsenv.solver.jit import njit

QUANTITIES = (
    Quantity("friction", "friction of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("mass", "mass of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("force", "bounds of the gripper's drive, times", 1.0, 0.5, 3.0),
    Quantity("gravity", "gravity", 9.81, 0.5, 30.0, "m/s^2"),
)


@njit
def apply_physics(physics, parameters, first_block, first_shape, block_count, drive_count):  # type: ignore[no-untyped-def]
    """Quantities of the episode into a world's parameters whose blocks have just been made.

    Joints 0 to drive_count - 1 are drives; the last axis is vertical.
    """
    friction, mass, force, gravity = physics[0], physics[1], physics[2], physics[3]
    for k in range(block_count):
        shape = parameters.shapes[first_shape + k]
        shape.friction *= friction
        shape.density *= mass
        body = parameters.bodies[first_block + k]
        set_mass(body, body.mass * mass)
    for j in range(drive_count):
        parameters.joints[j].max_force *= force
        parameters.joints[j].max_torque *= force
    vertical = len(parameters.world.gravity) - 1
    parameters.world.gravity[vertical] = -gravity
