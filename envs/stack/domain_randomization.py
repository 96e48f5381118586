"""GStack's, tower_v0's and GStack3D's quantities that may be randomised; see `shared_rules.apply_physics`."""

from __future__ import annotations

from gsenv.envs.core.arguments import Quantity

QUANTITIES = (
    Quantity("friction", "friction of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("mass", "mass of all blocks, times", 1.0, 0.1, 3.0),
    Quantity("force", "bounds of the gripper's drive, times", 1.0, 0.5, 3.0),
    Quantity("gravity", "gravity", 9.81, 0.5, 30.0, "m/s^2"),
)
