"""Stacks and pyramids of boxes."""

from __future__ import annotations

from gsenv.solver import Scene
from gsenv.solver.planar import Box, HalfPlane


def ground(scene: Scene, friction: float = 0.5, restitution: float = 0.0) -> None:
    """Add a static half-plane y <= 0."""
    plane = HalfPlane(normal=(0.0, 1.0), friction=friction, restitution=restitution)
    scene.add_body("ground", kind="static", shapes=[plane])


def stack(count: int = 10, size: float = 1.0, friction: float = 0.5) -> Scene:
    """Build a stack of ``count`` square boxes of side ``size`` m and density 1 kg/m^2, exactly touching."""
    scene = Scene()
    ground(scene, friction)
    half = 0.5 * size
    for k in range(count):
        box = Box(half_extents=(half, half), friction=friction)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.0, half + k * size))
    return scene


def mass_ratio_stack(ratio: float = 1000.0) -> Scene:
    """Build a box of side 1 m and ``ratio`` kg on a box of side 1 m and 1 kg."""
    scene = Scene()
    ground(scene)
    for k, mass in enumerate((1.0, ratio)):
        box = Box(half_extents=(0.5, 0.5), friction=0.5)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.0, 0.5 + k), mass=mass)
    return scene


def pyramid(base: int = 10, pitch: float = 1.05) -> Scene:
    """Build a pyramid of boxes of side 1 m, ``pitch`` m apart.

    The lowest row has ``base`` of them, each row above one fewer.
    """
    scene = Scene()
    ground(scene)
    for row in range(base):
        for k in range(base - row):
            x = (k - 0.5 * (base - row - 1)) * pitch
            box = Box(half_extents=(0.5, 0.5), friction=0.5)
            scene.add_body(f"box_{row}_{k}", shapes=[box], position=(x, 0.5 + row))
    return scene


def overhang(count: int = 5, fraction: float = 0.99, length: float = 2.0) -> Scene:
    """Build blocks of ``length`` m on a pedestal, each shifted by fraction * length / (2 i) over the one below.

    The index i counts from the top. At ``fraction`` 1, all blocks above an edge exactly balance on it.
    """
    scene = Scene()
    height = 0.4
    pedestal = Box(half_extents=(0.5 * length, 2.0), friction=0.6)
    scene.add_body("pedestal", kind="static", shapes=[pedestal], position=(0.0, -2.0))
    x = 0.0
    for k in range(count):
        x += fraction * length / (2.0 * (count - k))
        block = Box(half_extents=(0.5 * length, 0.5 * height), friction=0.6)
        scene.add_body(f"block_{k}", shapes=[block], position=(x, (k + 0.5) * height))
    return scene
