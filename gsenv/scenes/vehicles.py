"""Cars with driven wheels: on flat ground, with a closed form, and over hills."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from gsenv.solver import Box, Circle, HalfPlane, Polygon, Scene, Terrain
from gsenv.solver.planar.shapes import ALL_BITS

NO_LIMIT = 1000.0  # rad/s: a speed that no wheel reaches, so that its motor is a constant torque


def car(
    speed: float = 0.0,
    torque: float = 300.0,
    locked: bool = False,
    friction: float = 0.5,
    suspension: float | None = None,
    wheel_inertia: float = 0.8,
) -> Scene:
    """A car on flat ground that rolls to the right at ``speed`` m/s, driven by ``torque`` N m at its rear wheel, or
    with both wheels ``locked`` and sliding. Nothing resists its rolling.

    Args:
        friction: of wheels on ground.
        suspension: Hz, of the chassis on its springs; None: the axles are fixed to it.
        wheel_inertia: kg m^2, of each wheel.
    """
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane(friction=friction)])
    torques = (math.inf, math.inf) if locked else (torque, 0.0)
    add_car(
        scene,
        speed=speed,
        torques=torques,
        wheel_speed=0.0 if locked else NO_LIMIT,
        friction=friction,
        suspension=suspension,
        wheel_inertia=wheel_inertia,
        rolling=not locked,
    )
    return scene


def hill_car(hills: int = 4, torque: float = 200.0, wheel_speed: float = 14.0) -> Scene:
    """A car with both wheels driven crosses ``hills`` hills, each steeper than the one before; its motors want
    ``wheel_speed`` rad/s with at most ``torque`` N m each. Past x = 5 + 9 ``hills`` m the ground is flat again."""
    start, width = 5.0, 9.0
    x = np.arange(-30.0, 60.0 + width * hills, 0.25)
    place = np.clip((x - start) / width, 0.0, hills)
    height = 0.7 + 1.2 * np.floor(np.minimum(place, hills - 1e-9)) / max(hills - 1, 1)
    y = 0.5 * height * (1.0 - np.cos(2.0 * np.pi * place))
    scene = Scene()
    ground = Terrain(vertices=np.stack([x, y], 1), friction=1.0)
    scene.add_body("ground", kind="static", shapes=[ground])
    add_car(scene, torques=(torque, torque), wheel_speed=wheel_speed, friction=1.0, suspension=2.0)
    return scene


def add_car(
    scene: Scene,
    speed: float = 0.0,
    torques: tuple[float, float] = (0.0, 0.0),
    wheel_speed: float = 0.0,
    chassis_mass: float = 100.0,
    wheel_mass: float = 10.0,
    wheel_inertia: float = 0.8,
    radius: float = 0.4,
    wheelbase: float = 2.2,
    height: float = 0.65,
    friction: float = 0.5,
    suspension: float | None = None,
    damping_ratio: float = 0.5,
    travel: float = 0.15,
    rolling: bool = True,
    roof: bool = False,
) -> None:
    """A car that faces right, above x = 0 on ground at y = 0: bodies "chassis", "rear" and "front", joints
    "rear_axle" and "front_axle".

    Args:
        speed: m/s, to the right; rolling: whether the wheels turn with it.
        torques: N m, most of the rear and of the front motor, which want wheel_speed rad/s forwards.
        chassis_mass, wheel_mass: kg, the latter of each wheel; wheel_inertia: kg m^2, of each.
        radius, wheelbase: m; height: m, of the chassis' centre of mass, midway between the axles.
        suspension: Hz, of the chassis on its springs, with damping_ratio and travel in m up and down; None:
            the axles are fixed to the chassis.
        roof: whether the cab is solid, and not only to be seen.
    """
    hull = Box(half_extents=(0.5 * wheelbase + 0.25, 0.18), friction=0.3)
    profile = [(-0.9, 0.18), (-0.65, 0.62), (0.25, 0.62), (0.75, 0.18)]
    cab = Polygon(vertices=profile, friction=0.3, density=0.0, mask=ALL_BITS if roof else 0)
    scene.add_body(
        "chassis", shapes=[hull, cab], position=(0.0, height), linear_velocity=(speed, 0.0), mass=chassis_mass
    )
    for name, side, torque in (("rear", -0.5, torques[0]), ("front", 0.5, torques[1])):
        scene.add_body(
            name,
            shapes=[Circle(radius=radius, friction=friction)],
            position=(side * wheelbase, radius),
            linear_velocity=(speed, 0.0),
            angular_velocity=-speed / radius if rolling else 0.0,
            mass=wheel_mass,
            inertia=wheel_inertia,
        )
        axle: dict[str, Any] = {"motor_effort": torque, "motor_speed": -wheel_speed if torque > 0.0 else 0.0}
        if suspension is not None:
            axle |= _spring(0.5 * chassis_mass, suspension, damping_ratio)
            axle |= {"axis": (0.0, 1.0), "limits": (-travel, travel)}
        scene.add_joint(f"{name}_axle", "revolute" if suspension is None else "wheel", "chassis", name, **axle)


def _spring(mass: float, frequency: float, damping_ratio: float) -> dict[str, float]:
    """A wheel's spring that carries ``mass`` kg as authored, and lets it bounce at ``frequency`` Hz."""
    omega = 2.0 * math.pi * frequency
    return {
        "stiffness": mass * omega**2,
        "damping": 2.0 * damping_ratio * mass * omega,
        "rest": -9.81 / omega**2,
    }
