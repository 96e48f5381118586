"""GStack's scene, from the numbers of scene.py."""

from __future__ import annotations

from gsenv.envs.stack.scene import (
    COLORS,
    GRIPPER_INERTIA,
    GRIPPER_MASS,
    HALF_HEIGHT,
    HALF_WIDTH,
    MAGNET_RADIUS,
    MAST_COLOR,
    MAST_HALF_LENGTH,
    MAX_BLOCKS,
    MAX_FORCE,
    MAX_TORQUE,
    NOTHING,
    PARKED_Y,
    RAIL_Y,
    SPEED,
    START_Y,
    STEEL,
    TURN_SPEED,
    Color,
)
from gsenv.solver import Handle, Scene
from gsenv.solver.planar import Box, Circle, HalfPlane, Target, Weld


def build_scene() -> Scene:
    """Return the scene: ground, gantry, gripper, and all blocks, which are parked and disabled."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.8)])
    rail = Box(half_extents=(2.6, 0.05), mask=NOTHING)
    scene.add_body("rail", "static", [rail], position=(0.0, RAIL_Y))
    add_mast(scene, "mast", 0.0, MAST_COLOR)
    gripper = add_gripper(scene, "gripper", 0.0, STEEL)
    blocks = [add_block(scene, k) for k in range(MAX_BLOCKS)]
    drive = add_drive(scene, "drive", gripper)
    for k, block in enumerate(blocks):
        scene.add_joint(f"grip_{k}", Weld(gripper, block, collide=True, enabled=False))
    add_actuators(scene, drive, "")
    return scene


def add_mast(scene: Scene, name: str, x: float, color: Color) -> None:
    mast = Box(half_extents=(0.035, MAST_HALF_LENGTH), mask=NOTHING)
    scene.add_body(name, "kinematic", [mast], position=(x, START_Y[0]), color=color)


def add_gripper(scene: Scene, name: str, x: float, color: Color) -> Handle:
    return scene.add_body(
        name,
        shapes=[
            Circle(radius=MAGNET_RADIUS, friction=0.3, name="magnet"),
            Box(half_extents=(0.10, 0.045), position=(0.0, 0.11), density=0.0, name="wrist"),
            Box(half_extents=(0.055, 0.03), position=(0.0, 0.185), density=0.0, name="collar"),
        ],
        position=(x, START_Y[0]),
        mass=GRIPPER_MASS,
        inertia=GRIPPER_INERTIA,
        gravity_scale=0.0,
        color=color,
    )


def add_block(scene: Scene, k: int) -> Handle:
    """Add block k, parked and disabled."""
    return scene.add_body(
        f"block_{k}",
        shapes=[Box(half_extents=(HALF_WIDTH[1], HALF_HEIGHT[1]))],
        position=(2.0 * k, PARKED_Y),
        enabled=False,
        color=COLORS[k],
    )


def add_drive(scene: Scene, name: str, gripper: Handle) -> Handle:
    return scene.add_joint(
        name, Target(gripper, frequency=6.0, damping_ratio=1.5, max_force=MAX_FORCE, max_torque=MAX_TORQUE)
    )


def add_actuators(scene: Scene, drive: Handle, suffix: str) -> None:
    """Add the actuators that `blocks.steer` sets, in its order."""
    scene.add_actuator(f"move_x{suffix}", drive, "x", "velocity", -SPEED, SPEED)
    scene.add_actuator(f"move_y{suffix}", drive, "y", "velocity", -SPEED, SPEED)
    scene.add_actuator(f"turn{suffix}", drive, "angle", "velocity", -TURN_SPEED, TURN_SPEED)
