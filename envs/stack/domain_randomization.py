"""Quantities of GStack, tower_v0 and GStack3D that may be randomised; `shared_rules.apply_physics` applies them."""

from __future__ import annotations

from gsenv.envs.core.arguments import Quantity

QUANTITIES = (
    Quantity("friction", "factor of the friction of all blocks", 1.0, 0.1, 3.0),
    Quantity("mass", "factor of the mass of all blocks", 1.0, 0.1, 3.0),
    Quantity("force", "factor of the force and torque bounds of the gripper's drive", 1.0, 0.5, 3.0),
    Quantity("gravity", "gravity", 9.81, 0.5, 30.0, "m/s^2"),
)
