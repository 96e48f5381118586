"""World: parameters that differ by world, contacts, sensors, diagnostics, growing buffers."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import (
    Box,
    Capsule,
    Circle,
    ContactSensor,
    HalfPlane,
    Polygon,
    PoseSensor,
    Terrain,
    VelocitySensor,
)
from tests.solver.bits import bits, everything
from tests.solver.small_scenes import crate, driven, handle

G = 9.81
NAN, INF = math.nan, math.inf


# ---------------------------------------------------------------- parameters


def test_gravity_by_world() -> None:
    world = World(crate(gravity=(0, -G)), world_count=3)
    world.parameters.set(gravity=[[0, -1], [2, 0]], worlds=[0, 2])
    world.parameters.set("crate", gravity_scale=0.5, worlds=2)
    world.step(60)
    np.testing.assert_allclose(world.linear_velocity[:, 0], [[0.0, -1.0], [0.0, -G], [1.0, 0.0]], rtol=1e-13)


def test_mass_by_world() -> None:
    world = World(crate(), world_count=2)
    world.parameters.set("crate", mass=[1.0, 10.0])
    np.testing.assert_array_equal(world.parameters.mass[:, 0], [1, 10])
    np.testing.assert_array_equal(world.parameters.inertia[:, 0], [3, 3])  # was given, so it stays
    world.apply_force("crate", force=(1, 0))
    world.step()
    np.testing.assert_allclose(world.linear_velocity[:, 0, 0] / world.timestep, [1, 0.1], rtol=1e-14)


def test_derived_mass_and_inertia() -> None:
    scene = Scene()
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5), density=2.0)])
    scene.add_body("disk", shapes=[Circle(radius=0.5)], position=(5, 0))
    scene.add_body("pill", shapes=[Capsule(half_length=0.5, radius=0.1)], position=(9, 0))
    scene.add_body("kite", shapes=[Polygon(vertices=[(0, 0), (2, 0), (0, 1)])], position=(15, 0))
    scene.add_body("given", shapes=[Circle(radius=0.5)], position=(20, 0), mass=4.0)
    world = World(scene, world_count=2)
    p = world.parameters
    p.set("box", half_extents=(1.0, 0.25), worlds=1)
    assert p.mass[1, 0] == pytest.approx(2 * 2 * 0.5)
    assert p.inertia[1, 0] == pytest.approx(2 * (4 + 0.25) / 12)
    assert p.mass[0, 0] == 2.0
    p.set("box", mass=6.0, worlds=1)  # inertia scales
    assert p.inertia[1, 0] == pytest.approx(6 * (4 + 0.25) / 12)
    p.set("disk", radius=1.0, density=3.0)
    np.testing.assert_allclose(p.mass[:, 1], 3 * math.pi)
    np.testing.assert_allclose(p.inertia[:, 1], 1.5 * math.pi)
    old = p.mass[0, 2]
    p.set("pill", density=5.0)
    np.testing.assert_allclose(p.mass[:, 2], 5 * old, rtol=1e-14)
    inertia = p.inertia[0, 3]
    p.set("kite", density=5.0)
    np.testing.assert_allclose(p.mass[:, 3], 5, rtol=1e-14)
    np.testing.assert_allclose(p.inertia[:, 3], 5 * inertia, rtol=1e-13)
    p.set("given", radius=1.0)  # a given mass stays, the inertia is the new form's
    np.testing.assert_array_equal(p.mass[:, 4], 4)
    np.testing.assert_allclose(p.inertia[:, 4], 0.5 * 4)
    for b in range(5):
        np.testing.assert_allclose(p.bodies["inv_mass"][:, b], 1 / p.mass[:, b], rtol=1e-15)
        np.testing.assert_allclose(p.bodies["inv_inertia"][:, b], 1 / p.inertia[:, b], rtol=1e-15)
    # the same numbers as if the scene had them
    again = Scene()
    again.add_body("pill", shapes=[Capsule(half_length=0.8, radius=0.3, density=5.0)])
    p.set("pill", half_length=0.8, radius=0.3)
    given = again.compile().nominal_bodies[0]
    for name in ("mass", "inertia", "extent", "radius"):
        np.testing.assert_allclose(p.bodies[name][:, 2], given[name], rtol=1e-14)


def test_size_by_world() -> None:
    world = World(stack(1), world_count=3)
    world.parameters.set("box_0", half_extents=[[0.5, 0.2], [0.5, 0.4]], worlds=[0, 2])
    world.step(60)
    np.testing.assert_allclose(world.position[:, 1, 1], [0.2, 0.5, 0.4], atol=1e-3)


def test_friction_by_world() -> None:
    # a box pushed along the ground: a = (F - mu m g) / m, or nothing
    world = World(stack(1), world_count=3)
    for b in ("ground", "box_0"):
        world.parameters.set(b, friction=[0.1, 0.3, 0.9])
    for _ in range(60):
        world.apply_force("box_0", force=(0.5 * G, 0), point=world.center_of_mass[0, 1] - [0, 0.4])
        world.step()
    speeds = world.linear_velocity[:, 1, 0]
    np.testing.assert_allclose(speeds[:2], [(0.5 - 0.1) * G, (0.5 - 0.3) * G], rtol=1e-3)
    assert abs(speeds[2]) < 1e-6


def test_enabled_by_world() -> None:
    world = World(stack(2), world_count=2, options=Options(sleep=False))
    world.parameters.set("box_0", enabled=False, worlds=1)
    world.step(45)
    np.testing.assert_allclose(world.position[:, 2, 1], [1.5, 0.5], atol=2e-3)
    assert world.position[1, 1, 1] == 0.5  # out of the world, it stays where it was
    assert set(world.contacts(1).body_b) == {2}
    np.testing.assert_array_equal(world.diagnostics().awake, [2, 1])
    world.set_pose("box_0", position=(5, 3), worlds=1)
    world.parameters.set("box_0", enabled=True, worlds=1)
    world.step(6)
    assert world.linear_velocity[1, 1, 1] == pytest.approx(-G * 0.1, rel=1e-12)


def test_a_force_on_a_disabled_body_is_not_kept() -> None:
    world = World(crate())
    world.parameters.set("crate", enabled=False)
    world.apply_force("crate", force=(1, 0))
    world.step()
    world.parameters.set("crate", enabled=True)
    world.step()
    assert world.linear_velocity[0, 0, 0] == 0.0


def test_unbounded_again() -> None:
    world = World(driven())
    joint, rule = (handle("joint", name, world.model.joint_names) for name in ("pull", "rule"))
    world.parameters.set(joint, max_force=INF)
    world.parameters.set(rule, lower=-INF, upper=INF)
    assert world.parameters.max_force[0, 0] == INF
    assert world.parameters.rows["upper"][0, 0] == INF


# ---------------------------------------------------------------- readings


def test_contacts_of_a_stack() -> None:
    world = World(stack(3))
    world.step(120)
    dt = world.timestep
    contacts = world.contacts()
    assert len(contacts) == 6
    force = contacts.force_vector(dt)
    for b in (1, 2, 3):
        onto = contacts.body_b == b
        assert (contacts.body_a[onto] == b - 1).all()  # normals go from a to b
        np.testing.assert_allclose(contacts.normal[onto], [(0, 1)] * 2, atol=1e-6)
        np.testing.assert_allclose(force[onto].sum(0), (0, (4 - b) * G), rtol=1e-3, atol=1e-3)
        np.testing.assert_allclose(contacts.point[onto, 1], b - 1, atol=1e-2)
        np.testing.assert_allclose(np.sort(contacts.point[onto, 0]), (-0.5, 0.5), atol=1e-2)
    assert contacts.touching.all()
    assert not contacts.sensor.any()
    assert (abs(contacts.separation) < 1e-3).all()


def test_normals_go_from_a_to_b_when_the_ground_comes_last() -> None:
    scene = Scene()
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 0.5))
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    world = World(scene)
    world.step(60)
    contacts = world.contacts()
    assert (contacts.body_a == 0).all()
    np.testing.assert_allclose(contacts.normal, [(0, -1)] * 2, atol=1e-9)
    np.testing.assert_allclose(contacts.force_vector(world.timestep).sum(0), (0, -G), rtol=1e-3, atol=1e-6)


def test_friction_force_opposes_the_slide() -> None:
    scene = stack(1)
    world = World(scene)
    world.set_velocity("box_0", linear=(5, 0))
    world.step(10)
    force = world.contacts().force_vector(world.timestep).sum(0)
    np.testing.assert_allclose(force, (-0.5 * G, G), rtol=1e-3)


def test_sensors() -> None:
    scene = stack(2)
    touch = scene.add_sensor("touch", ContactSensor("box_1"))
    scene.add_sensor("middle", ContactSensor("box_0"))
    scene.add_sensor("pose", PoseSensor("box_1"))
    scene.add_sensor("speed", VelocitySensor("box_1"))
    scene.add_sensor("floor", ContactSensor("ground"))
    world = World(scene, world_count=2)
    world.set_pose("box_1", position=(7, 9), angle=0.25, worlds=1)
    world.step(1)
    np.testing.assert_allclose(world.sensor("pose")[1], (7, 9 - 0.5 * G / 3600, 0.25), rtol=1e-12)
    np.testing.assert_allclose(world.sensor("speed")[1], (0, -G / 60, 0), rtol=1e-12)
    assert not world.sensor(touch)[1].any()
    world.reset()
    world.step(60)
    # the weight upwards on the top box; on the one between from both sides, its own; on the floor both
    np.testing.assert_allclose(world.sensor("touch"), [(1, 0, G)] * 2, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(world.sensor("middle"), [(1, 0, G)] * 2, rtol=1e-3, atol=1e-3)
    np.testing.assert_allclose(world.sensor("floor"), [(1, 0, -2 * G)] * 2, rtol=1e-3, atol=1e-3)


def test_diagnostics() -> None:
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    scene.add_body("a", shapes=[Circle(radius=0.5)], position=(0, 3), mass=2, inertia=0.5, angular_velocity=4,
                   linear_velocity=(1, -2))  # fmt: skip
    scene.add_body("b", shapes=[Circle(radius=0.5)], position=(5, 0.5), mass=3, inertia=1)
    scene.add_body("off", shapes=[Circle(radius=0.5)], position=(9, 0.5), mass=3, inertia=1, enabled=False)
    world = World(scene, world_count=2)
    d = world.diagnostics()
    np.testing.assert_allclose(d.kinetic_energy, 0.5 * 2 * 5 + 0.5 * 0.5 * 16)
    np.testing.assert_allclose(d.potential_energy, G * (2 * 3 + 3 * 0.5))
    np.testing.assert_allclose(d.energy, d.kinetic_energy + d.potential_energy)
    np.testing.assert_allclose(d.momentum, [(2, -4)] * 2)
    energy = d.energy[0]
    world.step(10)
    d = world.diagnostics()
    np.testing.assert_allclose(d.energy, energy, rtol=1e-9)
    for name, value in {"contacts": 1, "rows": 2, "islands": 2, "awake": 2, "impacts": 0, "unconverged": 0}.items():
        np.testing.assert_array_equal(getattr(d, name), value, err_msg=name)
    assert (d.pairs >= 1).all()
    np.testing.assert_array_equal(d.sweeps, 1)  # the ball at rest takes one substep, which one sweep confirms
    assert (d.residual < 1e-4).all()
    np.testing.assert_array_equal(d.joint_error, 0)


def test_penetration_is_reported() -> None:
    world = World(stack(1))
    world.set_pose("box_0", position=(0, 0.4))
    world.step()
    d = world.diagnostics()
    assert 0.05 < d.penetration[0] < 0.1
    angle = world.angle[0, 1]  # a little: two sweeps leave one corner deeper
    lowest = world.position[0, 1, 1] - 0.5 * (abs(math.sin(angle)) + math.cos(angle))
    assert d.penetration[0] == pytest.approx(-lowest, abs=1e-7)


# ---------------------------------------------------------------- buffers


def crowd() -> Scene:
    """40 disks on top of one another: far more contacts than the first buffers hold."""
    scene = Scene(gravity=(0, 0))
    for k in range(40):
        place = (0.01 * (k % 7), 0.013 * (k % 5))
        scene.add_body(f"disk_{k}", shapes=[Circle(radius=0.5)], position=place)
    return scene


def test_growing_buffers_leave_no_trace() -> None:
    small, large = World(crowd(), world_count=2), World(crowd(), world_count=2)
    capacity = small.state.contacts.shape[1]
    large.state.grow_contacts(4096)
    for world in (small, large):
        world.apply_force("disk_3", force=(5, 0))  # held for one step, however often it is tried
        world.step(5)
    assert small.state.contacts.shape[1] > capacity
    assert everything(small) == everything(large)
    assert (small.diagnostics().contacts > capacity).all()


def test_one_world_of_many_grows() -> None:
    world, alone = World(crowd(), world_count=3, threads=2), World(crowd())
    for k in range(40):  # apart, but for the last world
        world.set_pose(k, position=(3.0 * k, 0), worlds=[0, 1])
    world.step(5)
    alone.step(5)
    assert bits(world.state.bodies[2]) == bits(alone.state.bodies[0])
    np.testing.assert_array_equal(world.position[0, :, 0], 3.0 * np.arange(40))


def test_shapes_differ_from_world_to_world() -> None:
    """A terrain of its own, and a shape switched off, in one world only."""
    scene = Scene()
    flat = [(-5.0, 0.0), (0.0, 0.0), (5.0, 0.0)]
    scene.add_body("hills", "static", [Terrain(vertices=flat, name="ridge")])
    scene.add_body("crate", shapes=[Box(half_extents=(0.2, 0.2))], position=(2.0, 0.2))
    world = World(scene, world_count=3)
    raised = [(-5.0, 0.1), (0.0, 0.1), (5.0, 0.1)]
    world.parameters.set("ridge", worlds=1, vertices=raised)
    world.parameters.set("ridge", worlds=2, enabled=False)
    world.set_pose("crate", position=(2.0, 0.3), worlds=1)
    world.step(60)
    np.testing.assert_allclose(world.position[:2, 1, 1], [0.2, 0.3], atol=1e-4)
    assert world.position[2, 1, 1] == pytest.approx(0.2 - 0.5 * G * 1.0, abs=1e-9)
    before = world.parameters.vertices.tobytes()
    for bad in ([(-5.0, 0.1), (0.0, np.nan), (5.0, 0.1)], [(0.0, 0.0), (0.0, 0.0), (5.0, 0.0)], flat[:2]):
        with pytest.raises(ValueError, match="parameters of shape 'ridge'"):
            world.parameters.set("ridge", vertices=bad)
    assert world.parameters.vertices.tobytes() == before


def test_sizes_out_of_all_proportion_are_refused() -> None:
    """Finite sizes whose mass or inertia is not: nothing is changed."""
    world = World(driven())
    before = world.parameters.bodies.tobytes(), world.parameters.shapes.tobytes()
    for bad in ({"mass": 1e-320}, {"inertia": 1e-320}):
        with pytest.raises(ValueError, match="must be at least 1e-36"):
            world.parameters.set("crate", **bad)
    assert (world.parameters.bodies.tobytes(), world.parameters.shapes.tobytes()) == before
    world.apply_force("crate", force=(1e36, 0.0))
    with pytest.raises(ValueError, match="sum of forces"):
        world.apply_force("crate", force=(1e36, 0.0))
