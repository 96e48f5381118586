"""World: stepping, acting, parameters, readings, and what is refused."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.solver import Box, Capsule, Circle, HalfPlane, Handle, Options, Polygon, Scene, Terrain, World
from tests.solver.bits import bits, everything

G = 9.81
NAN, INF = math.nan, math.inf


def crate(gravity: tuple[float, float] = (0, 0), **given: Any) -> Scene:
    """One crate of 2 kg and 3 kg m^2, with a handle."""
    scene = Scene(gravity=gravity)
    scene.add_body("crate", shapes=[Box(half_extents=(0.5, 0.5))], mass=2.0, inertia=3.0, **given)
    return scene


def driven() -> Scene:
    scene = crate()
    scene.add_joint("pull", "target", body_b="crate", max_force=100.0)
    scene.add_joint("self", "target", body_b="crate")
    scene.add_body("other", shapes=[Circle(radius=0.5)], position=(5, 0))
    scene.add_joint("glue", "weld", "crate", "other")
    scene.add_constraint("rule", ["crate", "other"], [[1, 0, 0, -1, 0, 0]], lower=-5, upper=5)
    scene.add_actuator("left", "pull", "x")
    scene.add_actuator("right", "pull", "y")
    return scene


# ---------------------------------------------------------------- making and stepping


@pytest.mark.parametrize(
    ("given", "word"),
    [
        ({"world_count": 0}, "world_count"), ({"world_count": -1}, "world_count"),
        ({"world_count": 1.5}, "world_count"), ({"world_count": "2"}, "world_count"),
        ({"threads": 0}, "threads"), ({"threads": None}, "threads"), ({"options": {"substeps": 2}}, "options"),
    ],
)  # fmt: skip
def test_bad_worlds_are_refused(given: dict[str, Any], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        World(crate(), **given)


@pytest.mark.parametrize(
    "given",
    [
        {"timestep": 0.0}, {"timestep": -0.01}, {"timestep": NAN}, {"timestep": INF}, {"substeps": 0},
        {"substeps": 1.5}, {"sweeps": 0}, {"position_sweeps": -1}, {"tolerance": -1.0}, {"tolerance": NAN},
        {"solver": "magic"}, {"correction_rate": 1.5}, {"correction_rate": NAN}, {"slop": -1.0},
        {"sleep_speed": NAN}, {"sleep_time": -1.0}, {"push_speed": INF},
    ],
)  # fmt: skip
def test_bad_options_are_refused(given: dict[str, Any]) -> None:
    with pytest.raises(ValueError, match=next(iter(given))):
        Options(**given)


def test_step_counts() -> None:
    world = World(crate(gravity=(0, -G)), world_count=2)
    world.step()
    world.step(4)
    world.step(0)
    np.testing.assert_array_equal(world.state.worlds["step"], [5, 5])
    np.testing.assert_allclose(world.time, 5 / 60)
    for count in (-1, 1.5, "2", None):
        with pytest.raises(ValueError, match="count"):
            world.step(count)  # type: ignore[arg-type]
    # free fall, second order: exact
    assert world.linear_velocity[1, 0, 1] == pytest.approx(-G * 5 / 60, rel=1e-14)
    assert world.position[1, 0, 1] == pytest.approx(-0.5 * G * (5 / 60) ** 2, rel=1e-13)


def test_many_steps_at_once_are_the_same_steps() -> None:
    one, many = World(stack(3)), World(stack(3))
    for _ in range(20):
        one.step()
    many.step(20)
    assert everything(one) == everything(many)


@pytest.mark.parametrize(
    ("mask", "chosen"),
    [
        (None, [0, 1, 2, 3]), (2, [2]), (np.int64(1), [1]), ([0, 3], [0, 3]), ((1,), [1]), ([], []),
        (np.array([True, False, False, True]), [0, 3]), ([False, True, True, False], [1, 2]),
    ],
)  # fmt: skip
def test_reset(mask: Any, chosen: list[int]) -> None:
    world = World(crate(gravity=(0, -G), position=(0, 5), linear_velocity=(1, 2)), world_count=4)
    world.parameters.set("crate", mass=7.0)
    world.step(10)
    moved = world.position.copy()
    world.reset(mask)
    for w in range(4):
        if w in chosen:
            np.testing.assert_array_equal(world.position[w, 0], (0, 5))
            np.testing.assert_array_equal(world.linear_velocity[w, 0], (1, 2))
            assert world.time[w] == 0.0
            assert world.parameters.mass[w, 0] == 2.0
        else:
            np.testing.assert_array_equal(world.position[w], moved[w])
            assert world.parameters.mass[w, 0] == 7.0
    world.parameters.set("crate", mass=7.0)
    world.reset(parameters=False)
    assert (world.parameters.mass == 7.0).all()


@pytest.mark.parametrize("mask", [4, -1, [0, 0], 1.5, "0", [True, False], [[0]], [0, 9]])
def test_bad_reset_changes_nothing(mask: Any) -> None:
    world = World(crate(gravity=(0, -G)), world_count=4)
    world.step(3)
    before = everything(world)
    with pytest.raises(ValueError, match="reset"):
        world.reset(mask)
    assert everything(world) == before


def test_a_reset_world_runs_as_a_new_one() -> None:
    world, new = World(stack(4), world_count=2), World(stack(4), world_count=2)
    world.parameters.set("box_1", mass=50.0, friction=0.1)
    world.apply_force("box_3", (400, 0))
    world.step(50)
    world.apply_force("box_3", (400, 0))
    world.reset()
    world.step(40)
    new.step(40)
    assert everything(world) == everything(new)


def test_options_may_change_between_steps() -> None:
    world = World(crate(linear_velocity=(1, 0)))
    world.step()
    world.options = Options(timestep=0.1)
    world.step()
    assert world.position[0, 0, 0] == pytest.approx(1 / 60 + 0.1, rel=1e-13)
    with pytest.raises(ValueError, match="options"):
        world.options = None  # type: ignore[assignment]
    assert world.timestep == 0.1


def test_a_copied_world_goes_on_alike() -> None:
    world = World(driven(), world_count=2)
    world.control[:] = 0.5
    world.step(5)
    twin = copy.deepcopy(world)
    twin.parameters.set("crate", mass=9.0)
    assert (world.parameters.mass[:, 0] == 2.0).all()
    twin.parameters.set("crate", mass=2.0)
    twin.control[:] = 0.5
    for w in (world, twin):
        w.step(20)
    assert everything(world) == everything(twin)


# ---------------------------------------------------------------- control


def test_control_may_be_assigned() -> None:
    world = World(driven(), world_count=3)
    world.control = 0.5
    assert (world.state.control == 0.5).all()
    world.control = [[1, 2], [3, 4], [5, 6]]
    np.testing.assert_array_equal(world.state.control, [[1, 2], [3, 4], [5, 6]])
    for bad in ([1, 2, 3], NAN, "fast"):
        with pytest.raises(ValueError, match="control"):
            world.control = bad
    np.testing.assert_array_equal(world.state.control[0], [1, 2])


@pytest.mark.parametrize("bad", [NAN, INF, -INF])
def test_bad_control_moves_nothing(bad: float) -> None:
    world = World(driven(), world_count=3)
    world.step(2)
    world.control[1, 1] = bad
    before = everything(world)
    with pytest.raises(ValueError, match=r"actuator 'right' in world 1 must be finite"):
        world.step()
    assert everything(world) == before


def test_control_is_clipped_to_the_actuators_range() -> None:
    scene = crate()
    scene.add_joint("pull", "target", body_b="crate", frequency=20.0)
    scene.add_actuator("x", "pull", "x", lower=-1.0, upper=2.0)
    world = World(scene)
    for control, speed in ((50.0, 2.0), (-50.0, -1.0)):
        world.control[:] = control
        world.step(60)
        assert world.linear_velocity[0, 0, 0] == pytest.approx(speed, rel=1e-3)


# ---------------------------------------------------------------- forces


def test_force_is_mass_times_acceleration() -> None:
    world = World(crate(position=(1, 1)), world_count=2)
    dt = world.timestep
    world.apply_force("crate", (6.0, -4.0), worlds=1)
    world.step()
    np.testing.assert_allclose(world.linear_velocity[1, 0], (3 * dt, -2 * dt), rtol=1e-14)
    np.testing.assert_allclose(world.position[1, 0], (1 + 1.5 * dt**2, 1 - dt**2), rtol=1e-14)
    assert world.angular_velocity[1, 0] == 0.0
    assert not world.linear_velocity[0].any()
    # cleared after one step
    velocity = world.linear_velocity.copy()
    world.step()
    np.testing.assert_array_equal(world.linear_velocity, velocity)


def test_force_at_a_point_turns() -> None:
    world = World(crate(position=(1, 1), angle=0.3))
    dt = world.timestep
    world.apply_force("crate", (6.0, -4.0), point=(1.5, 2.0), torque=2.0)
    world.step()
    # r x F = .5 * -4 - 1 * 6, and the torque on top; I = 3
    assert world.angular_velocity[0, 0] == pytest.approx((-2 - 6 + 2) / 3 * dt, rel=1e-13)
    np.testing.assert_allclose(world.linear_velocity[0, 0], (3 * dt, -2 * dt), rtol=1e-14)


def test_point_is_relative_to_the_centre_of_mass() -> None:
    scene = Scene(gravity=(0, 0))
    scene.add_body("off", shapes=[Circle(radius=0.5, position=(1.0, 0.0))], position=(2, 0))
    world = World(scene)
    world.apply_force("off", (0, 1), point=(3, 0))  # right through it
    world.step()
    assert world.angular_velocity[0, 0] == 0.0
    assert world.linear_velocity[0, 0, 1] > 0.0


def test_forces_add_up_and_differ_by_world() -> None:
    world = World(crate(), world_count=3)
    dt = world.timestep
    world.apply_force("crate", [[1, 0], [3, 0]], worlds=[0, 2])
    world.apply_force("crate", (2, 0), worlds=[False, True, True])
    world.step()
    np.testing.assert_allclose(world.linear_velocity[:, 0, 0], np.array([1, 2, 5]) / 2 * dt, rtol=1e-14)


def test_force_lasts_over_all_substeps() -> None:
    world = World(crate(), options=Options(substeps=7))
    world.apply_force("crate", (2, 0))
    world.step()
    assert world.linear_velocity[0, 0, 0] == pytest.approx(world.timestep, rel=1e-14)


ACTS: dict[str, Any] = {
    "force NaN": lambda w: w.apply_force("crate", (NAN, 0)),
    "force of three": lambda w: w.apply_force("crate", (1, 2, 3)),
    "force text": lambda w: w.apply_force("crate", "left"),
    "force's point NaN": lambda w: w.apply_force("crate", (1, 0), point=(0, NAN)),
    "torque inf": lambda w: w.apply_force("crate", (1, 0), torque=INF),
    "force's body": lambda w: w.apply_force("crat", (1, 0)),
    "force's world": lambda w: w.apply_force("crate", (1, 0), worlds=7),
    "forces of three for two": lambda w: w.apply_force("crate", [[1, 0]] * 3),
    "pose NaN": lambda w: w.set_pose("crate", (NAN, 0)),
    "pose's angle": lambda w: w.set_pose("crate", (3, 0), angle=INF),
    "pose's shape": lambda w: w.set_pose("crate", (1, 2, 3)),
    "pose's body": lambda w: w.set_pose(99, (1, 2)),
    "velocity NaN": lambda w: w.set_velocity("crate", (1, 0), NAN),
    "velocity of a static body": lambda w: w.set_velocity("floor", (1, 0)),
    "target NaN": lambda w: w.set_target("pull", (1, 0), linear=(NAN, 0)),
    "target angle inf": lambda w: w.set_target("pull", angle=INF),
    "target of a weld": lambda w: w.set_target("glue", (1, 0)),
    "target of no joint": lambda w: w.set_target("push", (1, 0)),
    "sensor": lambda w: w.sensor("nose"),
    "contacts of no world": lambda w: w.contacts(2),
    "gravity NaN": lambda w: w.parameters.set(gravity=(0, NAN)),
    "gravity 3D": lambda w: w.parameters.set(gravity=(0, 0, 1)),
    "no field": lambda w: w.parameters.set("crate"),
    "world field": lambda w: w.parameters.set(friction=0.5),
    "unknown field": lambda w: w.parameters.set("crate", fraction=0.5),
    "unknown body": lambda w: w.parameters.set("create", friction=0.5),
    "mass zero": lambda w: w.parameters.set("crate", friction=0.9, mass=0),
    "mass NaN": lambda w: w.parameters.set("crate", friction=0.9, mass=NAN),
    "mass in one of two": lambda w: w.parameters.set("crate", mass=[1.0, -1.0]),
    "masses of three for two": lambda w: w.parameters.set("crate", mass=[1.0, 2.0, 3.0]),
    "inertia zero": lambda w: w.parameters.set("crate", inertia=0),
    "size zero": lambda w: w.parameters.set("crate", half_extents=(1, 0)),
    "size of another shape": lambda w: w.parameters.set("crate", radius=1.0),
    "size of a plane": lambda w: w.parameters.set("floor", half_extents=(1.0, 1.0)),
    "size of one of two shapes": lambda w: w.parameters.set("pair", radius=1.0),
    "density zero": lambda w: w.parameters.set("other", density=0.0),
    "density negative": lambda w: w.parameters.set("crate", density=-1.0),
    "friction negative": lambda w: w.parameters.set("crate", friction=-1.0),
    "restitution inf": lambda w: w.parameters.set("crate", restitution=INF),
    "damping negative": lambda w: w.parameters.set("crate", linear_damping=-1.0),
    "mass of a plane": lambda w: w.parameters.set("floor", mass=1.0),
    "enabled NaN": lambda w: w.parameters.set("crate", enabled=NAN),
    "joint frequency": lambda w: w.parameters.set(w.handle, frequency=-1.0),
    "target rigid": lambda w: w.parameters.set(w.handle, frequency=0.0),
    "joint force NaN": lambda w: w.parameters.set(w.handle, max_force=NAN),
    "bound of a target": lambda w: w.parameters.set(w.handle, upper=1.0),
    "bounds crossed": lambda w: w.parameters.set(w.rule, upper=-6.0),
    "bound NaN": lambda w: w.parameters.set(w.rule, lower=NAN),
    "softness negative": lambda w: w.parameters.set(w.rule, softness=-1.0),
    "bias inf": lambda w: w.parameters.set(w.rule, bias=INF),
}


@pytest.mark.parametrize("case", ACTS)
def test_refused_acts_change_nothing(case: str) -> None:
    scene = driven()
    scene.add_body("floor", kind="static", shapes=[HalfPlane()], position=(0, -9))
    scene.add_body("pair", shapes=[Circle(radius=0.1), Circle(radius=0.1, position=(1, 0))], position=(20, 0))
    world = World(scene, world_count=2)
    late = scene.add_joint("late", "target", body_b="crate")  # after the world was made
    with pytest.raises(ValueError, match="late"):
        world.parameters.set(late, max_force=1.0)
    world.handle = handle("joint", "pull", world.model.joint_names)  # type: ignore[attr-defined]
    world.rule = handle("joint", "rule", world.model.joint_names)  # type: ignore[attr-defined]
    before = everything(world)
    with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
        ACTS[case](world)
    assert everything(world) == before


def handle(what: str, name: str, names: tuple[str, ...]) -> Any:
    return Handle(what, name, names.index(name))


def test_readings_are_copies() -> None:
    world = World(driven())
    for reading in (
        world.position, world.center_of_mass, world.angle, world.linear_velocity, world.angular_velocity
    ):  # fmt: skip
        before = everything_of(world)
        reading += 1.0
        assert everything_of(world) == before


def everything_of(world: World) -> bytes:
    bodies = world.state.bodies
    return b"".join(bodies[name].tobytes() for name in ("position", "angle", "velocity"))


def test_views_are_read_only() -> None:
    world = World(driven())
    p = world.parameters
    views = [
        p.mass, p.inertia, p.friction, p.restitution, p.density, p.radius, p.half_extents, p.gravity, p.enabled,
        p.linear_damping, p.gravity_scale, p.frequency, p.max_force,
    ]  # fmt: skip
    for view in views:
        with pytest.raises(ValueError, match="read-only"):
            view[...] = 1
    with pytest.raises(AttributeError, match="fraction"):
        _ = p.fraction


def test_set_velocity_and_pose() -> None:
    world = World(crate(linear_velocity=(1, 2), angular_velocity=3), world_count=2)
    world.set_velocity("crate", angular=[4, 5])
    np.testing.assert_array_equal(world.linear_velocity[:, 0], [[1, 2], [1, 2]])
    np.testing.assert_array_equal(world.angular_velocity[:, 0], [4, 5])
    world.set_velocity("crate", (0, 0), worlds=0)
    np.testing.assert_array_equal(world.linear_velocity[:, 0], [[0, 0], [1, 2]])
    world.set_pose("crate", [[1, 2], [3, 4]], angle=[0.5, -0.5])
    np.testing.assert_array_equal(world.position[:, 0], [[1, 2], [3, 4]])
    np.testing.assert_array_equal(world.angle[:, 0], [0.5, -0.5])
    rotation = world.state.bodies["rotation"][:, 0]
    np.testing.assert_allclose(rotation, [[math.cos(0.5), math.sin(0.5)], [math.cos(0.5), -math.sin(0.5)]], rtol=1e-15)


def test_set_target_moves_the_goal() -> None:
    scene = crate()
    scene.add_joint("pull", "target", body_b="crate", frequency=3.0)
    world = World(scene, world_count=2)
    world.set_target("pull", position=(2, -1), angle=0.7, worlds=1)
    world.step(120)
    np.testing.assert_allclose(world.position[1, 0], (2, -1), atol=1e-6)
    assert world.angle[1, 0] == pytest.approx(0.7, abs=1e-6)
    np.testing.assert_allclose(world.position[0, 0], (0, 0), atol=1e-12)
    world.set_target("pull", linear=(1, 0), angular=0.5, worlds=0)
    world.step(120)
    np.testing.assert_allclose(world.linear_velocity[0, 0], (1, 0), atol=1e-6)
    np.testing.assert_allclose(world.position[0, 0], (2, 0), atol=1e-5)  # 2 s at 1 m/s, without lag
    assert world.angle[0, 0] == pytest.approx(1.0, abs=1e-5)


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
    world.apply_force("crate", (1, 0))
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
    # the same numbers as if authored so
    again = Scene()
    again.add_body("pill", shapes=[Capsule(half_length=0.8, radius=0.3, density=5.0)])
    p.set("pill", half_length=0.8, radius=0.3)
    authored = again.compile().nominal_bodies[0]
    for name in ("mass", "inertia", "extent", "radius"):
        np.testing.assert_allclose(p.bodies[name][:, 2], authored[name], rtol=1e-14)


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
        world.apply_force("box_0", (0.5 * G, 0), point=world.center_of_mass[0, 1] - [0, 0.4])
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
    world.set_pose("box_0", (5, 3), worlds=1)
    world.parameters.set("box_0", enabled=True, worlds=1)
    world.step(6)
    assert world.linear_velocity[1, 1, 1] == pytest.approx(-G * 0.1, rel=1e-12)


def test_a_force_on_a_disabled_body_is_not_kept() -> None:
    world = World(crate())
    world.parameters.set("crate", enabled=False)
    world.apply_force("crate", (1, 0))
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
    world.set_velocity("box_0", (5, 0))
    world.step(10)
    force = world.contacts().force_vector(world.timestep).sum(0)
    np.testing.assert_allclose(force, (-0.5 * G, G), rtol=1e-3)


def test_sensors() -> None:
    scene = stack(2)
    touch = scene.add_sensor("touch", "contact", "box_1")
    scene.add_sensor("middle", "contact", "box_0")
    scene.add_sensor("pose", "pose", "box_1")
    scene.add_sensor("speed", "velocity", "box_1")
    scene.add_sensor("floor", "contact", "ground")
    world = World(scene, world_count=2)
    world.set_pose("box_1", (7, 9), 0.25, worlds=1)
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
    assert (d.sweeps >= 2).all()
    assert (d.residual < 1e-4).all()
    np.testing.assert_array_equal(d.joint_error, 0)


def test_penetration_is_reported() -> None:
    world = World(stack(1))
    world.set_pose("box_0", (0, 0.4))
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
        world.apply_force("disk_3", (5, 0))  # held for one step, however often it is tried
        world.step(5)
    assert small.state.contacts.shape[1] > capacity
    assert everything(small) == everything(large)
    assert (small.diagnostics().contacts > capacity).all()


def test_one_world_of_many_grows() -> None:
    world, alone = World(crowd(), world_count=3, threads=2), World(crowd())
    for k in range(40):  # apart, but for the last world
        world.set_pose(k, (3.0 * k, 0), worlds=[0, 1])
    world.step(5)
    alone.step(5)
    assert bits(world.state.bodies[2]) == bits(alone.state.bodies[0])
    np.testing.assert_array_equal(world.position[0, :, 0], 3.0 * np.arange(40))


def test_shapes_differ_from_world_to_world() -> None:
    """A terrain of its own, and a shape switched off, in one world only."""
    scene = Scene()
    flat = [(-5.0, 0.0), (0.0, 0.0), (5.0, 0.0)]
    scene.add_body("hills", "static", [Terrain(vertices=flat, name="hills")])
    scene.add_body("crate", shapes=[Box(half_extents=(0.2, 0.2))], position=(2.0, 0.2))
    world = World(scene, world_count=3)
    raised = [(-5.0, 0.1), (0.0, 0.1), (5.0, 0.1)]
    world.parameters.set_shape("hills", worlds=1, vertices=raised)
    world.parameters.set_shape("hills", worlds=2, enabled=False)
    world.set_pose("crate", (2.0, 0.3), worlds=1)
    world.step(60)
    np.testing.assert_allclose(world.position[:2, 1, 1], [0.2, 0.3], atol=1e-4)
    assert world.position[2, 1, 1] == pytest.approx(0.2 - 0.5 * G * 1.0, abs=1e-9)
    before = world.parameters.vertices.tobytes()
    for bad in ([(-5.0, 0.1), (0.0, np.nan), (5.0, 0.1)], [(0.0, 0.0), (0.0, 0.0), (5.0, 0.0)], flat[:2]):
        with pytest.raises(ValueError, match="parameters of shape 'hills'"):
            world.parameters.set_shape("hills", vertices=bad)
    assert world.parameters.vertices.tobytes() == before


def test_sizes_out_of_all_proportion_are_refused() -> None:
    """Finite sizes whose mass or inertia is not: nothing is changed."""
    world = World(driven())
    before = world.parameters.bodies.tobytes(), world.parameters.shapes.tobytes()
    for bad in ({"mass": 1e-320}, {"inertia": 1e-320}):
        with pytest.raises(ValueError, match="finite"):
            world.parameters.set("crate", **bad)
    assert (world.parameters.bodies.tobytes(), world.parameters.shapes.tobytes()) == before
    world.apply_force("crate", (1e308, 0.0))
    with pytest.raises(ValueError, match="sum of forces"):
        world.apply_force("crate", (1e308, 0.0))
