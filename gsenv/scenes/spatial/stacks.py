"""Stacks, pyramids and walls of boxes."""

from __future__ import annotations

from gsenv.solver import Scene
from gsenv.solver.spatial import Box, Plane, Sphere

from ..palette import BRICK, GRAPHITE


def ground(scene: Scene, friction: float = 0.5, restitution: float = 0.0) -> None:
    """Add a static half-space z <= 0."""
    plane = Plane(normal=(0.0, 0.0, 1.0), friction=friction, restitution=restitution)
    scene.add_body("ground", kind="static", shapes=[plane])


def cube_stack(count: int = 10, size: float = 1.0, friction: float = 0.5) -> Scene:
    """Build a stack of ``count`` cubes of side ``size`` m and density 1 kg/m^3, exactly touching."""
    scene = Scene(dim=3)
    ground(scene, friction)
    half = 0.5 * size
    for k in range(count):
        box = Box(half_extents=(half, half, half), friction=friction, density=1.0)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.0, 0.0, half + k * size))
    return scene


def cube_mass_ratio(ratio: float = 1000.0) -> Scene:
    """Build a cube of side 1 m and ``ratio`` kg on a cube of side 1 m and 1 kg."""
    scene = Scene(dim=3)
    ground(scene)
    for k, mass in enumerate((1.0, ratio)):
        box = Box(half_extents=(0.5, 0.5, 0.5), friction=0.5)
        scene.add_body(f"box_{k}", shapes=[box], position=(0.0, 0.0, 0.5 + k), mass=mass)
    return scene


def cube_pyramid(base: int = 10, pitch: float = 1.05) -> Scene:
    """Build a flat pyramid of cubes of side 1 m, ``pitch`` m apart.

    The lowest row has ``base`` of them, each row above one fewer.
    """
    scene = Scene(dim=3)
    ground(scene)
    for row in range(base):
        for k in range(base - row):
            x = (k - 0.5 * (base - row - 1)) * pitch
            box = Box(half_extents=(0.5, 0.5, 0.5), friction=0.5, density=1.0)
            scene.add_body(f"box_{row}_{k}", shapes=[box], position=(x, 0.0, 0.5 + row))
    return scene


def brick_wall(rows: int = 8, columns: int = 10, half: tuple[float, float, float] = (0.25, 0.125, 0.1)) -> Scene:
    """Build a brick wall along x; every other row is shifted by half a brick and has half bricks at its ends."""
    scene = Scene(dim=3)
    ground(scene, friction=0.6)
    for row in range(rows):
        x = -half[0] * columns
        for k in range(columns + row % 2):
            short = row % 2 and k in (0, columns)
            length = 0.5 * half[0] if short else half[0]
            brick = Box(half_extents=(length, half[1], half[2]), friction=0.6, density=2.0)
            position = (x + length, 0.0, half[2] * (2 * row + 1))
            scene.add_body(f"brick_{row}_{k}", shapes=[brick], position=position, color=BRICK[(2 * row + k) % 3])
            x += 2.0 * length
    return scene


def brick_wall_hit(speed: float = 15.0, radius: float = 0.3, rows: int = 8, columns: int = 10) -> Scene:
    """Build the same wall and a heavy ball that flies into it at ``speed`` m/s."""
    scene = brick_wall(rows, columns)
    ball = Sphere(radius=radius, density=8.0, friction=0.5)
    scene.add_body(
        "ball",
        shapes=[ball],
        position=(0.1, -4.0, 0.9),
        linear_velocity=(0.0, speed, 0.5),
        continuous=True,
        color=GRAPHITE,
    )
    return scene


def block_overhang(count: int = 5, fraction: float = 0.99, length: float = 2.0) -> Scene:
    """Build blocks of ``length`` m on a pedestal, each shifted by fraction * length / (2 i) along x over the one below.

    The index i counts from the top. At ``fraction`` 1, all blocks above an edge exactly balance on it.
    """
    scene = Scene(dim=3)
    height, depth = 0.4, 0.4
    pedestal = Box(half_extents=(0.5 * length, depth, 2.0), friction=0.6)
    scene.add_body("pedestal", kind="static", shapes=[pedestal], position=(0.0, 0.0, -2.0))
    x = 0.0
    for k in range(count):
        x += fraction * length / (2.0 * (count - k))
        block = Box(half_extents=(0.5 * length, depth, 0.5 * height), friction=0.6)
        scene.add_body(f"block_{k}", shapes=[block], position=(x, 0.0, (k + 0.5) * height))
    return scene
