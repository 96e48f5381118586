"""Armature, gain and offset of actuators, and the centre of mass, in 2D and 3D against closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial

STEPS, H = 40, 0.01
INERTIA, MASS, ARMATURE = 0.5, 2.0, 1.5


def machine(dim: int, turning: bool, gravity: float = 0.0, **servo: Any) -> tuple[Scene, World]:
    """A body on a joint to the world: it turns about its centre, or slides upwards."""
    up = 1 if dim == 2 else 2
    scene = Scene(dim=dim, gravity=[-gravity if k == up else 0.0 for k in range(dim)])
    scene.add_body("base", "static")
    shape = planar.Circle(0.1) if dim == 2 else spatial.Sphere(0.1)
    scene.add_body("it", shapes=[shape], mass=MASS, inertia=INERTIA if dim == 2 else (0.3, 0.4, INERTIA))
    if dim == 2:
        joint: Any = planar.Revolute("base", "it", **servo)
        if not turning:
            joint = planar.Prismatic("base", "it", axis=(0.0, 1.0), **servo)
    else:
        kind: Any = spatial.Hinge if turning else spatial.Slider
        joint = kind("base", "it", axis=(0.0, 0.0, 1.0), **servo)
    scene.add_joint("joint", joint)
    if servo.get("motor_effort"):
        scene.add_actuator("torque", "joint", mode="torque", gain=3.0, offset=0.5, lower=-1.0, upper=1.0)
    return scene, World(scene, options=Options(timestep=H, sleep=False))


@pytest.mark.parametrize("dim", [2, 3])
def test_rotor_adds_to_the_inertia(dim: int) -> None:
    _, world = machine(dim, True, motor_effort=100.0, armature=ARMATURE)
    world.control[:] = 2.0  # clipped to 1: the torque is 3.5 N m
    for _ in range(STEPS):
        world.step()
    rate = 3.5 * STEPS * H / (INERTIA + ARMATURE)
    np.testing.assert_allclose(world.joint_rate("joint"), rate, rtol=1e-6)
    np.testing.assert_allclose(world.joint_coordinate("joint"), 0.5 * rate * STEPS * H, rtol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_rotor_of_a_slide_falls_slowly(dim: int) -> None:
    _, world = machine(dim, False, gravity=9.81, armature=ARMATURE)
    for _ in range(STEPS):
        world.step()
    rate = -9.81 * MASS / (MASS + ARMATURE) * STEPS * H
    np.testing.assert_allclose(world.joint_rate("joint"), rate, rtol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("stiffness", "damping"), [(80.0, 0.0), (80.0, 4.0), (0.0, 3.0)])
def test_spring_and_damper_move_the_rotor_too(dim: int, stiffness: float, damping: float) -> None:
    whole = INERTIA + ARMATURE
    _, world = machine(dim, True, armature=ARMATURE, stiffness=stiffness, damping=damping, rest=0.3)
    for _ in range(STEPS):
        world.step()
    t, decay = STEPS * H, 0.5 * damping / whole
    speed = np.sqrt(max(stiffness / whole - decay**2, 0.0))
    wave = np.cos(speed * t) + decay * (np.sin(speed * t) / speed if speed else 0.0)
    wanted = 0.3 * (1.0 - np.exp(-decay * t) * wave) if stiffness else 0.0
    np.testing.assert_allclose(world.joint_coordinate("joint"), wanted, atol=2e-4)


@pytest.mark.parametrize("dim", [2, 3])
def test_armature_can_be_tuned(dim: int) -> None:
    _, world = machine(dim, True, motor_effort=100.0, armature=ARMATURE)
    world.parameters.set("joint", armature=4.0)
    world.control[:] = 0.5
    world.step()
    np.testing.assert_allclose(world.joint_rate("joint"), 2.0 * H / (INERTIA + 4.0), rtol=1e-6)
    with pytest.raises(ValueError, match="armature must not be negative"):
        machine(dim, True, armature=-1.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_center_of_mass(dim: int) -> None:
    scene = Scene(dim=dim)
    center = (0.1, 0.2) if dim == 2 else (0.1, 0.2, 0.3)
    scene.add_body("it", mass=MASS, inertia=INERTIA if dim == 2 else (0.3, 0.4, INERTIA), center=center)
    model = scene.compile()
    np.testing.assert_array_equal(model.nominal_bodies["center"][0], center)
    np.testing.assert_array_equal(model.start_bodies["position"][0], center)
    with pytest.raises(ValueError, match="body 'other': a center needs a mass and an inertia"):
        scene.add_body("other", mass=1.0, center=center)


def test_gain_must_be_finite() -> None:
    scene, _ = machine(2, True, motor_effort=1.0)
    with pytest.raises(ValueError, match="actuator 'two': gain must be"):
        scene.add_actuator("two", "joint", mode="torque", gain=np.inf)


def test_order_of_rotations() -> None:
    """The order names which of the rotations is about an axis of the first body."""
    for order in ("xyz", "yzx", "zxy"):
        scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
        scene.add_body("base", "static")
        scene.add_body("it", shapes=[spatial.Sphere(0.1)], mass=MASS, inertia=(0.3, 0.4, INERTIA))
        axis = spatial.Axis(limits=(-1.0, 1.0))
        free: dict[str, Any] = {f"turn_{letter}": spatial.Axis() for letter in "xyz"} | {"turn_x": axis}
        scene.add_joint("joint", spatial.SixAxis("base", "it", order=order, **free))
        world = World(scene)
        half = np.radians(40.0) / 2.0
        turns = {letter: np.array([np.cos(half), *(np.sin(half) * np.eye(3)[k])]) for k, letter in enumerate("xyz")}
        quaternion = turns[order[0]]
        for letter in order[1:]:
            quaternion = spatial_product(quaternion, turns[letter])
        world.set_pose("it", orientation=quaternion)
        angles = [world.joint_coordinate(f"joint/turn_{letter}")[0] for letter in "xyz"]
        np.testing.assert_allclose(angles, np.radians(40.0), atol=1e-12)
    with pytest.raises(ValueError, match="order 'xzy' is unknown; known are xyz, yzx, zxy"):
        scene.add_joint("wrong", spatial.SixAxis("base", "it", order="xzy", turn_x=axis))


def spatial_product(p: Any, q: Any) -> Any:
    """The rotation q, then p."""
    return np.array(
        [
            p[0] * q[0] - p[1:] @ q[1:],
            *(p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])),
        ]
    )


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_impact_on_a_slide_moves_its_rotor(dim: int, restitution: float) -> None:
    """A ball against a sphere on a slide with a rotor, which is as heavy as both masses together."""
    ball, speed = 0.7, 2.0
    pad = (0.0,) * (dim - 1)
    scene = Scene(dim=dim, gravity=[0.0] * dim)
    scene.add_body("base", "static")
    for name, x, mass in (("it", 0.0, MASS), ("ball", -0.5, ball)):
        shape: Any = (planar.Circle if dim == 2 else spatial.Sphere)(0.1, restitution=restitution, friction=0.0)
        scene.add_body(
            name, shapes=[shape], mass=mass, position=(x, *pad), linear_velocity=(speed if mass == ball else 0.0, *pad)
        )
    kind: Any = planar.Prismatic if dim == 2 else spatial.Slider
    scene.add_joint("joint", kind("base", "it", axis=(1.0, *pad), armature=ARMATURE))
    world = World(scene, options=Options(timestep=H, sleep=False))
    world.step(STEPS)
    rate = (1.0 + restitution) * ball * speed / (ball + MASS + ARMATURE)
    np.testing.assert_allclose(world.joint_rate("joint"), rate, rtol=1e-6)
    np.testing.assert_allclose(world.linear_velocity[0, 2, 0], rate - restitution * speed, atol=1e-6)


@pytest.mark.parametrize("dim", [2, 3])
def test_impact_on_an_arm_turns_its_rotor(dim: int) -> None:
    ball, speed, length = 0.7, 2.0, 0.8
    scene = Scene(dim=dim, gravity=[0.0] * dim)
    scene.add_body("base", "static")
    at = (length, 0.0) if dim == 2 else (length, 0.0, 0.0)
    start = (length, -0.3) if dim == 2 else (length, -0.3, 0.0)
    round_shape: Any = planar.Circle if dim == 2 else spatial.Sphere
    inertia = INERTIA if dim == 2 else (0.3, 0.4, INERTIA)
    shape = round_shape(0.1, restitution=1.0, friction=0.0)
    scene.add_body("it", shapes=[shape], mass=MASS, inertia=inertia, position=at)
    velocity = (0.0, speed) if dim == 2 else (0.0, speed, 0.0)
    shape = round_shape(0.1, restitution=1.0, friction=0.0)
    scene.add_body("ball", shapes=[shape], mass=ball, position=start, linear_velocity=velocity)
    anchor = (0.0,) * dim
    joint: Any = planar.Revolute("base", "it", anchor=anchor, armature=ARMATURE)
    if dim == 3:
        joint = spatial.Hinge("base", "it", anchor=anchor, axis=(0.0, 0.0, 1.0), armature=ARMATURE)
    scene.add_joint("joint", joint)
    world = World(scene, options=Options(timestep=1e-3, sleep=False))
    world.step(60)
    whole = INERTIA + MASS * length**2 + ARMATURE
    rate = 2.0 * ball * length * speed / (whole + ball * length**2)
    np.testing.assert_allclose(world.joint_rate("joint"), rate, rtol=1e-3)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("solver", ["pgs", "nncg", "subspace"])
def test_a_limit_stops_a_heavy_rotor_on_a_light_body(dim: int, solver: str) -> None:
    """Its row is solved together with that of the rotor: alone it would find a thousandth of the inertia in a sweep."""
    scene, _ = machine(dim, True, armature=1000.0 * INERTIA, limits=(-np.inf, 0.1))
    options = Options(timestep=H, sleep=False, solver=solver, sweeps=8, articulated=False)
    world = World(scene, options=options)
    if dim == 2:
        world.state.bodies["velocity"][0, 1, 2] = 2.0
    else:
        world.state.bodies["velocity"][0, 1, 5] = 2.0
    for _ in range(10):
        world.step()
    assert world.diagnostics().unconverged[0] == 0
    np.testing.assert_allclose(world.joint_coordinate("joint"), 0.1, atol=1e-4)
    np.testing.assert_allclose(world.joint_rate("joint"), 0.0, atol=1e-3)


def test_the_option_chooses_rows_or_joint_coordinates() -> None:
    """An armature that is set later changes nothing in the other worlds of the batch."""
    scene = Scene(gravity=(0.0, -9.81))
    scene.add_body("base", "static")
    for k in range(2):
        scene.add_body(f"rod_{k}", shapes=[planar.Box((0.5, 0.1), mask=0)], position=(k + 0.5, 0.0))
        scene.add_joint(f"joint_{k}", planar.Revolute(f"rod_{k - 1}" if k else "base", f"rod_{k}", anchor=(k, 0.0)))
    world, alone = World(scene, 2), World(scene)
    world.step()
    assert (world.diagnostics().rows == 0).all()
    world.parameters.set("joint_0", armature=0.5, worlds=1)
    alone.step(3)
    world.step(2)
    np.testing.assert_array_equal(world.state.bodies[0], alone.state.bodies[0])
    world.options = Options(articulated=False)
    world.step()
    assert world.diagnostics().rows.tolist() == [4, 5]
    world.options = Options()
    world.step()
    assert world.diagnostics().rows.tolist() == [0, 0]
    with pytest.raises(ValueError, match="articulated must be True or False, got 1"):
        Options(articulated=1)  # type: ignore[arg-type]
