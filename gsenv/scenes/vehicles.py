"""Cars with driven wheels: on flat ground, with closed-form solutions, and over hills."""

from __future__ import annotations

import math

import numpy as np

from gsenv.solver import Scene
from gsenv.solver.planar import Box, Circle, HalfPlane, Polygon, Revolute, Terrain, Wheel
from gsenv.solver.records.shapes import ALL_BITS

NO_LIMIT = 1000.0  # rad/s, a motor speed that no wheel reaches, so that the motor's torque is constant


def car(
    speed: float = 0.0,
    torque: float = 300.0,
    locked: bool = False,
    friction: float = 0.5,
    suspension: float | None = None,
    wheel_inertia: float = 0.8,
) -> Scene:
    """Build a car on flat ground that moves to the right at ``speed`` m/s, without rolling resistance.

    A torque of ``torque`` N m drives its rear wheel or, with ``locked``, both wheels are locked and slide.

    Args:
        friction: friction coefficient between wheels and ground.
        suspension: Hz, natural frequency of the chassis on its springs; None fixes the axles to the chassis.
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
    """Build a car with two driven wheels that crosses ``hills`` hills, each steeper than the one before.

    Each motor drives its wheel to ``wheel_speed`` rad/s with at most ``torque`` N m. The ground is flat again beyond
    x = 5 + 9 ``hills`` m.
    """
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
    """Add a car that faces right, centred on x = 0 on ground at y = 0.

    Its bodies are "chassis", "rear" and "front", its joints "rear_axle" and "front_axle".

    Args:
        speed: m/s, to the right.
        torques: N m, largest torques of the rear and the front motor.
        wheel_speed: rad/s, forward speed to which the motors drive the wheels.
        chassis_mass: kg.
        wheel_mass: kg, of each wheel.
        wheel_inertia: kg m^2, of each wheel.
        radius: m, of the wheels.
        wheelbase: m, between the axles.
        height: m, of the chassis' centre of mass, which is midway between the axles.
        friction: friction coefficient of the wheels.
        suspension: Hz, natural frequency of the chassis on its springs; None fixes the axles to the chassis.
        damping_ratio: of the suspension.
        travel: m, limit of the suspension's translation up and down.
        rolling: whether the wheels initially rotate with the car's speed.
        roof: whether the cab collides; otherwise it is only drawn.
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
        motor_speed = -wheel_speed if torque > 0.0 else 0.0
        axle: Revolute | Wheel
        if suspension is None:
            axle = Revolute("chassis", name, motor_speed=motor_speed, motor_effort=torque)
        else:
            stiffness, damping, rest = _spring(0.5 * chassis_mass, suspension, damping_ratio)
            axle = Wheel(
                "chassis",
                name,
                axis=(0.0, 1.0),
                limits=(-travel, travel),
                stiffness=stiffness,
                damping=damping,
                rest=rest,
                motor_speed=motor_speed,
                motor_effort=torque,
            )
        scene.add_joint(f"{name}_axle", axle)


def _spring(mass: float, frequency: float, damping_ratio: float) -> tuple[float, float, float]:
    """Return stiffness N/m, damping N s/m and rest m of a wheel's spring.

    It carries ``mass`` kg in the initial pose and oscillates at ``frequency`` Hz.
    """
    omega = 2.0 * math.pi * frequency
    return mass * omega**2, 2.0 * damping_ratio * mass * omega, -9.81 / omega**2
