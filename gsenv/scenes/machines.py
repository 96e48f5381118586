"""Machines: a motor, gears, and a wrecking ball."""

from __future__ import annotations

import math
from itertools import pairwise

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Circle, Gear, Revolute

from .links import LINK, NOT_LINKS, Point, add_links, straight
from .palette import BRICK, COOL, GRAPHITE, WARM
from .stacks import ground


def motor_rig(
    motor_speed: float = 10.0,
    motor_effort: float = 2.0,
    spin: float = 0.0,
    limits: tuple[float, float] | None = None,
    inertia: float = 0.5,
) -> Scene:
    """Build a balanced rotor of ``inertia`` kg m^2 on a hinge with a motor; it starts at ``spin`` rad/s.

    The motor drives it to ``motor_speed`` rad/s with a torque of at most ``motor_effort`` N m (0: no motor);
    ``limits`` bound its angle, in rad.
    """
    scene = Scene()
    scene.add_body("stand", kind="static")
    scene.add_body("rotor", shapes=[Box(half_extents=(0.5, 0.08))], mass=2.0, inertia=inertia, angular_velocity=spin)
    scene.add_joint(
        "hinge",
        Revolute(
            "stand",
            "rotor",
            limits=limits,
            motor_speed=motor_speed if motor_effort > 0.0 else 0.0,
            motor_effort=motor_effort,
        ),
    )
    return scene


def mixer(balls: int = 96, speed: float = -2.0) -> Scene:
    """Build a tub of balls with two paddle wheels that rotate in opposite directions at the same speed.

    A motor drives the left wheel at ``speed`` rad/s, and a gear couples the right one to it.
    """
    scene = Scene()
    reach, thickness, apart, height = 1.1, 0.07, 1.1, 1.5
    scene.add_body("tub", kind="static", shapes=_tub(apart, height, reach + 0.37, 2.4))
    for name, x, turn in (("left", -apart, 0.0), ("right", apart, 0.25 * math.pi)):
        arms = [
            Capsule(half_length=reach, radius=thickness, density=2.0, friction=0.3, angle=turn + 0.5 * math.pi * k)
            for k in range(2)
        ]
        scene.add_body(f"paddle_{name}", shapes=arms, position=(x, height), color=GRAPHITE)
    scene.add_joint("motor", Revolute("tub", "paddle_left", motor_speed=speed, motor_effort=200.0))
    scene.add_joint("axle", Revolute("tub", "paddle_right"))
    scene.add_joint("gear", Gear("motor", "axle"))
    columns, radius = 16, 0.12
    for k in range(balls):
        row, column = divmod(k, columns)
        color = WARM if column < columns // 2 else COOL
        x = 0.27 * (column - 0.5 * (columns - 1)) + 0.03 * (row % 2)
        ball = Circle(radius=radius, friction=0.3)
        scene.add_body(f"ball_{k}", shapes=[ball], position=(x, height + reach + 0.3 + 0.27 * row), color=color)
    return scene


def _tub(apart: float, height: float, radius: float, rim: float) -> list[Capsule]:
    """Return two round troughs of ``radius`` m about (-apart, height) and (apart, height), with walls of ``rim`` m."""
    thickness = 0.08
    outer = radius + thickness
    cusp = math.pi - math.acos(apart / outer)  # rad, from the wall down to the cusp between the troughs
    angles = [math.pi + cusp * k / 14 for k in range(15)]
    left = [(outer * math.cos(t) - apart, outer * math.sin(t) + height) for t in angles]
    left = [(-apart - outer, height + rim), *left]
    right = [(-x, y) for x, y in left]
    return [_bar(a, b, thickness) for side in (left, right) for a, b in pairwise(side)]


def _bar(a: Point, b: Point, radius: float) -> Capsule:
    """Return a capsule from a to b."""
    (ax, ay), (bx, by) = a, b
    middle = (0.5 * (ax + bx), 0.5 * (ay + by))
    half_length = 0.5 * math.hypot(bx - ax, by - ay)
    return Capsule(
        half_length=half_length, radius=radius, position=middle, angle=math.atan2(by - ay, bx - ax), friction=0.3
    )


def wrecking_ball(rows: int = 12, columns: int = 4, degrees: float = 70.0) -> Scene:
    """Build a ball of 0.6 m radius on a chain, released at rest ``degrees`` to the left, that swings into a wall."""
    scene = Scene()
    ground(scene, friction=0.6)
    hook, link, links = (0.0, 7.0), 0.5, 9
    scene.add_body("crane", kind="static", shapes=_crane(hook))
    points = straight(hook, -degrees, link, links)
    chain = add_links(scene, points, 0.07, start="crane", density=5.0)
    radius = 0.6
    middle = straight(points[-1], -degrees, radius, 1)[1]
    ball = Circle(radius=radius, density=8.0, category=LINK, mask=NOT_LINKS)
    scene.add_body("ball", shapes=[ball], position=middle, color=GRAPHITE)
    scene.add_joint("shackle", Revolute(chain[-1], "ball", anchor=points[-1]))
    half_width, half_height = 0.4, 0.2
    for row in range(rows):
        for column in range(columns):
            place = 0.9 + half_width * (2 * column + 1 + row % 2)
            position = (place, half_height * (2 * row + 1))
            color = BRICK[(2 * row + column) % 3]
            brick = Box(half_extents=(half_width, half_height), friction=0.6)
            scene.add_body(f"brick_{row}_{column}", shapes=[brick], position=position, color=color)
    return scene


def _crane(hook: Point) -> list[Box]:
    """Return a mast and a jib, which are only drawn and collide with nothing."""
    x, y = hook
    mast = Box(half_extents=(0.25, 0.5 * y + 0.4), position=(x - 7.0, 0.5 * y + 0.4), mask=0)
    jib = Box(half_extents=(3.9, 0.15), position=(x - 3.5, y + 0.15), mask=0)
    return [mast, jib]
