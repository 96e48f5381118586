"""World: stepping, acting, and what is refused."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.api import world as world_module
from gsenv.solver.planar import Circle, HalfPlane, Target, Weld
from gsenv.solver.records.kernel_variants import ONE_KERNEL, kernel_variant_of
from gsenv.solver.records.kernel_world import has_restitution
from tests.solver.bits import everything
from tests.solver.small_scenes import crate, driven, handle

G = 9.81
NAN, INF = math.nan, math.inf


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
    world.apply_force("box_3", force=(400, 0))
    world.step(50)
    world.apply_force("box_3", force=(400, 0))
    world.reset()
    world.step(40)
    new.step(40)
    assert everything(world) == everything(new)


def test_acts_between_steps_keep_the_kernels_arguments(monkeypatch: pytest.MonkeyPatch) -> None:
    """Making them costs many times a step: a vector env that resets a world each step would crawl."""
    world = World(stack(4), world_count=2)
    world.step()
    snapshot = world.save()
    monkeypatch.setattr(world_module, "kernel_world", None)
    world.reset(1)
    world.restore(snapshot)
    world.parameters.set(1, mass=2.0, restitution=0.0)
    world.step()  # calls kernel_world only to make them again
    assert world.state.worlds["step"].tolist() == [2, 2]


def test_only_a_first_restitution_needs_another_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(ONE_KERNEL, raising=False)
    world = World(stack(4), world_count=2)
    variant = kernel_variant_of(world.model)
    assert not has_restitution(variant, world.parameters)
    world.parameters.set(1, worlds=1, restitution=0.5)
    assert has_restitution(variant, world.parameters)
    world.reset(1)
    assert not has_restitution(variant, world.parameters)


def test_options_may_change_between_steps() -> None:
    world = World(crate(linear_velocity=(1, 0)))
    world.step()
    world.options = Options(timestep=0.05)
    world.step()
    assert world.position[0, 0, 0] == pytest.approx(1 / 60 + 0.05, rel=1e-13)
    with pytest.raises(ValueError, match="options"):
        world.options = None  # type: ignore[assignment]
    assert world.timestep == 0.05


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
    scene.add_joint("pull", Target("crate", frequency=20.0))
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
    world.apply_force("crate", force=(6.0, -4.0), worlds=1)
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
    world.apply_force("crate", force=(6.0, -4.0), point=(1.5, 2.0), torque=2.0)
    world.step()
    # r x F = .5 * -4 - 1 * 6, and the torque on top; I = 3
    assert world.angular_velocity[0, 0] == pytest.approx((-2 - 6 + 2) / 3 * dt, rel=1e-13)
    np.testing.assert_allclose(world.linear_velocity[0, 0], (3 * dt, -2 * dt), rtol=1e-14)


def test_point_is_relative_to_the_centre_of_mass() -> None:
    scene = Scene(gravity=(0, 0))
    scene.add_body("off", shapes=[Circle(radius=0.5, position=(1.0, 0.0))], position=(2, 0))
    world = World(scene)
    world.apply_force("off", force=(0, 1), point=(3, 0))  # right through it
    world.step()
    assert world.angular_velocity[0, 0] == 0.0
    assert world.linear_velocity[0, 0, 1] > 0.0


def test_forces_add_up_and_differ_by_world() -> None:
    world = World(crate(), world_count=3)
    dt = world.timestep
    world.apply_force("crate", force=[[1, 0], [3, 0]], worlds=[0, 2])
    world.apply_force("crate", force=(2, 0), worlds=[False, True, True])
    world.step()
    np.testing.assert_allclose(world.linear_velocity[:, 0, 0], np.array([1, 2, 5]) / 2 * dt, rtol=1e-14)


def test_force_lasts_over_all_substeps() -> None:
    world = World(crate(), options=Options(substeps=7))
    world.apply_force("crate", force=(2, 0))
    world.step()
    assert world.linear_velocity[0, 0, 0] == pytest.approx(world.timestep, rel=1e-14)


ACTS: dict[str, Any] = {
    "force NaN": lambda w: w.apply_force("crate", force=(NAN, 0)),
    "force of three": lambda w: w.apply_force("crate", force=(1, 2, 3)),
    "force text": lambda w: w.apply_force("crate", force="left"),
    "force's point NaN": lambda w: w.apply_force("crate", force=(1, 0), point=(0, NAN)),
    "torque inf": lambda w: w.apply_force("crate", force=(1, 0), torque=INF),
    "force missing": lambda w: w.apply_force("crate"),
    "point without a force": lambda w: w.apply_force("crate", torque=1.0, point=(0, 0)),
    "force's body": lambda w: w.apply_force("crat", force=(1, 0)),
    "force's world": lambda w: w.apply_force("crate", force=(1, 0), worlds=7),
    "forces of three for two": lambda w: w.apply_force("crate", force=[[1, 0]] * 3),
    "pose NaN": lambda w: w.set_pose("crate", position=(NAN, 0)),
    "pose's angle": lambda w: w.set_pose("crate", position=(3, 0), angle=INF),
    "pose's shape": lambda w: w.set_pose("crate", position=(1, 2, 3)),
    "pose's body": lambda w: w.set_pose(99, position=(1, 2)),
    "velocity NaN": lambda w: w.set_velocity("crate", linear=(1, 0), angular=NAN),
    "velocity of a static body": lambda w: w.set_velocity("floor", linear=(1, 0)),
    "target NaN": lambda w: w.set_target("pull", position=(1, 0), linear=(NAN, 0)),
    "target angle inf": lambda w: w.set_target("pull", angle=INF),
    "target of a weld": lambda w: w.set_target("glue", position=(1, 0)),
    "target of no joint": lambda w: w.set_target("push", position=(1, 0)),
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
    late = scene.add_joint("late", Target("crate"))  # after the world was made
    with pytest.raises(ValueError, match="late"):
        world.parameters.set(late, max_force=1.0)
    world.handle = handle("joint", "pull", world.model.joint_names)  # type: ignore[attr-defined]
    world.rule = handle("joint", "rule", world.model.joint_names)  # type: ignore[attr-defined]
    before = everything(world)
    with pytest.raises(ValueError, match=r"^[^\n]+\.$"):
        ACTS[case](world)
    assert everything(world) == before


def test_parameters_are_set_by_any_name_or_handle() -> None:
    scene = driven()
    rule = Handle("joint", "rule", list(scene.joints).index("rule"))
    world = World(scene)
    parameters = world.parameters
    parameters.set("pull", max_force=7.0)
    parameters.set(rule, upper=4.0)
    parameters.set("rule", lower=-4.0)
    parameters.set("crate/0", friction=0.25)
    parameters.set("other", friction=0.75)
    assert parameters.max_force[0, 0] == 7.0
    assert (parameters.rows["lower"][0, 0], parameters.rows["upper"][0, 0]) == (-4.0, 4.0)
    np.testing.assert_array_equal(parameters.friction[0], [0.25, 0.75])


def test_a_name_of_two_things_is_refused() -> None:
    scene = driven()
    scene.add_joint("crate", Weld("crate", "other"))
    world = World(scene)
    with pytest.raises(ValueError, match=r"^parameters: 'crate' names a body and a joint; give a handle"):
        world.parameters.set("crate", enabled=False)
    world.parameters.set(Handle("joint", "crate", len(scene.joints) - 1), enabled=False)
    assert world.parameters.enabled.all()  # of the bodies


def test_a_name_of_two_shapes_is_refused() -> None:
    scene = Scene()
    for name in ("left", "right"):
        scene.add_body(name, shapes=[Circle(radius=0.5, name="pad")])
    world = World(scene)
    with pytest.raises(ValueError, match="'pad' names a shape and another shape; give a handle"):
        world.parameters.set("pad", friction=0.9)
    world.parameters.set(Handle("shape", "pad", 1), friction=0.9)
    np.testing.assert_array_equal(world.parameters.friction[0], [0.5, 0.9])


def test_fields_of_a_shape_are_checked() -> None:
    world = World(driven())
    with pytest.raises(ValueError, match="parameters of shape 'crate/0': field 'mass' is unknown"):
        world.parameters.set("crate/0", mass=1.0)
    with pytest.raises(ValueError, match="only a terrain's vertices can be moved"):
        world.parameters.set("crate/0", friction=0.1, vertices=[(0, 0)])
    assert world.parameters.friction[0, 0] == 0.5


def test_what_is_set_is_named() -> None:
    world: Any = World(driven())
    for act in (world.set_pose, world.set_velocity, world.apply_force, world.set_target, world.set_motor):
        with pytest.raises(TypeError):
            act("crate", (1.0, 0.0))


def test_a_torque_needs_no_force() -> None:
    world = World(crate())
    world.apply_force("crate", torque=1.5)
    np.testing.assert_array_equal(world.state.bodies["force"][0, 0], [0.0, 0.0, 1.5])


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
    world.set_velocity("crate", linear=(0, 0), worlds=0)
    np.testing.assert_array_equal(world.linear_velocity[:, 0], [[0, 0], [1, 2]])
    world.set_pose("crate", position=[[1, 2], [3, 4]], angle=[0.5, -0.5])
    np.testing.assert_array_equal(world.position[:, 0], [[1, 2], [3, 4]])
    np.testing.assert_array_equal(world.angle[:, 0], [0.5, -0.5])
    rotation = world.state.bodies["rotation"][:, 0]
    np.testing.assert_allclose(rotation, [[math.cos(0.5), math.sin(0.5)], [math.cos(0.5), -math.sin(0.5)]], rtol=1e-15)


def test_set_target_moves_the_goal() -> None:
    scene = crate()
    scene.add_joint("pull", Target("crate", frequency=3.0))
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
