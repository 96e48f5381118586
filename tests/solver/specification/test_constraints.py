"""User constraints whose directions rotate with a body, or that an update function sets before each step."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.planar import Box, Circle, Revolute
from tests.solver.bits import everything

G = 9.81
INF = math.inf
AWAKE = Options(sleep=False)
Update = Callable[[World], Mapping[str, Any]]


def ball(gravity: float = 0.0, options: Options = AWAKE, worlds: int = 1, linked: bool = False, **rule: Any) -> World:
    """One ball of 1 kg under a rule; ``linked``: it drags a trailer on a hinge, so the joints have a factor."""
    scene = Scene(gravity=(0, -gravity))
    scene.add_body("ball", shapes=[Circle(radius=0.2)], mass=1.0)
    if linked:
        scene.add_body("trailer", shapes=[Circle(radius=0.2)], mass=1.0, position=(-1, 0))
        scene.add_joint("hitch", Revolute("ball", "trailer"))
    scene.add_constraint("rule", ["ball"], **rule)
    return World(scene, worlds, options=options)


# ---------------------------------------------------------------- frame


def skate(options: Options, spin: float) -> World:
    """A blade that does not slip sideways and turns at a steady rate: it runs a circle at its speed."""
    scene = Scene(gravity=(0, 0))
    scene.add_body(
        "blade", shapes=[Box(half_extents=(0.5, 0.1))], mass=1, angle=0.4, angular_velocity=spin,
        linear_velocity=(math.cos(0.4), math.sin(0.4)),
    )  # fmt: skip
    scene.add_constraint("edge", ["blade"], [0, 1, 0], frame="body")
    return World(scene, options=options)


@pytest.mark.parametrize("spin", [1.0, -4.0])
def test_skate_runs_a_circle(spin: float) -> None:
    errors = []
    for substeps in (2, 4):
        world = skate(Options(substeps=substeps, sleep=False), spin)
        worst = 0.0
        for k in range(1, 121):
            world.step()
            a = 0.4 + spin * k / 60.0
            exact = np.array((math.sin(a) - math.sin(0.4), math.cos(0.4) - math.cos(a))) / spin
            worst = max(worst, abs(world.position[0, 0] - exact).max())
            assert np.hypot(*world.linear_velocity[0, 0]) == pytest.approx(1, rel=1e-4 * spin**2)
        errors.append(worst)
    assert errors[0] < 1e-3 * abs(spin)
    assert errors[1] < errors[0] / 3.0


def test_directions_turn_with_the_first_body() -> None:
    # a guide along the x-axis of "a", which is turned by 0.7 rad: "b" is free to move along it only
    scene = Scene(gravity=(0, 0))
    scene.add_body("a", "kinematic", [Box(half_extents=(0.2, 0.2))], angle=0.7)
    scene.add_body("b", shapes=[Circle(radius=0.1)], mass=1, position=(3, 0), linear_velocity=(1, 0))
    scene.add_constraint("guide", ["a", "b"], [0, 1, 0, 0, -1, 0], frame="body")
    world = World(scene, options=AWAKE)
    world.step(30)
    along = np.array((math.cos(0.7), math.sin(0.7)))
    np.testing.assert_allclose(world.linear_velocity[0, 1], along[0] * along, rtol=1e-6)


def test_frame_is_checked() -> None:
    with pytest.raises(ValueError, match="constraint 'rule': frame 'ball' is unknown; known are world, body"):
        ball(jacobian=[1, 0, 0], frame="ball")


# ---------------------------------------------------------------- limits of speed, clutches, locks


@pytest.mark.parametrize("linked", [False, True], ids=["alone", "among joints"])
def test_lock(linked: bool) -> None:
    world = ball(G, linked=linked, jacobian=[[0, 1, 0], [0, 0, 1]])
    world.set_velocity("ball", linear=(1, 0))
    world.step(60)
    assert world.position[0, 0, 1] == pytest.approx(0, abs=1e-6)
    assert world.angle[0, 0] == pytest.approx(0, abs=1e-6)
    assert world.position[0, 0, 0] > 0.3


@pytest.mark.parametrize("linked", [False, True], ids=["alone", "among joints"])
def test_driven_lock_moves_at_its_speed(linked: bool) -> None:
    world = ball(linked=linked, jacobian=[1, 0, 0], bias=-2.0)
    world.step(60)
    assert world.linear_velocity[0, 0, 0] == pytest.approx(2, rel=1e-9)
    assert world.position[0, 0, 0] == pytest.approx(2, abs=0.04)


@pytest.mark.parametrize("linked", [False, True], ids=["alone", "among joints"])
def test_relative_speed_limit(linked: bool) -> None:
    # |v| <= 3 along x on each side, as two rows; 6 m/s^2 reach it after half a second
    world = ball(linked=linked, jacobian=[[1, 0, 0], [-1, 0, 0]], bias=[-3.0, -3.0], upper=0.0)
    mass = world.parameters.mass[0].sum()
    for sign in (1.0, -1.0):
        for _ in range(90):
            world.apply_force("ball", force=(6.0 * sign * mass, 0))
            world.step()
            assert abs(world.linear_velocity[0, 0, 0]) < 3.0 + 1e-6
        assert world.linear_velocity[0, 0, 0] == pytest.approx(3.0 * sign, rel=1e-6)


def test_one_way_clutch() -> None:
    # a drives b forwards, b overruns when a slows down
    scene = Scene(gravity=(0, 0))
    scene.add_body("base", "static")
    for name, x in (("a", 0.0), ("b", 2.0)):
        scene.add_body(name, shapes=[Circle(radius=0.3)], position=(x, 0), inertia=0.5)
        scene.add_joint(f"axle_{name}", Revolute("base", name, motor_effort=3.0 if name == "a" else 0.0))
    scene.add_constraint("clutch", ["a", "b"], [0, 0, -1, 0, 0, 1], lower=0.0)
    world = World(scene, options=AWAKE)
    world.set_motor("axle_a", speed=12.0)
    for k in range(1, 181):
        world.step()
        np.testing.assert_allclose(world.angular_velocity[0, 1:], 3.0 * k / 60.0, rtol=1e-4)  # 3 N m on both
    world.set_motor("axle_a", speed=-5.0)
    world.step(120)
    np.testing.assert_allclose(world.angular_velocity[0, 1:], (9.0 - 12.0, 9.0), rtol=1e-4)


# ---------------------------------------------------------------- update

A, B = 2.0, 1.0


def elliptic_wire(world: World) -> dict[str, Any]:
    """Rows of x^2/A^2 + y^2/B^2 = 1: its direction half a step ahead and what it turns by to the end."""
    x, v, dt = world.center_of_mass[:, 0], world.linear_velocity[:, 0], world.timestep
    curvature = np.array((2.0 / A**2, 2.0 / B**2))
    gradient, ahead = curvature * x, curvature * (x + 0.5 * dt * v)
    size = np.hypot(*ahead.T)
    return {
        "jacobian": np.column_stack([ahead / size[:, None], np.zeros(len(x))])[:, None],
        "bias": 0.5 * dt * (curvature * v**2).sum(1, keepdims=True) / size[:, None],
        "error": off_the_wire(x, gradient)[:, None],
    }


def off_the_wire(x: Any, gradient: Any) -> Any:
    """m, signed distance from the ellipse, to first order."""
    return ((x[:, 0] / A) ** 2 + (x[:, 1] / B) ** 2 - 1.0) / np.hypot(*gradient.T)


def test_bead_keeps_to_an_elliptic_wire_and_its_energy() -> None:
    scene = Scene()
    starts = (-0.3, 0.8, 2.5)
    scene.add_body("bead", shapes=[Circle(radius=0.05)], mass=1.0)
    scene.add_constraint("wire", ["bead"], [1, 0, 0], update=elliptic_wire)
    world = World(scene, 3, options=Options(timestep=1.0 / 240.0, substeps=1, sleep=False))
    world.set_pose("bead", position=[(A * math.cos(s), B * math.sin(s)) for s in starts])
    start = world.diagnostics().energy
    reached = np.full(3, -INF)
    for _ in range(720):
        world.step()
        x = world.center_of_mass[:, 0]
        assert abs(off_the_wire(x, x * (2.0 / A**2, 2.0 / B**2))).max() < 1e-4
        np.testing.assert_allclose(world.diagnostics().energy, start, atol=1e-3 * G)
        reached = np.maximum(reached, abs(world.linear_velocity[:, 0]).max(1))
    np.testing.assert_array_less(0.5, reached)  # they do slide


def test_rows_of_each_world() -> None:
    # a lift whose speed is its world's number
    world = ball(G, worlds=3, jacobian=[0, 1, 0], update=lambda world: {"bias": -np.arange(3.0)[:, None]})
    world.step(60)
    np.testing.assert_allclose(world.linear_velocity[:, 0, 1], (0, 1, 2), rtol=1e-12, atol=1e-12)


def test_update_is_called_before_each_step_with_the_world() -> None:
    seen = []

    def update(world: World) -> dict[str, Any]:
        seen.append((world, int(world.state.worlds["step"][0])))
        return {}

    world = ball(jacobian=[0, 1, 0], update=update)
    world.step(3)
    world.step()
    assert [step for _, step in seen] == [0, 1, 2, 3]
    assert all(given is world for given, _ in seen)


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        (None, "must return a mapping of names to values, got NoneType"),
        ([1, 2], "must return a mapping of names to values, got list"),
        ({"force": 1.0}, "name 'force' is unknown; known are jacobian, error, lower, upper, bias, softness"),
        ({"jacobian": [1, 0]}, r"jacobian must fit the shape \(2, 1, 3\), got an array of shape \(2,\)"),
        ({"jacobian": [1, 0, np.nan]}, "jacobian must be finite"),
        ({"bias": "fast"}, "bias must be numbers, got 'fast'"),
        ({"error": np.zeros((3, 1))}, r"error must fit the shape \(2, 1\)"),
        ({"softness": -1.0}, "softness must not be negative"),
        ({"lower": 1.0, "upper": 0.0}, "lower must not be above upper"),
        ({"lower": INF}, "lower must be below infinity"),
        ({"upper": np.nan}, "upper must not be NaN"),
    ],
)
def test_bad_updates_are_refused_before_anything_changes(returned: Any, message: str) -> None:
    scene = Scene()
    scene.add_body("ball", shapes=[Circle(radius=0.2)])
    scene.add_constraint("good", ["ball"], [1, 0, 0], update=lambda world: {"bias": 3.0})
    scene.add_constraint("bad", ["ball"], [0, 1, 0], update=lambda world: returned)
    world = World(scene, 2)
    before = everything(world)
    with pytest.raises(ValueError, match=f"^update of constraint 'bad'.*{message}") as caught:
        world.step()
    assert "\n" not in str(caught.value)
    assert everything(world) == before


def test_update_that_raises_changes_nothing() -> None:
    def update(world: World) -> dict[str, Any]:
        raise RuntimeError("no signal")

    world = ball(jacobian=[0, 1, 0], update=update)
    before = everything(world)
    with pytest.raises(RuntimeError, match="no signal"):
        world.step()
    assert everything(world) == before
    with pytest.raises(ValueError, match="constraint 'rule': update must be a function of the world, got 3"):
        ball(jacobian=[0, 1, 0], update=3)


def test_snapshots_hold_the_rows() -> None:
    def update(world: World) -> dict[str, Any]:
        return {"bias": -np.sin(world.time)[:, None] - 0.1 * world.position[:, 0, :1]}

    world = ball(G, worlds=2, jacobian=[1, 0, 0], update=update)
    world.set_velocity("ball", linear=[(0, 1), (0, 2)])
    world.step(30)
    saved = world.save()
    world.step(30)
    after = everything(world)
    world.restore(saved)
    world.step(30)
    assert everything(world) == after
    world.reset()
    np.testing.assert_array_equal(world.parameters.rows["bias"], 0.0)
    assert everything(world) == everything(ball(G, worlds=2, jacobian=[1, 0, 0], update=update))


def test_bodies_of_rows_that_update_do_not_sleep() -> None:
    speed = [0.0]
    world = ball(G, options=Options(), jacobian=[[1, 0, 0], [0, 1, 0]], update=lambda world: {"bias": [-speed[0], 0.0]})
    world.step(120)
    speed[0] = 1.0
    world.step(60)
    assert world.position[0, 0, 0] == pytest.approx(1, abs=0.02)


@pytest.mark.parametrize("side", ["lower", "upper"])
def test_one_sided_rows_take_back_their_error(side: str) -> None:
    # a floor at y = 0, written as v_y >= 0 or as -v_y <= 0; the ball starts 0.1 m below it
    sign = 1.0 if side == "lower" else -1.0

    def update(world: World) -> dict[str, Any]:
        y = world.position[:, 0, 1]
        ahead = np.maximum(y, 0.0) / world.timestep * world.options.substeps  # it may come so far in a substep
        return {"bias": sign * ahead[:, None], "error": sign * y[:, None]}

    bound: dict[str, Any] = {side: 0.0}
    world = ball(G, jacobian=[0, sign, 0], update=update, **bound)
    world.set_pose("ball", position=(0, -0.1))
    world.step(60)
    assert world.position[0, 0, 1] == pytest.approx(0, abs=1e-3)
    world.set_velocity("ball", linear=(0, 2))
    world.step(6)
    assert world.position[0, 0, 1] > 0.1  # it does not hold on
    world.step(60)
    assert world.position[0, 0, 1] == pytest.approx(0, abs=1e-3)
    reaction = world.joint_reaction(Handle("joint", "rule", 0))[0]
    np.testing.assert_allclose(reaction, (0, G, 0), rtol=1e-6, atol=1e-9)
