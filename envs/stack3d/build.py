"""GStack3D's scene, from the numbers of scene.py."""

from __future__ import annotations

from gsenv.envs.stack.scene import COLORS, MAST_COLOR, STEEL
from gsenv.envs.stack3d.scene import (
    GRIPPER_INERTIA,
    GRIPPER_MASS,
    HALF_HEIGHT,
    HALF_WIDTH,
    MAST_HALF_LENGTH,
    MAX_BLOCKS,
    MAX_FORCE,
    MAX_TORQUE,
    NOTHING,
    PAD_HEIGHT,
    PAD_WIDTH,
    PARKED_Z,
    SPEED,
    START_Z,
    TURN_SPEED,
)
from gsenv.solver import Handle, Scene
from gsenv.solver.spatial import Box, Plane, Target, Weld


def build_scene() -> Scene:
    """Return the scene: ground, mast, gripper, and all blocks, which are parked and disabled."""
    scene = Scene(dim=3)
    scene.add_body("ground", "static", [Plane(friction=0.8)])
    mast = Box(half_extents=(0.03, 0.03, MAST_HALF_LENGTH), mask=NOTHING)
    scene.add_body("mast", "kinematic", [mast], position=(0.0, 0.0, START_Z[0]), color=MAST_COLOR)
    gripper = _add_gripper(scene)
    blocks = [_add_block(scene, k) for k in range(MAX_BLOCKS)]
    drive = scene.add_joint(
        "drive", Target(gripper, frequency=6.0, damping_ratio=1.5, max_force=MAX_FORCE, max_torque=MAX_TORQUE)
    )
    for k, block in enumerate(blocks):
        scene.add_joint(f"grip_{k}", Weld(gripper, block, collide=True, enabled=False))
    for axis in ("x", "y", "z"):
        scene.add_actuator(f"move_{axis}", drive, axis, "velocity", -SPEED, SPEED)
    scene.add_actuator("turn", drive, "turn_z", "velocity", -TURN_SPEED, TURN_SPEED)
    return scene


def _add_gripper(scene: Scene) -> Handle:
    return scene.add_body(
        "gripper",
        shapes=[
            Box(half_extents=(PAD_WIDTH, PAD_WIDTH, PAD_HEIGHT), friction=0.3, name="pad"),
            Box(half_extents=(0.045, 0.045, 0.065), position=(0.0, 0.0, 0.085), density=0.0, name="wrist"),
        ],
        position=(0.0, 0.0, START_Z[0]),
        mass=GRIPPER_MASS,
        inertia=(GRIPPER_INERTIA,) * 3,
        gravity_scale=0.0,
        color=STEEL,
    )


def _add_block(scene: Scene, k: int) -> Handle:
    """Add block k, parked and disabled."""
    return scene.add_body(
        f"block_{k}",
        shapes=[Box(half_extents=(HALF_WIDTH[1], HALF_WIDTH[1], HALF_HEIGHT[1]))],
        position=(2.0 * k, 0.0, PARKED_Z),
        enabled=False,
        color=COLORS[k],
    )
