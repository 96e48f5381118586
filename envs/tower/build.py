"""tower_v0's scene, from the numbers of scene.py."""

from __future__ import annotations

from gsenv.envs.stack import build
from gsenv.envs.stack import scene as stack
from gsenv.envs.tower.scene import (
    AGENTS,
    GRIPPER_COLORS,
    MAST_COLORS,
    MAX_BLOCKS,
    PLINTH_COLOR,
    PLINTH_HALF_WIDTH,
    PLINTH_HEIGHT,
    RAIL_HALF_WIDTH,
)
from gsenv.solver import Scene
from gsenv.solver.planar import Box, HalfPlane, Weld


def build_scene() -> Scene:
    """Return the scene: ground, plinth, gantry, two grippers, and all blocks, which are parked and disabled."""
    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane(friction=0.8)])
    plinth = Box(half_extents=(PLINTH_HALF_WIDTH, PLINTH_HEIGHT / 2), friction=0.8)
    scene.add_body("plinth", "static", [plinth], position=(0.0, PLINTH_HEIGHT / 2), color=PLINTH_COLOR)
    rail = Box(half_extents=(RAIL_HALF_WIDTH, 0.05), mask=stack.NOTHING)
    scene.add_body("rail", "static", [rail], position=(0.0, stack.RAIL_Y))
    places = (-1.5, 1.5)
    for agent, x, color in zip(AGENTS, places, MAST_COLORS, strict=True):
        build.add_mast(scene, f"mast_{agent}", x, color)
    grippers = [
        build.add_gripper(scene, f"gripper_{agent}", x, color)
        for agent, x, color in zip(AGENTS, places, GRIPPER_COLORS, strict=True)
    ]
    blocks = [build.add_block(scene, k) for k in range(MAX_BLOCKS)]
    drives = [build.add_drive(scene, f"drive_{agent}", grippers[a]) for a, agent in enumerate(AGENTS)]
    for k, block in enumerate(blocks):
        scene.add_joint(f"grip_{k}", Weld(grippers[k % 2], block, collide=True, enabled=False))
    for agent, drive in zip(AGENTS, drives, strict=True):
        build.add_actuators(scene, drive, f"_{agent}")
    return scene
