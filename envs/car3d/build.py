"""GCar3D's scene, from the numbers of scene.py."""

from __future__ import annotations

import math

import numpy as np

from gsenv.envs.car3d import scene as n
from gsenv.scenes.palette import COOL, GRAPHITE, STEEL, WARM
from gsenv.solver import Scene
from gsenv.solver.spatial import Axis, Box, Capsule, Cylinder, Heightfield, Hull, Sphere, Wheel

ALONG_Y = (math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0)  # of a cylinder or capsule: its axis along y
GRASS, ASPHALT, PAINT = (136, 168, 108), (86, 92, 102), (238, 236, 226)
RED, GREEN = (214, 58, 52), (70, 172, 84)  # of a gate before and after it is passed
TYRE, GLASS = (44, 48, 56), (52, 66, 86)
NAMES = ("rear_left", "rear_right", "front_left", "front_right")
PARKED = (0.0, 0.0, n.PARKED_Z)


def build_scene() -> Scene:
    """Return the scene: level ground, the car at x = 0, all obstacles and gates parked and disabled."""
    scene = Scene(dim=3)
    field = Heightfield(heights=np.zeros((n.ROWS, n.COLUMNS)), size=(n.LAST_X - n.FIRST_X, 2.0 * n.HALF_DEPTH))
    scene.add_body("ground", "static", [field], position=(0.5 * (n.FIRST_X + n.LAST_X), 0.0, 0.0), color=GRASS)
    _add_finish(scene)
    _add_gates(scene)
    _add_obstacles(scene)
    _add_car(scene)
    ball = Sphere(radius=n.BALL_RADIUS)
    for k in range(n.BALL_GROUPS * n.GROUP_BALLS):
        scene.add_body(f"ball_{k}", shapes=[ball], position=PARKED, mass=n.BALL_MASS, enabled=False, color=WARM)
    return scene


def _decor(half_x: float, half_y: float, half_z: float, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Box:
    """Return a box that is only drawn."""
    return Box(half_extents=(half_x, half_y, half_z), position=(x, y, z), category=n.DECOR, mask=n.NOTHING)


def _arch(reach: float, height: float) -> list[Box]:
    """Return two posts, which reach into the ground, and a beam."""
    posts = [_decor(0.06, 0.06, 0.5 * height + 0.4, y=side * reach, z=0.5 * height - 0.4) for side in (-1.0, 1.0)]
    return [*posts, _decor(0.06, reach + 0.06, 0.06, z=height)]


def _add_finish(scene: Scene) -> None:
    """Add an arch with a checkered banner."""
    columns, rows = 10, 2
    dark: list[Box] = []
    light: list[Box] = []
    for i in range(columns):
        for j in range(rows):
            y, z = n.CHECK * (2 * i + 1 - columns), n.FINISH_HEIGHT - 0.06 - n.CHECK * (2 * j + 1)
            (dark if (i + j) % 2 else light).append(_decor(0.03, n.CHECK, n.CHECK, y=y, z=z))
    parts = (
        ("posts", _arch(n.FINISH_REACH, n.FINISH_HEIGHT), STEEL),
        ("dark", dark, GRAPHITE),
        ("light", light, PAINT),
    )
    for name, shapes, color in parts:
        scene.add_body(f"finish_{name}", "static", shapes, position=(n.FINISH, 0.0, 0.0), color=color)


def _add_gates(scene: Scene) -> None:
    """Add the arches, then their red and their green bars."""
    bar = [_decor(0.09, 1.3, 0.14, z=n.GATE_HEIGHT - 0.24)]
    for name, shapes, color in (
        ("arch", _arch(n.GATE_WIDTH + 0.2, n.GATE_HEIGHT), STEEL),
        ("red", bar, RED),
        ("green", bar, GREEN),
    ):
        for k in range(n.SLOTS):
            scene.add_body(f"gate_{k}_{name}", "static", shapes, position=PARKED, color=color, enabled=False)


def _add_obstacles(scene: Scene) -> None:
    corners = []
    for side in (-n.RAMP_HALF, n.RAMP_HALF):
        for x in (-1.0, 1.0):
            corners.append((x * n.RAMP_BASE, side, 0.0))
            corners.append((x * n.RAMP_TOP, side, n.RAMP_HEIGHT))
            corners.append((x * n.RAMP_BASE, side, -0.3))
    ramp = Hull(vertices=corners, friction=n.FRICTION)
    for k in range(n.RAMPS):
        scene.add_body(f"ramp_{k}", "static", [ramp], position=PARKED, enabled=False, color=COOL)
    bumps = [
        Capsule(
            half_length=n.ROAD_HALF - n.BUMP_RADIUS, radius=n.BUMP_RADIUS, orientation=ALONG_Y, friction=n.FRICTION,
            position=(n.BUMP_SPACING * (k - 1), 0.0, n.BUMP_HEIGHT - n.BUMP_RADIUS),
        )
        for k in range(n.GROUP_BUMPS)
    ]  # fmt: skip
    for k in range(n.BUMPS):
        scene.add_body(f"bumps_{k}", "static", bumps, position=PARKED, enabled=False, color=(236, 190, 70))


def _add_car(scene: Scene) -> None:
    """Add chassis and wheels, their joints and actuators, and the cabin, which is only drawn."""
    hull = Box(half_extents=(1.0, 0.42, 0.13), position=(0.0, 0.0, 0.08), friction=n.FRICTION)
    roof = Box(half_extents=(0.42, 0.34, 0.17), position=(-0.12, 0.0, 0.36), friction=n.FRICTION, density=0.0)
    scene.add_body(
        "chassis", shapes=[hull, roof], position=(0.0, 0.0, n.CHASSIS_Z), center=(0.0, 0.0, 0.0),
        mass=n.CHASSIS_MASS, inertia=(14.0, 52.0, 60.0), color=WARM,
    )  # fmt: skip
    tyre = Cylinder(half_length=n.WHEEL_HALF, radius=n.RADIUS, orientation=ALONG_Y, friction=n.FRICTION)
    for k, name in enumerate(NAMES):
        place = (-n.AXLES if k < 2 else n.AXLES, n.TRACK if k % 2 == 0 else -n.TRACK, n.RADIUS)
        scene.add_body(
            name, shapes=[tyre], position=place, mass=n.WHEEL_MASS, inertia=(n.WHEEL_INERTIA,) * 3, color=TYRE
        )
    for k, name in enumerate(NAMES):
        steering = Axis(stiffness=3000.0, damping=60.0, limits=(-1.2 * n.STEERING, 1.2 * n.STEERING))
        axle = Wheel(
            "chassis", name, axis=(0, 0, 1), spin_axis=(0, 1, 0), limits=(-n.TRAVEL, n.TRAVEL), stiffness=n.STIFFNESS,
            damping=n.DAMPING, rest=n.REST, motor_effort=n.TORQUE, steering=steering if k >= 2 else None,
        )  # fmt: skip
        scene.add_joint(f"{name}_axle", axle)
    for name in NAMES:
        scene.add_actuator(f"{name}_drive", f"{name}_axle", mode="velocity")
    for name in NAMES[2:]:
        scene.add_actuator(
            f"{name}_steering", f"{name}_axle/steering", mode="position", lower=-n.STEERING, upper=n.STEERING
        )
    cabin = [
        _decor(0.44, 0.36, 0.12, x=-0.12, z=0.33),
        _decor(0.36, 0.30, 0.02, x=-0.14, z=0.54),
        _decor(0.05, 0.30, 0.05, x=1.0, z=0.06),
        _decor(0.12, 0.44, 0.02, x=-1.0, z=0.36),
        *(_decor(0.02, 0.02, 0.10, x=-1.0, y=y, z=0.26) for y in (-0.3, 0.3)),
    ]
    scene.add_body("cabin", "static", cabin, position=(0.0, 0.0, n.CHASSIS_Z), color=GLASS)
