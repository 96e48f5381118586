"""Small 3D mechanisms that the tests of joints share."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Box
from tests.solver.spatial.one_kernel import full_world, space

Array = NDArray[Any]
G = 9.81
AWAKE = Options(sleep=False)
FINE = Options(timestep=1.0 / 240.0, sleep=False)
ACCURATE = Options.preset("accurate", sleep=False)
MASS = 2.0
INERTIA = (0.2, 0.5, 0.4)
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "oblique": (0.6, -0.48, 0.64)}


def quaternion(axis: Any, angle: float) -> Array:
    """Quaternion of a rotation by ``angle`` rad about a unit axis."""
    return np.array((math.cos(0.5 * angle), *(math.sin(0.5 * angle) * np.asarray(axis, float))))


def multiplied(p: Any, q: Any) -> Array:
    """Rotation by q, then by p."""
    w, x, y, z = p
    return np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]) @ np.asarray(q, float)


def matrix(q: Any) -> Array:
    """Rotation matrix of a quaternion."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def tensor(orientation: Any, moments: Any = INERTIA) -> Array:
    """Inertia in the world of a body with these moments about its own axes."""
    turn = matrix(orientation)
    return np.asarray(turn @ np.diag(moments) @ turn.T)


def scene_of(joint: Any, gravity: float = 0.0, **body: Any) -> Scene:
    """A body "it" of 2 kg on a joint to the static "base" at the origin."""
    scene = space(gravity)
    scene.add_body("base", "static")
    given = {"shapes": [Box(half_extents=(0.3, 0.1, 0.2))], "mass": MASS, "inertia": INERTIA, **body}
    scene.add_body("it", **given)
    scene.add_joint("joint", joint)
    return scene


def held(
    joint: Any,
    gravity: float = 0.0,
    options: Options = AWAKE,
    worlds: int = 1,
    actuator: dict[str, Any] | None = None,
    **body: Any,
) -> World:
    """A world of ``scene_of``, with an actuator of the joint."""
    scene = scene_of(joint, gravity, **body)
    if actuator is not None:
        scene.add_actuator("actuator", **{"joint": "joint", **actuator})
    return full_world(scene, worlds, options)


def travel(world: World, steps: int, name: str = "joint") -> Array:
    """Coordinate of a joint after each of ``steps`` steps of the first world."""
    q = np.zeros(steps)
    for k in range(steps):
        world.step()
        q[k] = world.joint_coordinate(name)[0]
    return q


def oscillator(t: Array, x: float, v: float, omega: float, ratio: float) -> Array:
    """Damped oscillator x'' + 2 ratio omega x' + omega^2 x = 0 from x and v, ratio below 1."""
    damped = omega * math.sqrt(1.0 - ratio**2)
    wave = x * np.cos(damped * t) + (v + ratio * omega * x) / damped * np.sin(damped * t)
    return np.asarray(np.exp(-ratio * omega * t) * wave)


def agm(a: float, b: float) -> float:
    """Arithmetic-geometric mean."""
    for _ in range(40):
        a, b = 0.5 * (a + b), math.sqrt(a * b)
    return a


def pendulum_period(inertia: float, mass: float, reach: float, amplitude: float) -> float:
    """Period in s of a physical pendulum: 4 sqrt(I / (m g l)) K(sin(amplitude / 2)), K by the AGM."""
    return 2.0 * math.pi * math.sqrt(inertia / (mass * G * reach)) / agm(1.0, math.cos(0.5 * amplitude))
