"""Islands at rest stop, cost nothing, stay put, and wake for everything that could move them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.scenes import stack
from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.planar import Box, Circle
from tests.solver.bits import everything

G = 9.81


def tower(count: int = 4) -> Scene:
    """Boxes on a static plank; a kinematic pusher and a ball, both far away."""
    scene = Scene()
    scene.add_body("plank", kind="static", shapes=[Box(half_extents=(3, 0.5))], position=(0, -0.5))
    for k in range(count):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 0.5 + k))
    pusher = Box(half_extents=(0.2, 0.2))
    scene.add_body("pusher", kind="kinematic", shapes=[pusher], position=(-5, 0.5))
    scene.add_body("ball", shapes=[Circle(radius=0.3)], position=(5, 0.5), gravity_scale=0.0)
    return scene


BOXES = slice(1, 5)


def sleeping(world_count: int = 1) -> World:
    world = World(tower(), world_count)
    world.step(120)
    assert world.asleep[:, BOXES].all()
    return world


def test_a_stack_falls_asleep_and_costs_nothing() -> None:
    world = World(stack(10))
    steps = 0
    while not world.asleep[0, 1:].all():
        world.step()
        steps += 1
        assert steps < 180
    assert steps * world.timestep >= Options().sleep_time
    world.step()
    d = world.diagnostics()
    for name in ("awake", "rows", "pairs", "islands", "sweeps", "impacts"):
        assert getattr(d, name)[0] == 0, name
    assert not world.linear_velocity.any()


def test_sleepers_do_not_drift() -> None:
    world = sleeping()
    pose = world.position.copy(), world.angle.copy()
    contacts = world.contacts()
    world.step(10_000)
    np.testing.assert_array_equal(world.position, pose[0])
    np.testing.assert_array_equal(world.angle, pose[1])
    later = world.contacts()
    for name in ("body_a", "body_b", "point", "normal", "separation", "impulse"):
        np.testing.assert_array_equal(getattr(later, name), getattr(contacts, name), err_msg=name)


def test_sleeping_contacts_are_still_reported() -> None:
    world = sleeping()
    contacts = world.contacts()
    assert len(contacts) == 8
    onto = contacts.body_b == 1
    load = contacts.force_vector(world.timestep)[onto].sum(0)
    np.testing.assert_allclose(load, (0, 4 * G), rtol=1e-2, atol=1e-2)
    # also next to others that are awake, and to islands that come and go
    world.set_velocity("ball", linear=(0, 1.0))
    world.step(30)
    assert world.diagnostics().awake[0] == 1
    assert len(world.contacts()) == 8
    np.testing.assert_array_equal(world.contacts().point, contacts.point)


def hit(world: World) -> None:
    world.set_pose("ball", position=(2.0, 0.5))
    world.step(60)  # set_pose wakes all of the world: back to sleep first
    assert world.asleep[0, BOXES].all()
    world.set_velocity("ball", linear=(-10, 0))
    world.step(5)
    assert world.asleep[0, BOXES].all()


def push_along(world: World) -> None:
    world.set_pose("pusher", position=(-0.8, 0.5))
    world.step(60)
    assert world.asleep[0, BOXES].all()
    world.set_velocity("pusher", linear=(1, 0))


WAKERS: dict[str, Callable[[World], None]] = {
    "hit": hit,
    "force": lambda world: world.apply_force("box_0", force=(5, 0)),
    "force on the top": lambda world: world.apply_force("box_3", force=(0, 5)),
    "support moved": lambda world: world.set_pose("plank", position=(0, -0.6)),
    "support gone": lambda world: world.parameters.set("plank", enabled=False),
    "neighbour gone": lambda world: world.parameters.set("box_0", enabled=False),
    "neighbour moved": lambda world: world.set_pose("box_0", position=(9, 9)),
    "kinematic": push_along,
    "velocity": lambda world: world.set_velocity("box_2", linear=(0.5, 0)),
    "gravity": lambda world: world.parameters.set(gravity=(0, 5)),
}


@pytest.mark.parametrize("how", WAKERS)
def test_wakes(how: str) -> None:
    world = sleeping(2)
    others = everything(world, 1) if how in ("force",) else b""
    if how == "force":
        world.apply_force("box_0", force=(5, 0), worlds=0)
    else:
        WAKERS[how](world)
    awake = 0
    for _ in range(20):
        world.step()
        awake = max(awake, int(world.diagnostics().awake[0]))
        if others:
            assert world.asleep[1, BOXES].all()  # the other world sleeps on
    least = 3 if "gone" in how or "neighbour" in how else 4
    assert awake >= least, "the island wakes as a whole"
    moved = np.abs(world.position[0, BOXES] - sleeping().position[0, BOXES]).max()
    if "force" not in how:
        assert moved > 1e-3


def test_a_force_is_felt_in_the_very_step() -> None:
    world = sleeping()
    world.apply_force("box_3", force=(0, 60.0))
    world.step()
    assert world.linear_velocity[0, 4, 1] == pytest.approx((60 - G) / 60, rel=1e-3)


def test_support_gone_means_free_fall() -> None:
    world = sleeping()
    world.parameters.set("plank", enabled=False)
    world.step(6)
    np.testing.assert_allclose(world.linear_velocity[0, BOXES, 1], -G * 0.1, rtol=1e-6)


def test_an_island_sleeps_only_as_a_whole() -> None:
    # a ball rolls on the top box: those below rest, yet stay awake with it
    scene = tower(3)
    scene.add_body("roller", shapes=[Circle(radius=0.1)], position=(-0.45, 3.1), linear_velocity=(0.02, 0))
    world = World(scene)
    for _ in range(60):
        world.step()
    assert world.state.bodies["sleep_time"][0, 1] > 0.4
    world.step(60)
    assert not world.asleep[0, 1:4].any()
    assert not world.asleep[0, 6]
    world.set_velocity("roller", linear=(0, 0), angular=0.0)
    world.step(60)
    assert world.asleep[0, 1:4].all()


def test_a_slow_lift_keeps_its_load_awake() -> None:
    scene = Scene()
    lift = Box(half_extents=(2, 0.1))
    scene.add_body("lift", kind="kinematic", shapes=[lift], linear_velocity=(0.001, 0.002))
    for k in range(3):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 0.6 + k))
    world = World(scene)
    world.step(1800)
    np.testing.assert_allclose(world.position[0, 1:, 1] - world.position[0, 0, 1], (0.6, 1.6, 2.6), atol=1e-3)
    np.testing.assert_allclose(world.position[0, :, 0], 0.03, atol=1e-3)
    assert not world.asleep.any()
    # a lift that stops lets it sleep
    world.set_velocity("lift", linear=(0, 0))
    world.step(60)
    assert world.asleep[0, 1:].all()


@pytest.mark.parametrize("count", [1, 10])
def test_a_lift_that_starts_carries_its_load(count: int) -> None:
    scene = Scene()
    lift = Box(half_extents=(2, 0.1))
    scene.add_body("lift", kind="kinematic", shapes=[lift])
    for k in range(count):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 0.6 + k))
    world = World(scene)
    world.step(120)
    assert world.asleep[0, 1:].all()
    world.set_velocity("lift", linear=(0, 2))
    world.step(60)
    np.testing.assert_allclose(world.position[0, 0, 1], 2, rtol=1e-12)
    np.testing.assert_allclose(world.position[0, 1:, 1] - 2, 0.6 + np.arange(count), atol=1e-2)


def test_sleep_may_be_switched_off() -> None:
    world = World(stack(3), options=Options(sleep=False))
    world.step(120)
    assert not world.asleep.any()
    assert world.diagnostics().awake[0] == 3
    world.options = Options()
    world.step(60)
    assert world.asleep[0, 1:].all()


def test_sleeping_state_is_restored_bit_for_bit() -> None:
    world = sleeping()
    saved = world.save()

    def play(target: World) -> bytes:
        target.step(10)
        target.apply_force("box_3", force=(30, 0))
        target.step(40)
        return everything(target)

    expected = play(world)
    again = World(tower())
    again.restore(saved)
    assert again.asleep[0, BOXES].all()
    assert play(again) == expected
    world.restore(saved)
    assert play(world) == expected


def test_a_woken_stack_that_was_only_touched_stays() -> None:
    world = sleeping()
    before = world.position.copy()
    for _ in range(20):
        world.apply_force("box_1", force=(0.0, 0.001))
        world.step(60)
    np.testing.assert_allclose(world.position, before, atol=2e-4)
    assert world.asleep[0, BOXES].all()


def test_a_body_does_not_sleep_at_its_apex() -> None:
    world = World(tower())
    world.parameters.set("ball", gravity_scale=1.0)
    world.set_velocity("ball", linear=(0, G / 2))
    world.step(60)
    assert world.position[0, 6, 1] == pytest.approx(0.5, abs=1e-9)  # up and down again in a second


def crowd(sleepers: int) -> Scene:
    """A tower on a plate that creeps, and sleepers around it, by index and by place."""
    scene = Scene()
    scene.add_body("floor", kind="static", shapes=[Box(half_extents=(100, 0.5))], position=(0, -0.5))
    for k in range(sleepers // 2):
        scene.add_body(f"left_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(-3 - 2 * (k // 3), 0.5 + k % 3))
    plate = Box(half_extents=(1.2, 0.2))
    scene.add_body("plate", kind="kinematic", shapes=[plate], position=(0, 0.3), linear_velocity=(0.001, 0))
    for k in range(4):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(0.01 * k, 1.0 + k))
    for k in range(sleepers // 2):
        scene.add_body(f"right_{k}", shapes=[Box(half_extents=(0.5, 0.5))], position=(3 + 2 * (k // 3), 0.5 + k % 3))
    return scene


def test_sleepers_change_nothing_for_those_awake() -> None:
    worlds = World(crowd(0)), World(crowd(240))  # few shapes and many: both ways of finding pairs
    moves = []
    for world in worlds:
        names = world.model.body_names
        tower = [names.index(f"box_{k}") for k in range(4)]
        world.step(120)
        assert world.asleep[0].sum() == len(names) - 6
        before = world.contacts().point.copy()
        world.apply_force("box_3", force=(0.5, 0.0))
        world.step(30)
        assert world.diagnostics().awake[0] == 4
        assert len(world.contacts()) == len(before)
        moves.append((world.position[0, tower], world.linear_velocity[0, tower]))
    np.testing.assert_array_equal(moves[0], moves[1])


# ---------------------------------------------------------------- joints


def on_a_pin(dim: int, joint: dict[str, Any], rate: float = 0.0, shapes: bool = False) -> World:
    """A rotor on a pin in the world, without gravity."""
    scene = Scene(dim=dim, gravity=(0.0,) * dim)
    scene.add_body("ground", "static")
    solid: Any = planar.Box(half_extents=(0.2, 0.1)) if dim == 2 else spatial.Box(half_extents=(0.2, 0.1, 0.1))
    body: dict[str, Any] = (
        {"shapes": [solid]} if shapes else {"mass": 2.0, "inertia": 0.3 if dim == 2 else (0.1, 0.2, 0.3)}
    )
    spin: Any = rate if dim == 2 else (0.0, 0.0, rate)
    scene.add_body("rotor", angular_velocity=spin, **body)
    pin: Any = planar.Revolute("ground", "rotor", **joint)
    if dim == 3:
        pin = spatial.Hinge("ground", "rotor", axis=(0, 0, 1), **joint)
    scene.add_joint("pin", pin)
    return World(scene)


@pytest.mark.parametrize("articulated", [True, False], ids=["joint coordinates", "rows"])
@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_a_rotor_without_shapes_spins_on(dim: int, articulated: bool) -> None:
    """Its size, which its speed is judged by, is its radius of gyration."""
    world = on_a_pin(dim, {}, rate=20.0)
    world.options = Options(articulated=articulated)
    world.step(300)
    assert not world.asleep[0, 1]
    assert world.joint_rate("pin")[0] == pytest.approx(20.0, rel=1e-9)


@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_a_body_without_shapes_comes_to_rest_where_its_spring_does(dim: int) -> None:
    world = on_a_pin(dim, {"stiffness": 0.3, "damping": 0.3, "rest": 0.5})
    world.step(60 * 30)
    assert world.asleep[0, 1]
    assert world.joint_coordinate("pin")[0] == pytest.approx(0.5, abs=0.02)


@pytest.mark.parametrize("shapes", [True, False], ids=["box", "no shapes"])
@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_a_slow_motor_turns_on(dim: int, shapes: bool) -> None:
    world = on_a_pin(dim, {"motor_speed": 0.002, "motor_effort": 100.0}, shapes=shapes)
    world.step(600)
    assert world.joint_coordinate("pin")[0] == pytest.approx(0.02, rel=1e-3)
    world.set_motor("pin", speed=0.0)
    world.step(120)
    assert world.asleep[0, 1]
    world.set_motor("pin", speed=0.001)
    world.step(600)
    assert world.joint_coordinate("pin")[0] == pytest.approx(0.03, rel=1e-3)
