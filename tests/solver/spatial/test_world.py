"""Worlds in 3D: parameters by world, poses, velocities, forces, targets, sensors, diagnostics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import (
    Ball,
    Box,
    Capsule,
    ContactSensor,
    Cylinder,
    Distance,
    Hull,
    JointSensor,
    PoseSensor,
    Sphere,
    Target,
    VelocitySensor,
)
from tests.solver.bits import everything
from tests.solver.spatial.one_kernel import CORNERS, full_world, on_plane, space

G = 9.81
MOMENTS = (1.0, 2.0, 2.5)
QUARTER = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))  # about z


def crate(weight: float = 0.0, **given: Any) -> Scene:
    """One crate of 2 kg and moments MOMENTS."""
    scene = space(weight)
    scene.add_body("crate", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], mass=2.0, inertia=MOMENTS, **given)
    return scene


# ---------------------------------------------------------------- parameters


def test_gravity_by_world() -> None:
    world = full_world(crate(G), 3)
    world.parameters.set(gravity=[[0, 0, -1], [2, 1, 0]], worlds=[0, 2])
    world.parameters.set("crate", gravity_scale=0.5, worlds=2)
    world.step(60)
    assert_allclose(world.linear_velocity[:, 0], [[0.0, 0.0, -1.0], [0.0, 0.0, -G], [1.0, 0.5, 0.0]], rtol=1e-13)
    assert_allclose(world.position[:, 0], [[0.0, 0.0, -0.5], [0.0, 0.0, -G / 2], [0.5, 0.25, 0.0]], rtol=1e-12)


def test_mass_and_inertia_by_world() -> None:
    world = full_world(crate(), 3)
    world.parameters.set("crate", mass=[1.0, 10.0], worlds=[0, 2])
    world.parameters.set("crate", inertia=(4.0, 5.0, 6.0), worlds=1)
    assert_array_equal(world.parameters.mass[:, 0], [1, 2, 10])
    assert_array_equal(
        world.parameters.inertia[:, 0], [list(MOMENTS), [4.0, 5.0, 6.0], list(MOMENTS)]
    )  # was given, so it stays
    assert_allclose(world.parameters.bodies["inv_inertia"][1, 0], (1 / 4, 1 / 5, 1 / 6), rtol=1e-15)
    world.apply_force("crate", force=(1, 0, 0), torque=(0, 0, 2.0))
    world.step()
    assert_allclose(world.linear_velocity[:, 0, 0] / world.timestep, [1, 0.5, 0.1], rtol=1e-13)
    assert_allclose(world.angular_velocity[:, 0, 2] / world.timestep, [0.8, 1 / 3, 0.8], rtol=1e-13)
    world.parameters.set("crate", inertia=[(1, 1, 1), (2, 2, 2), (3, 3, 3)])
    assert_array_equal(world.parameters.inertia[:, 0, 1], [1, 2, 3])


SHAPED: dict[str, tuple[Any, dict[str, Any], Any]] = {
    "box": (Box(half_extents=(0.5, 0.4, 0.3)), {"half_extents": (0.7, 0.2, 0.1)}, Box(half_extents=(0.7, 0.2, 0.1))),
    "sphere": (Sphere(radius=0.5), {"radius": 0.2}, Sphere(radius=0.2)),
    "capsule": (Capsule(half_length=0.5, radius=0.1), {"half_length": 0.8, "radius": 0.3},
                Capsule(half_length=0.8, radius=0.3)),
    "cylinder": (Cylinder(half_length=0.5, radius=0.1), {"half_length": 0.1, "radius": 0.3},
                 Cylinder(half_length=0.1, radius=0.3)),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPED)
def test_a_new_size_equals_that_of_a_new_scene(name: str) -> None:
    before, fields, after = SHAPED[name]
    scenes = [Scene(dim=3), Scene(dim=3)]
    for scene, shape in zip(scenes, (before, after), strict=True):
        scene.add_body("it", shapes=[shape])
    world = World(scenes[0], 2)
    old = world.parameters.bodies[0].copy()
    world.parameters.set("it", worlds=1, **fields)
    given = scenes[1].compile().nominal_bodies[0]
    record = world.parameters.bodies[1, 0]
    for field in ("mass", "inertia", "inv_mass", "inv_inertia", "extent", "radius"):
        assert_allclose(record[field], given[field], rtol=1e-13)
    assert (world.parameters.bodies[0] == old).all()


def test_density_and_given_masses() -> None:
    scene = Scene(dim=3)
    scene.add_body("hull", shapes=[Hull(vertices=CORNERS)])
    scene.add_body("given", shapes=[Sphere(radius=0.5)], position=(3, 0, 0), mass=4.0)
    p = World(scene, 2).parameters
    mass, inertia = p.mass[0, 0], p.inertia[0, 0].copy()
    assert mass == pytest.approx(1.0 / 6.0, rel=1e-12)
    p.set("hull", density=5.0)
    assert_allclose(p.mass[:, 0], 5 * mass, rtol=1e-13)
    assert_allclose(p.inertia[:, 0], [5 * inertia] * 2, rtol=1e-12)
    p.set("hull", mass=1.0)  # the inertia scales
    assert_allclose(p.inertia[1, 0], inertia / mass, rtol=1e-12)
    p.set("given", radius=1.0)
    assert_array_equal(p.mass[:, 1], 4)
    assert_allclose(p.inertia[:, 1], 0.4 * 4, rtol=1e-13)


def test_size_by_world() -> None:
    scene = on_plane()
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], position=(0, 0, 0.5))
    scene.add_body("ball", shapes=[Sphere(radius=0.5)], position=(3, 0, 0.5))
    world = full_world(scene, 3)
    world.parameters.set("box", half_extents=[[0.5, 0.5, 0.2], [0.5, 0.5, 0.4]], worlds=[0, 2])
    world.parameters.set("ball", radius=[0.1, 0.3, 0.5])
    world.step(60)
    assert_allclose(world.position[:, 1, 2], [0.2, 0.5, 0.4], atol=1e-3)
    assert_allclose(world.position[:, 2, 2], [0.1, 0.3, 0.5], atol=1e-3)


def test_friction_by_world() -> None:
    scene = on_plane()
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5, 0.1))], position=(0, 0, 0.1))
    world = full_world(scene, 3)
    for body in ("ground", "box"):
        world.parameters.set(body, friction=[0.1, 0.3, 0.9])
    mass = world.parameters.mass[0, 1]
    way = np.array((0.6, -0.8, 0.0))
    for _ in range(60):
        world.apply_force("box", force=0.5 * G * mass * way)
        world.step()
    expected = np.outer([(0.5 - 0.1) * G, (0.5 - 0.3) * G, 0.0], way)
    assert_allclose(world.linear_velocity[:, 1], expected, atol=1e-3)


def test_torsional_friction_by_world() -> None:
    """Two shapes' torsional frictions mix; that of both set alike is what it is."""
    scene = on_plane()
    scene.add_body("ball", shapes=[Sphere(radius=0.5)], position=(0, 0, 0.5), angular_velocity=(0, 0, 10))
    world = full_world(scene, 2)
    for body in ("ground", "ball"):
        world.parameters.set(body, torsional_friction=[0.0, 0.02])
    world.step(60)
    # I = 2/5 m r^2: spin falls by 0.02 m g t / I
    assert_allclose(world.angular_velocity[:, 1, 2], [10.0, 10.0 - 0.02 * G / (0.4 * 0.25)], rtol=1e-3)


def test_enabled_by_world() -> None:
    scene = on_plane()
    for k in range(2):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5, 0.5))], position=(0, 0, 0.5 + k))
    world = full_world(scene, 2)
    world.parameters.set("box_0", enabled=False, worlds=1)
    world.step(45)
    assert_allclose(world.position[:, 2, 2], [1.5, 0.5], atol=2e-3)
    assert world.position[1, 1, 2] == 0.5  # out of the world, it stays where it was
    assert set(world.contacts(1).body_b) == {2}
    assert_array_equal(world.diagnostics().awake, [2, 1])


# ---------------------------------------------------------------- acting


def test_force_at_a_point_and_torque() -> None:
    world = full_world(crate(position=(1, 1, 1), orientation=QUARTER), 2)
    dt = world.timestep
    force, arm, torque = np.array((6.0, -4.0, 2.0)), np.array((0.5, 1.0, -0.5)), np.array((0.1, 0.2, 0.3))
    world.apply_force("crate", force=force, point=np.array((1, 1, 1)) + arm, torque=torque, worlds=1)
    world.step()
    turned = np.array((MOMENTS[1], MOMENTS[0], MOMENTS[2]))  # a quarter about z swaps the axes
    assert_allclose(world.linear_velocity[1, 0], force / 2 * dt, rtol=1e-13)
    # to first order: the body turns by 1e-3 rad in the step
    assert_allclose(world.angular_velocity[1, 0], (np.cross(arm, force) + torque) / turned * dt, atol=5e-5)
    assert not world.linear_velocity[0].any()
    velocity = world.linear_velocity.copy()
    world.step()  # cleared after one step
    assert_array_equal(world.linear_velocity, velocity)


def test_forces_add_up_and_differ_by_world() -> None:
    world = full_world(crate(), 3)
    world.apply_force("crate", force=[[1, 0, 0], [3, 0, 0]], worlds=[0, 2])
    world.apply_force("crate", force=(2, 0, 0), torque=[(0, 1, 0), (0, 2, 0)], worlds=[False, True, True])
    world.step()
    assert_allclose(world.linear_velocity[:, 0, 0], np.array([1, 2, 5]) / 2 * world.timestep, rtol=1e-13)
    assert_allclose(world.angular_velocity[:, 0, 1], np.array([0, 1, 2]) / 2 * world.timestep, rtol=1e-13)


def test_set_pose_and_velocity() -> None:
    world = full_world(crate(linear_velocity=(1, 2, 3), angular_velocity=(0, 0, 3)), 2)
    world.set_velocity("crate", angular=[(4, 0, 0), (0, 5, 0)])
    assert_array_equal(world.linear_velocity[:, 0], [[1, 2, 3]] * 2)
    assert_array_equal(world.angular_velocity[:, 0], [(4, 0, 0), (0, 5, 0)])
    world.set_velocity("crate", linear=(0, 0, 0), worlds=0)
    assert_array_equal(world.linear_velocity[:, 0], [[0, 0, 0], [1, 2, 3]])
    world.set_pose("crate", position=[[1, 2, 3], [3, 4, 5]], orientation=[(2, 0, 0, 2), (0, 0, -3, 0)])  # of any length
    assert_array_equal(world.position[:, 0], [[1, 2, 3], [3, 4, 5]])
    assert_allclose(world.orientation[:, 0], [QUARTER, (0, 0, -1, 0)], rtol=1e-15)
    world.set_pose("crate", orientation=(1, 0, 0, 0), worlds=1)
    assert_array_equal(world.position[1, 0], (3, 4, 5))


def test_pose_of_a_body_off_its_centre() -> None:
    scene = space()
    scene.add_body("off", shapes=[Sphere(radius=0.5, position=(1, 0, 0))], position=(2, 0, 0))
    world = full_world(scene)
    assert_allclose(world.center_of_mass[0, 0], (3, 0, 0), rtol=1e-15)
    world.set_pose("off", orientation=QUARTER)
    assert_allclose(world.position[0, 0], (2, 0, 0), atol=1e-15)
    assert_allclose(world.center_of_mass[0, 0], (2, 1, 0), atol=1e-15)
    world.apply_force("off", force=(0, 0, 1), point=(2, 1, 5))  # right through it
    world.step()
    assert_allclose(world.angular_velocity[0, 0], 0.0, atol=1e-15)
    assert world.linear_velocity[0, 0, 2] > 0.0


def test_set_target_moves_the_goal() -> None:
    scene = crate()
    scene.add_joint("pull", Target("crate", frequency=3.0))
    world = full_world(scene, 2)
    turn = np.array((0.8, 0.1, -0.5, 0.3)) / np.sqrt(0.99)
    world.set_target("pull", position=(2, -1, 0.5), orientation=turn, worlds=1)
    world.step(120)
    assert_allclose(world.position[1, 0], (2, -1, 0.5), atol=1e-5)
    assert_allclose(abs(world.orientation[1, 0] @ turn), 1.0, atol=1e-9)
    assert_allclose(world.position[0, 0], (0, 0, 0), atol=1e-12)
    world.set_target("pull", linear=(1, 0, 2), angular=(0, 0, 0.5), worlds=0)
    world.step(120)
    assert_allclose(world.linear_velocity[0, 0], (1, 0, 2), atol=1e-5)
    assert_allclose(world.position[0, 0], (2, 0, 4), atol=1e-4)  # 2 s, without lag
    assert_allclose(world.orientation[0, 0], (math.cos(0.5), 0, 0, math.sin(0.5)), atol=1e-4)
    assert_allclose(world.angular_velocity[0, 0], (0, 0, 0.5), atol=1e-5)


# ---------------------------------------------------------------- reading


def test_sensors() -> None:
    scene = on_plane(friction=0.5)
    box = Box(half_extents=(0.5, 0.5, 0.5))
    scene.add_body("box", shapes=[box], mass=3.0, position=(0, 0, 0.5), orientation=QUARTER)
    scene.add_body("hook", "static", position=(5, 0, 3))
    scene.add_body("bob", shapes=[Sphere(radius=0.2)], mass=2.0, position=(5, 0, 2))
    scene.add_joint("pin", Ball("hook", "bob", anchor_a=(0, 0, 0)))
    scene.add_sensor("pose", PoseSensor("box"))
    scene.add_sensor("velocity", VelocitySensor("box"))
    scene.add_sensor("contact", ContactSensor("box"))
    scene.add_sensor("pin", JointSensor("pin"))
    world = full_world(scene, 2)
    world.parameters.set("bob", mass=4.0, worlds=1)
    for _ in range(60):
        world.apply_force("box", force=(3.0, 4.0, 0.0), worlds=1, point=(0, 0, 0.1))
        world.step()
    assert_allclose(world.sensor("pose"), np.tile([0, 0, 0.5, *QUARTER], (2, 1)), atol=1e-3)
    assert_array_equal(world.sensor("pose"), np.column_stack([world.position[:, 1], world.orientation[:, 1]]))
    assert_array_equal(
        world.sensor("velocity"), np.column_stack([world.linear_velocity[:, 1], world.angular_velocity[:, 1]])
    )
    assert_allclose(world.sensor("contact"), [(1, 0, 0, 3 * G), (1, -3, -4, 3 * G)], atol=2e-2)
    assert_allclose(world.sensor("pin"), [(0, 0, 2 * G, 0, 0, 0), (0, 0, 4 * G, 0, 0, 0)], atol=1e-6)
    assert_array_equal(world.sensors()[:, world.model.sensor_slices["pin"]], world.sensor("pin"))
    assert world.sensors().shape == (2, 7 + 6 + 4 + 6)
    world.set_pose("box", position=(0, 0, 5))
    world.step()
    assert_array_equal(world.sensor("contact"), np.zeros((2, 4)))


def test_contacts() -> None:
    scene = on_plane(friction=0.5)
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.4, 0.3))], mass=2.0, position=(0, 0, 0.3))
    world = full_world(scene)
    world.step(60)
    contacts = world.contacts()
    assert len(contacts) == 4
    assert contacts.touching.all()
    assert_allclose(contacts.normal, [(0, 0, 1)] * 4, atol=1e-12)
    assert_allclose(np.sort(abs(contacts.point), 0)[:, :2], [(0.5, 0.4)] * 4, atol=1e-3)
    assert_allclose(contacts.force_vector(world.timestep).sum(0), (0, 0, 2 * G), atol=1e-3)


def test_diagnostics_of_a_turning_body() -> None:
    spin, velocity, place = np.array((1.0, -2.0, 0.5)), np.array((3.0, 0.0, 1.0)), np.array((1.0, 2.0, 3.0))
    given = {"linear_velocity": velocity, "angular_velocity": spin, "position": place}
    world = full_world(crate(G, orientation=QUARTER, **given), 2)
    d = world.diagnostics()
    moments = np.array((MOMENTS[1], MOMENTS[0], MOMENTS[2]))
    assert_allclose(d.kinetic_energy, 0.5 * (2 * (velocity @ velocity) + moments @ spin**2), rtol=1e-14)
    assert_allclose(d.potential_energy, 2 * G * 3, rtol=1e-14)
    assert_allclose(d.momentum, [2 * velocity] * 2, rtol=1e-14)
    assert_allclose(d.angular_momentum, [np.cross(place, 2 * velocity) + moments * spin] * 2, rtol=1e-13)


def test_free_motion_keeps_energy_and_angular_momentum() -> None:
    world = full_world(crate(angular_velocity=(0.01, 4.0, 0.02), linear_velocity=(1, 2, 3)))
    start = world.diagnostics()
    world.step(300)
    end = world.diagnostics()
    assert_allclose(end.energy, start.energy, rtol=1e-6)
    assert_allclose(end.momentum, start.momentum, rtol=1e-13)
    assert_allclose(end.angular_momentum, start.angular_momentum, atol=1e-5 * abs(start.angular_momentum).max())


def test_spring_energy_and_joint_error() -> None:
    scene = space()
    scene.add_body("base", "static")
    scene.add_body("mass", shapes=[Sphere(radius=0.2)], mass=2.0, position=(3, 0, 4))
    scene.add_joint("spring", Distance("base", "mass", length=4.0, stiffness=50.0))
    scene.add_body("held", shapes=[Sphere(radius=0.2)], position=(0, 9, 0))
    scene.add_joint("pin", Ball("base", "held", anchor_a=(0, 9.3, 0), anchor_b=(0, 0.2, 0)))
    world = full_world(scene)
    d = world.diagnostics()
    assert_allclose(d.spring_energy, 0.5 * 50 * 1.0, rtol=1e-12)
    assert_allclose(d.joint_error, 0.1, rtol=1e-12)
    assert_allclose(world.joint_coordinate("spring"), 5.0, rtol=1e-14)
    world.set_velocity("mass", linear=(3, 0, 4))
    assert_allclose(world.joint_rate("spring"), 5.0, rtol=1e-14)


def test_readings_are_copies_and_views_read_only() -> None:
    world = World(crate())
    before = everything(world)
    for reading in (
        world.position, world.center_of_mass, world.orientation, world.linear_velocity, world.angular_velocity
    ):  # fmt: skip
        reading += 1.0
        assert everything(world) == before
    p = world.parameters
    for view in (p.mass, p.inertia, p.friction, p.torsional_friction, p.rolling_friction, p.half_extents, p.gravity):
        with pytest.raises(ValueError, match="read-only"):
            view[...] = 1
    with pytest.raises(AttributeError, match="orientation"):
        _ = world.angle
    flat = Scene()
    flat.add_body("b", mass=1.0, inertia=1.0)
    with pytest.raises(AttributeError, match="angle"):
        _ = World(flat).orientation


# ---------------------------------------------------------------- stepping and resetting


def test_a_step_twice_is_two_steps() -> None:
    one, many = (full_world(crate(G, angular_velocity=(1, 2, 3))) for _ in range(2))
    for count in (1, 7, 12):
        one.step(count)
    many.step(20)
    assert everything(one) == everything(many)
    assert_allclose(one.time, 20 / 60)


@pytest.mark.parametrize(
    ("mask", "chosen"),
    [(None, [0, 1, 2, 3]), (2, [2]), ([0, 3], [0, 3]), ([], []), (np.array([True, False, False, True]), [0, 3])],
)
def test_reset(mask: Any, chosen: list[int]) -> None:
    world = full_world(crate(G, position=(0, 0, 5), orientation=QUARTER, angular_velocity=(1, 2, 3)), 4)
    start = world.state.bodies[0, 0].copy()
    world.parameters.set("crate", mass=7.0, inertia=(5, 5, 6))
    world.step(10)
    moved = world.state.bodies.copy()
    world.reset(mask)
    for w in range(4):
        fresh = w in chosen
        assert world.state.bodies[w, 0] == (start if fresh else moved[w, 0])
        assert_array_equal(world.parameters.inertia[w, 0], MOMENTS if fresh else (5, 5, 6))


def test_options_may_change_between_steps() -> None:
    world = full_world(crate(linear_velocity=(1, 0, 0)))
    world.step()
    world.options = Options(timestep=0.05)
    world.step()
    assert world.position[0, 0, 0] == pytest.approx(1 / 60 + 0.05, rel=1e-13)
    with pytest.raises(ValueError, match="solver newton exists in 2D only"):
        world.options = Options(solver="newton")
    assert world.timestep == 0.05
