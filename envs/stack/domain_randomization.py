"""Quantities of GStack, tower_v0 and GStack3D that may be randomised, and their effect on a world's parameters."""

from __future__ import annotations

from gsenv.envs.core.arguments import Quantity
from gsenv.solver.core.edit import set_mass
from gsenv.solver.jit import njit

QUANTITIES = (
    Quantity("friction", "factor of the friction of all blocks", 1.0, 0.1, 3.0),
    Quantity("mass", "factor of the mass of all blocks", 1.0, 0.1, 3.0),
    Quantity("force", "factor of the force and torque bounds of the gripper's drive", 1.0, 0.5, 3.0),
    Quantity("gravity", "gravity", 9.81, 0.5, 30.0, "m/s^2"),
)


@njit
def apply_physics(physics, parameters, first_block, first_shape, block_count, drive_count):  # type: ignore[no-untyped-def]
    """Write the quantities of the episode to the parameters of a world whose blocks have just been made.

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
