"""GCar's world: numbers, indices and the scene. Everything in SI units."""

from __future__ import annotations

import math

import numpy as np

from gsenv.scenes.palette import GRAPHITE, STEEL, WARM, WOOD
from gsenv.scenes.vehicles import add_car
from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Polygon, Revolute, Terrain

# Course: one chain of vertices, whose heights each episode sets anew.
FINISH = 100.0  # m
SPACING = 0.25  # m, between the vertices
FIRST_X = -12.0  # m
LAST_X = 120.0  # m
VERTICES = round((LAST_X - FIRST_X) / SPACING) + 1
WALL_X = -10.0  # m: the chain rises to a wall left of it
WALL_HEIGHT = 8.0  # m

SLOTS = 6  # places for obstacles, each flat ground amid the hills
FIRST_SLOT = 17.0  # m
SLOT_SPACING = 13.5  # m

# Car
CHASSIS_MASS = 100.0  # kg
WHEEL_MASS = 12.0  # kg, of each
WHEEL_INERTIA = 1.8  # kg m^2: nearly all in the tyre, so that the drive turns a flying car
RADIUS = 0.4  # m, of the wheels
WHEELBASE = 1.7  # m
CHASSIS_Y = 0.8  # m, of its centre of mass in the scene
SUSPENSION = 2.0  # Hz
STIFFNESS = 0.5 * CHASSIS_MASS * (2.0 * math.pi * SUSPENSION) ** 2  # N/m, of each wheel's spring
TRAVEL = 0.2  # m, up and down
TORQUE = 350.0  # N m, of each motor at a full action
BRAKE_TORQUE = 400.0  # N m, of each brake at a full action
TOP_SPEED = 50.0  # rad/s, beyond which the motors do not drive: 20 m/s
REVERSE_SPEED = 5.0  # rad/s: 2 m/s
FRICTION = 1.0
GRAVITY = 9.81

# Obstacles
BRIDGES = 2
PLANKS = 6  # of a bridge
PLANK_RADIUS = 0.07  # m
PLANK_MASS = 14.0  # kg/m
BRIDGE_BEND = 0.25  # rad, at each end of a bridge that hangs at rest
GAP_DEPTH = 2.5  # m
SEESAWS = 2
BOARD_THICKNESS = 0.06  # m, half
BOARD_MASS = 10.0  # kg/m
BOARD_OFFSET = 0.08  # m, of its middle from the hinge, towards the start
BOX_GROUPS = 2
GROUP_BOXES = 3
BOX_DENSITY = 30.0  # kg/m^2

GROUND_BODY, FLAG_BODY = 0, 1  # pole, dark and light fields: painted before the car
CHASSIS_BODY, REAR_BODY, FRONT_BODY, FIRST_PLANK = 4, 5, 6, 7
FIRST_BOARD = FIRST_PLANK + BRIDGES * PLANKS
FIRST_FULCRUM = FIRST_BOARD + SEESAWS
FIRST_BOX = FIRST_FULCRUM + SEESAWS
LAST_OBSTACLE = FIRST_BOX + BOX_GROUPS * GROUP_BOXES
CHECKS = (4, 3)  # fields of the finish flag
FIRST_OBSTACLE_SHAPE = 6 + CHECKS[0] * CHECKS[1]  # ground, pole, flag, hull, cab and wheels come before
REAR_AXLE, FRONT_AXLE, FIRST_HINGE = 0, 1, 2
HINGES = PLANKS + 1  # of a bridge
FIRST_PIVOT = FIRST_HINGE + BRIDGES * HINGES

GROUND = 2  # categories
PLANK = 4
NOTHING = 0

PARKED_Y = -40.0  # m, of obstacles that an episode does without; disabled, so nothing meets them
CHECK_SIZE = 0.14  # m, half
POLE_HEIGHT = 3.2  # m


def build_scene() -> Scene:
    """Return the scene: flat ground, the car at x = 0, all obstacles parked and disabled, the flag at the finish."""
    scene = Scene()
    x = FIRST_X + SPACING * np.arange(VERTICES)
    terrain = Terrain(vertices=np.stack([x, np.zeros(VERTICES)], 1), category=GROUND)
    scene.add_body("ground", "static", [terrain])
    _add_flag(scene)
    add_car(
        scene, torques=(TORQUE, TORQUE), chassis_mass=CHASSIS_MASS, wheel_mass=WHEEL_MASS,
        wheel_inertia=WHEEL_INERTIA,
        radius=RADIUS, wheelbase=WHEELBASE, height=CHASSIS_Y, suspension=SUSPENSION, travel=TRAVEL, roof=True,
    )  # fmt: skip
    _add_bridges(scene)
    _add_seesaws(scene)
    for k in range(BOX_GROUPS * GROUP_BOXES):
        box = Box(half_extents=(0.2, 0.2), density=BOX_DENSITY)
        where = (2.0 * k, PARKED_Y)
        scene.add_body(f"box_{k}", shapes=[box], position=where, enabled=False, color=_box_color(k))
    _join(scene)
    for name in ("rear", "front"):
        scene.add_actuator(f"{name}_drive", f"{name}_axle", mode="velocity")
    return scene


def _box_color(k: int) -> tuple[int, int, int]:
    return (WARM, (70, 140, 190), (252, 172, 20))[k % 3]


def _add_bridges(scene: Scene) -> None:
    for k in range(BRIDGES * PLANKS):
        plank = Capsule(half_length=0.3, radius=PLANK_RADIUS, category=PLANK, mask=~(GROUND | PLANK))
        place = (2.0 * k, PARKED_Y - 5.0)
        scene.add_body(
            f"plank_{k}", shapes=[plank], position=place, mass=0.6 * PLANK_MASS, enabled=False,
            color=WOOD[k % 2],
        )  # fmt: skip


def _add_seesaws(scene: Scene) -> None:
    for k in range(SEESAWS):
        board = Box(half_extents=(2.0, BOARD_THICKNESS))
        scene.add_body(
            f"board_{k}", shapes=[board], position=(8.0 * k, PARKED_Y - 10.0),
            mass=4.0 * BOARD_MASS, enabled=False, color=WOOD[0],
        )  # fmt: skip
    for k in range(SEESAWS):
        wedge = Polygon(vertices=[(-0.3, 0.0), (0.3, 0.0), (0.0, 1.0)], mask=NOTHING)
        where = (8.0 * k, PARKED_Y - 11.0)
        scene.add_body(f"fulcrum_{k}", "static", [wedge], position=where, enabled=False, color=STEEL)


def _join(scene: Scene) -> None:
    """Add all hinges; each episode sets the anchors of those on the ground."""
    for b in range(BRIDGES):
        planks = [f"plank_{b * PLANKS + k}" for k in range(PLANKS)]
        ends = ["ground", *planks], [*planks, "ground"]
        for k, (left, right) in enumerate(zip(*ends, strict=True)):
            if right == "ground":  # the ground is a body like any other, but as the first one
                left, right = right, left
            scene.add_joint(
                f"bridge_{b}_hinge_{k}",
                Revolute(left, right, anchor_a=(0.0, 0.0), anchor_b=(0.0, 0.0), damping=20.0, enabled=False),
            )
    for k in range(SEESAWS):
        scene.add_joint(
            f"pivot_{k}",
            Revolute(
                f"fulcrum_{k}",
                f"board_{k}",
                anchor_a=(0.0, 1.0),
                anchor_b=(BOARD_OFFSET, -BOARD_THICKNESS),
                damping=20.0,
                enabled=False,
            ),
        )


def _add_flag(scene: Scene) -> None:
    """Add a checkered flag at the finish; each episode sets its height to that of the ground."""
    columns, rows = CHECKS
    dark: list[Box] = []
    light: list[Box] = []
    for i in range(columns):
        for j in range(rows):
            x = 0.05 + CHECK_SIZE * (2 * i + 1)
            y = POLE_HEIGHT - CHECK_SIZE * (2 * j + 1)
            check = Box(half_extents=(CHECK_SIZE, CHECK_SIZE), position=(x, y), mask=NOTHING)
            (dark if (i + j) % 2 else light).append(check)
    pole = Box(half_extents=(0.05, 0.5 * POLE_HEIGHT), position=(0.0, 0.5 * POLE_HEIGHT), mask=NOTHING)
    scene.add_body("flag_pole", "static", [pole], position=(FINISH, 0.0), color=STEEL)
    scene.add_body("flag_dark", "static", dark, position=(FINISH, 0.0), color=GRAPHITE)
    scene.add_body("flag_light", "static", light, position=(FINISH, 0.0), color=(245, 245, 245))
