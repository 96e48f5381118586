"""GCar's scene, from the numbers of scene.py."""

from __future__ import annotations

import math

import numpy as np

from gsenv.envs.car.scene import (
    BOARD_MASS,
    BOARD_OFFSET,
    BOARD_THICKNESS,
    BOX_DENSITY,
    BOX_GROUPS,
    BRIDGES,
    CHASSIS_MASS,
    CHASSIS_Y,
    CHECK_SIZE,
    CHECKS,
    FINISH,
    FIRST_X,
    GATE,
    GATE_HALF,
    GATE_HEIGHT,
    GATE_REACH,
    GATES,
    GROUND,
    GROUP_BOXES,
    NOTHING,
    PARKED_Y,
    PLANK,
    PLANK_MASS,
    PLANK_RADIUS,
    PLANKS,
    POLE_HEIGHT,
    RADIUS,
    SEESAWS,
    SPACING,
    SUSPENSION,
    TORQUE,
    TRAVEL,
    VERTICES,
    WEDGE_HALF,
    WHEEL_INERTIA,
    WHEEL_MASS,
    WHEELBASE,
)
from gsenv.scenes.palette import AMBER, GRAPHITE, STEEL, WARM, WOOD
from gsenv.scenes.vehicles import add_car
from gsenv.solver import Scene
from gsenv.solver.planar import Box, Capsule, Polygon, Revolute, Terrain

RED, GREEN = (214, 58, 52), (76, 168, 84)  # of a gate before and after it is passed


def build_scene() -> Scene:
    """Return the scene: flat ground, the car at x = 0, all obstacles parked and disabled, the flag at the finish."""
    scene = Scene()
    x = FIRST_X + SPACING * np.arange(VERTICES)
    terrain = Terrain(vertices=np.stack([x, np.zeros(VERTICES)], 1), category=GROUND)
    scene.add_body("ground", "static", [terrain])
    _add_flag(scene)
    _add_gates(scene)
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
    scene.add_body(
        "burst", "static", [_star(0.55, 0.0), _star(0.55, 0.25 * math.pi)], position=(0.0, PARKED_Y), color=AMBER
    )
    _join(scene)
    for name in ("rear", "front"):
        scene.add_actuator(f"{name}_drive", f"{name}_axle", mode="velocity")
    return scene


def _box_color(k: int) -> tuple[int, int, int]:
    return (WARM, (70, 140, 190), (252, 172, 20))[k % 3]


def _star(half: float, angle: float) -> Box:
    return Box(half_extents=(half, half), angle=angle, category=GATE, mask=NOTHING)


def _add_gates(scene: Scene) -> None:
    """Add the arches, then their red and their green bars, which each episode puts over bridges and see-saws."""

    def bar(x: float, y: float, half_x: float, half_y: float) -> Box:
        return Box(half_extents=(half_x, half_y), position=(x, y), category=GATE, mask=NOTHING)

    posts = [bar(side * GATE_REACH, 0.5 * GATE_HEIGHT, 0.06, 0.5 * GATE_HEIGHT) for side in (-1.0, 1.0)]
    arch = [*posts, bar(0.0, GATE_HEIGHT, GATE_REACH + 0.06, 0.05)]
    below = GATE_HEIGHT - 0.22
    lamp = [bar(0.0, below, GATE_HALF, 0.13)]
    for name, boxes, color in (("arch", arch, STEEL), ("red", lamp, RED), ("green", lamp, GREEN)):
        for k in range(GATES):
            scene.add_body(f"gate_{k}_{name}", "static", boxes, position=(8.0 * k, PARKED_Y - 20.0), color=color)


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
        wedge = Polygon(vertices=[(-WEDGE_HALF, 0.0), (WEDGE_HALF, 0.0), (0.0, 1.0)], mask=NOTHING)
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
