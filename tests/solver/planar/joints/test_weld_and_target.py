"""Welds, targets and user constraints against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.planar import Box, Circle, HalfPlane, Target, Weld

G = 9.81
AWAKE = Options(sleep=False)
INF = math.inf


def joint(world: World, name: str) -> Handle:
    return Handle("joint", name, world.model.joint_names.index(name))


def force(world: World, name: str) -> Any:
    """Mean force and torque of a joint's rows over the last step, of the first world."""
    index = world.model.joint_names.index(name)
    return world.state.joints["total_impulse"][0, index, :3] / world.timestep


# ---------------------------------------------------------------- weld


def beam(count: int = 5) -> Scene:
    """``count`` bars of 1 x 0.2 m, 0.2 kg each, welded to a wall in a row, and a hammer above the end."""
    scene = Scene()
    scene.add_body("wall", kind="static", shapes=[Box(half_extents=(0.5, 0.5))])
    before = "wall"
    for k in range(count):
        bar = Box(half_extents=(0.5, 0.1))
        scene.add_body(f"bar_{k}", shapes=[bar], position=(1.0 + k, 0))
        scene.add_joint(f"weld_{k}", Weld(before, f"bar_{k}", anchor=(0.5 + k, 0)))
        before = f"bar_{k}"
    scene.add_body("hammer", shapes=[Circle(radius=0.1)], position=(count - 0.2, 1.0), enabled=False)
    return scene


def test_beam_holds_and_its_reactions_are_static() -> None:
    world = World(beam(), options=AWAKE)
    world.step(60)
    assert world.diagnostics().joint_error[0] < 1e-5
    np.testing.assert_allclose(world.position[0, 1:6, 1], 0, atol=1e-3)
    for k in range(5):
        # weld k holds 5 - k bars of weight w, the middle of which is (5 - k) / 2 to the right of it
        hangs, w = 5 - k, 0.2 * G
        np.testing.assert_allclose(force(world, f"weld_{k}"), (0, hangs * w, hangs**2 / 2 * w), rtol=2e-3, atol=1e-3)


def test_beam_holds_a_hit() -> None:
    world = World(beam(), options=AWAKE)
    world.parameters.set("hammer", enabled=True)
    world.set_velocity("hammer", linear=(0, -10))
    worst = 0.0
    hit = False
    for _ in range(120):
        world.step()
        hit = hit or len(world.contacts()) > 0
        worst = max(worst, world.diagnostics().joint_error[0])
    assert hit
    assert worst < 1e-3  # of a bar's length, 1 m
    np.testing.assert_allclose(world.angle[0, 1:6], 0, atol=2e-3)


def two_welded(spin: float, velocity: tuple[float, float]) -> World:
    """Two turned bodies, one off-centre, a with the given motion, b at rest."""
    scene = Scene(gravity=(0, 0))
    bar = Box(half_extents=(0.5, 0.2))
    scene.add_body("a", shapes=[bar], angle=2.0, linear_velocity=velocity, angular_velocity=spin)
    off = Box(half_extents=(0.5, 0.2), position=(0.4, 0.1), angle=1.0, density=4.0)
    scene.add_body("b", shapes=[off], position=(1, 0), angle=-2.5)
    scene.add_joint("weld", Weld("a", "b"))
    return World(scene, options=AWAKE)


def angular_momentum(world: World) -> float:
    p, x, v = world.parameters, world.center_of_mass[0], world.linear_velocity[0]
    orbit = p.mass[0] * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0])
    return float((orbit + p.inertia[0] * world.angular_velocity[0]).sum())


def test_weld_keeps_the_initial_angle() -> None:
    world = two_welded(0.0, (0, 0))
    # as one rigid body: turns about its centre of mass at 3 rad/s
    mass, x = world.parameters.mass[0], world.center_of_mass[0]
    arms = x - mass @ x / mass.sum()
    for b in (0, 1):
        world.set_velocity(b, linear=3.0 * np.array([-arms[b, 1], arms[b, 0]]), angular=3.0)
    spin = angular_momentum(world)
    for _ in range(120):
        world.step()
        assert world.diagnostics().joint_error[0] < 5e-3  # (3 h)^2 r a substep opens it, a fifth is corrected
        assert world.angle[0, 1] - world.angle[0, 0] == pytest.approx(-4.5, abs=1e-3)
    np.testing.assert_allclose(world.diagnostics().momentum, 0, atol=1e-12)
    # the velocity follows the turning weld a substep late: cos(3 h) of it is left each time
    assert angular_momentum(world) == pytest.approx(spin, rel=0.01)


def test_weld_of_bodies_that_part() -> None:
    # a plastic hit: the momentum is shared at once, a gap heals
    world = two_welded(3.0, (1, 2))
    momentum, spin = world.diagnostics().momentum.copy(), angular_momentum(world)
    world.step()
    assert world.diagnostics().joint_error[0] < 1e-3
    world.step(59)
    assert world.diagnostics().joint_error[0] < 1e-3
    assert world.angle[0, 1] - world.angle[0, 0] == pytest.approx(-4.5, abs=1e-4)
    np.testing.assert_allclose(world.diagnostics().momentum, momentum, rtol=1e-12)
    assert angular_momentum(world) == pytest.approx(spin, rel=0.02)


def spring_travel(frequency: float, ratio: float, substeps: int = 2) -> tuple[Any, Any]:
    """(t, x) of a mass welded softly to a wall, pushed off at 1 m/s; 5 s."""
    scene = Scene(gravity=(0, 0))
    scene.add_body("wall", kind="static")
    scene.add_body("mass", shapes=[Circle(radius=0.5)], position=(1, 0), linear_velocity=(1, 0))
    scene.add_joint("spring", Weld("wall", "mass", frequency=frequency, damping_ratio=ratio))
    world = World(scene, options=Options(sleep=False, substeps=substeps))
    x = []
    for _ in range(300):
        world.step()
        x.append(world.position[0, 1, 0] - 1.0)
    return np.arange(1, 301) * world.timestep, np.array(x)


@pytest.mark.parametrize(("frequency", "ratio"), [(1.0, 0.0), (1.0, 0.1), (2.0, 0.0), (2.0, 0.2), (4.0, 0.1)])
def test_soft_weld_swings_as_a_damped_oscillator(frequency: float, ratio: float) -> None:
    t, x = spring_travel(frequency, ratio)
    up = np.flatnonzero((x[:-1] <= 0.0) & (x[1:] > 0.0))
    crossings = t[up] - x[up] / (x[up + 1] - x[up]) * (t[1] - t[0])
    period = 1.0 / (frequency * math.sqrt(1.0 - ratio**2))
    assert np.diff(crossings)[:3].mean() == pytest.approx(period, rel=0.04)
    omega = 2.0 * math.pi * frequency
    damped = omega * math.sqrt(1.0 - ratio**2)
    exact = np.exp(-ratio * omega * t) * np.sin(damped * t) / damped
    first = t < period
    assert x[first].max() == pytest.approx(exact[first].max(), rel=0.05)
    assert abs(x[-60:]).max() < abs(exact[-60:]).max() + 0.05 * exact.max()  # it never swings up


def test_soft_weld_converges_to_the_closed_form() -> None:
    omega, ratio = 4.0 * math.pi, 0.2
    damped = omega * math.sqrt(1.0 - ratio**2)
    errors = []
    for substeps in (2, 8, 32):
        t, x = spring_travel(2.0, ratio, substeps)
        exact = np.exp(-ratio * omega * t) * np.sin(damped * t) / damped
        errors.append(abs(x - exact).max() / exact.max())
    assert errors[0] < 0.1
    assert errors[1] < 0.3 * errors[0]
    assert errors[2] < 0.3 * errors[1]


def test_soft_weld_sags_by_its_weight() -> None:
    scene = Scene()
    scene.add_body("ceiling", kind="static")
    scene.add_body("mass", shapes=[Circle(radius=0.5)], position=(0, -1), mass=7.0)
    scene.add_joint("spring", Weld("ceiling", "mass", anchor=(0, -1), frequency=3.0))
    world = World(scene, options=AWAKE)
    world.step(300)
    assert world.position[0, 1, 1] == pytest.approx(-1 - G / (6 * math.pi) ** 2, rel=1e-6)  # m g / k
    np.testing.assert_allclose(force(world, "spring")[:2], (0, 7 * G), atol=1e-5)


def test_weld_switched_off_and_on() -> None:
    scene = Scene()
    scene.add_body("hook", kind="static", shapes=[Box(half_extents=(0.1, 0.1))], position=(0, 10))
    scene.add_body("load", shapes=[Box(half_extents=(0.2, 0.2))], position=(0, 9))
    scene.add_joint("weld", Weld("hook", "load"))
    world = World(scene, world_count=2)
    world.step(60)
    assert world.asleep[:, 1].all()
    world.parameters.set(joint(world, "weld"), enabled=False, worlds=1)
    world.step(12)
    np.testing.assert_allclose(world.position[0, 1, 1], 9, atol=1e-6)
    assert world.linear_velocity[1, 1, 1] == pytest.approx(-G * 0.2, rel=1e-9)
    assert world.position[1, 1, 1] == pytest.approx(9 - 0.5 * G * 0.04, abs=1e-6)
    np.testing.assert_array_equal(world.diagnostics().rows[1], 0)
    world.parameters.set(joint(world, "weld"), enabled=True)
    world.step(120)
    np.testing.assert_allclose(world.position[1, 1], (0, 9), atol=1e-3)


def carrier() -> World:
    """A load welded to a kinematic arm, and one below it in a row."""
    scene = Scene()
    scene.add_body("arm", kind="kinematic", shapes=[Box(half_extents=(0.1, 0.1))])
    for k in range(2):
        scene.add_body(f"load_{k}", shapes=[Box(half_extents=(0.2, 0.2))], position=(0.4 * (k + 1), 0))
    scene.add_joint("hold", Weld("arm", "load_0"))
    scene.add_joint("next", Weld("load_0", "load_1"))
    return World(scene)


def test_welded_to_a_kinematic_body_that_starts_to_move() -> None:
    world = carrier()
    world.set_velocity("arm", linear=(2.0, 1.0), angular=1.5)
    world.step()
    # at once: the weld does the work that it takes
    expected = np.array([2.0, 1.0]) + 1.5 * np.array([[0, 0.4], [0, 0.8]])
    np.testing.assert_allclose(world.linear_velocity[0, 1:], expected, atol=0.05)
    world.step(59)
    np.testing.assert_allclose(world.angle[0], 1.5, atol=0.02)
    offset = world.position[0, 2] - world.position[0, 0]
    np.testing.assert_allclose(offset, (0.8 * math.cos(1.5), 0.8 * math.sin(1.5)), atol=0.02)
    np.testing.assert_allclose(world.position[0, 0], (2, 1), rtol=1e-12)


def test_a_kinematic_body_wakes_what_is_welded_to_it() -> None:
    world = carrier()
    world.step(60)
    assert world.asleep[0, 1:].all()
    world.set_velocity("arm", linear=(1, 0))
    world.step(60)
    np.testing.assert_allclose(world.position[0, :, 0], (1.0, 1.4, 1.8), atol=1e-3)
    world.set_velocity("arm", linear=(0.001, 0))  # slower than what counts as rest
    world.step(1200)
    np.testing.assert_allclose(world.position[0, :, 0], (1.02, 1.42, 1.82), atol=1e-3)


# ---------------------------------------------------------------- target


def held(gravity: float = 0.0, wall: bool = False, mode: str | None = "velocity", **given: Any) -> World:
    """A box of 2 kg and 3 kg m^2 on a target of 5 Hz with three actuators (none: the goal stays put)."""
    scene = Scene(gravity=(0, -gravity))
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], mass=2.0, inertia=3.0)
    if wall:
        scene.add_body("wall", kind="static", shapes=[Box(half_extents=(0.1, 2.0), friction=0)], position=(1.6, 0))
    scene.add_joint("hand", Target("box", **given))
    for axis in ("x", "y", "angle") if mode else ():
        scene.add_actuator(axis, "hand", axis, mode=mode or "", lower=-50, upper=50)
    return World(scene, options=AWAKE)


def test_target_pulls_to_its_pose() -> None:
    world = held()
    world.set_target("hand", position=(0.3, -0.2), angle=0.8)
    world.step(120)
    np.testing.assert_allclose(world.position[0, 0], (0.3, -0.2), atol=1e-9)
    assert world.angle[0, 0] == pytest.approx(0.8, abs=1e-9)


def test_critically_damped_target_does_not_overshoot() -> None:
    world = held()
    world.set_target("hand", position=(0.3, 0))
    highest = 0.0
    for _ in range(120):
        world.step()
        highest = max(highest, world.position[0, 0, 0])
    assert highest < 0.3 * 1.001


def test_target_sags_by_the_weight() -> None:
    world = held(gravity=G)
    world.step(300)
    assert world.position[0, 0, 1] == pytest.approx(-G / (10 * math.pi) ** 2, rel=1e-6)
    np.testing.assert_allclose(force(world, "hand"), (0, 2 * G, 0), atol=1e-6)


@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_bounds_are_exact_when_far(substeps: int) -> None:
    world = held(mode=None, max_force=10.0, max_torque=6.0)
    world.options = Options(sleep=False, substeps=substeps)
    world.set_target("hand", position=(1000, -1000), angle=500.0)
    for k in range(1, 31):
        world.step()
        np.testing.assert_allclose(force(world, "hand"), (10, -10, 6), rtol=1e-13)
        t = k * world.timestep
        np.testing.assert_allclose(world.linear_velocity[0, 0], (5 * t, -5 * t), rtol=1e-12)
        assert world.angular_velocity[0, 0] == pytest.approx(2 * t, rel=1e-12)
    np.testing.assert_allclose(world.position[0, 0], (2.5 * t**2, -2.5 * t**2), rtol=1e-12)


def test_bounds_are_never_exceeded() -> None:
    world = held(gravity=G, wall=True, max_force=30.0, max_torque=4.0)
    random = np.random.default_rng(1)
    reached = np.zeros(3)
    for _ in range(300):
        if random.random() < 0.1:
            world.control[0] = random.uniform(-40, 40, 3)
        world.step()
        pull = abs(force(world, "hand"))
        assert (pull <= np.array([30, 30, 4]) * (1 + 1e-12)).all()
        reached = np.maximum(reached, pull)
    np.testing.assert_allclose(reached, (30, 30, 4), rtol=1e-12)


def test_a_weak_hand_drops_the_load() -> None:
    world = held(gravity=G, max_force=G)  # half of the weight
    world.step(60)
    assert world.linear_velocity[0, 0, 1] == pytest.approx(-G / 2, rel=1e-2)


def test_target_moves_at_the_commanded_velocity() -> None:
    world = held()
    world.control[0] = (0.5, -1.0, 2.0)
    world.step(120)
    np.testing.assert_allclose(world.linear_velocity[0, 0], (0.5, -1.0), rtol=1e-9)
    assert world.angular_velocity[0, 0] == pytest.approx(2.0, rel=1e-9)
    np.testing.assert_allclose(world.position[0, 0], (1.0, -2.0), rtol=1e-6)  # and keeps up with it
    assert world.angle[0, 0] == pytest.approx(4.0, rel=1e-6)
    world.control[0] = 0.0
    world.step(60)
    np.testing.assert_allclose(world.linear_velocity[0, 0], 0, atol=1e-6)


def test_position_mode() -> None:
    world = held(mode="position")
    world.control[0] = (0.4, -0.3, 1.2)
    world.step(120)
    np.testing.assert_allclose(world.position[0, 0], (0.4, -0.3), atol=1e-9)
    assert world.angle[0, 0] == pytest.approx(1.2, abs=1e-9)
    world.control[0] = (99.0, 0, 0)  # clipped to 50
    world.step(300)
    np.testing.assert_allclose(world.position[0, 0], (50, 0), atol=1e-6)


def test_nothing_winds_up_at_a_wall() -> None:
    # the target waits where its spring is at the bound, F / (m omega^2) beyond the body, and a step's way
    world = held(wall=True, max_force=50.0)
    reach = 50.0 / (2.0 * (10 * math.pi) ** 2) + 1.0 / 60.0
    world.control[0, 0] = 1.0
    world.step(300)
    assert world.position[0, 0, 0] == pytest.approx(1.0, abs=1e-3)
    assert world.state.joints["target_position"][0, 0, 0] <= 1.0 + 1.01 * reach
    assert force(world, "hand")[0] == pytest.approx(50, rel=1e-6)
    assert world.contacts().impulse[:, 0].sum() / world.timestep == pytest.approx(50, rel=1e-3)
    saved = world.save()
    # the wall goes, the command stops: it moves on by no more than the reach
    world.control[0, 0] = 0.0
    world.parameters.set("wall", enabled=False)
    farthest = 0.0
    for _ in range(60):
        world.step()
        farthest = max(farthest, world.position[0, 0, 0])
    assert farthest < 1.0 + 1.01 * reach
    # the command turns back: it leaves at once, not after 5 s worth of unwinding
    world.restore(saved)
    world.control[0, 0] = -1.0
    world.step(60)
    assert world.position[0, 0, 0] == pytest.approx(0.0, abs=2 * reach)
    assert world.linear_velocity[0, 0, 0] == pytest.approx(-1.0, rel=1e-3)


def test_a_driven_body_never_sleeps() -> None:
    world = held()
    world.options = Options()
    world.step(120)
    world.control[0, 0] = 1.0
    world.step(60)
    assert world.position[0, 0, 0] == pytest.approx(1.0, abs=0.05)
    world.control[0, 0] = 0.001  # slower than what counts as rest
    world.step(120)
    start = world.position[0, 0, 0]
    world.step(600)
    assert world.position[0, 0, 0] - start == pytest.approx(0.01, rel=0.02)


# ---------------------------------------------------------------- constraints of one's own


def pair(*rules: dict[str, Any], gravity: tuple[float, float] = (0, 0), dt: float = 1.0 / 60.0, **kinds: Any) -> World:
    """Two point masses a, b of 1 kg and 1 kg m^2, far apart, and rules on them."""
    scene = Scene(gravity=gravity)
    for k, name in enumerate("ab"):
        scene.add_body(name, mass=1.0, inertia=1.0, position=(10 * k, 0), **kinds.get(name, {}))
    for k, given in enumerate(rules):
        scene.add_constraint(f"rule_{k}", **given)
    exact = Options(timestep=dt, substeps=1, sweeps=200, tolerance=1e-13, sleep=False)
    return World(scene, options=exact)


def test_stack_of_two_solved_by_hand() -> None:
    # v1 >= 0 (on the ground), v2 - v1 >= 0; m = 1, dt = 1, g = 10: impulses 20 and 10
    world = pair(
        {"bodies": ["a"], "jacobian": [0, 1, 0], "lower": 0},
        {"bodies": ["a", "b"], "jacobian": [0, -1, 0, 0, 1, 0], "lower": 0},
        gravity=(0, -10), dt=1.0,
    )  # fmt: skip
    world.step()
    np.testing.assert_allclose(world.state.joints["total_impulse"][0, :, 0], [20, 10], rtol=1e-10)
    np.testing.assert_allclose(world.linear_velocity[0], 0, atol=1e-10)


def test_ball_joint_in_the_plane_solved_by_hand() -> None:
    # r_A = (.5, 0), r_B = (-.5, 0), w_A = 2, C = (0, .1), beta = .2, dt = 1: lambda = (0, -.408)
    rows = [[1, 0, 0, -1, 0, 0], [0, 1, 0.5, 0, -1, 0.5]]
    world = pair({"bodies": ["a", "b"], "jacobian": rows, "bias": [0, 0.2 * 0.1]}, dt=1.0, a={"angular_velocity": 2.0})
    world.step()
    np.testing.assert_allclose(world.state.joints["total_impulse"][0, 0, :2], (0, -0.408), atol=1e-12)
    velocity = world.state.bodies["velocity"][0]
    np.testing.assert_allclose(velocity, [(0, -0.408, 2 - 0.204), (0, 0.408, -0.204)], atol=1e-12)
    assert np.array(rows[1]) @ velocity.ravel() == pytest.approx(-0.02, abs=1e-12)  # C' = -beta C


def test_lock_carries_the_weight() -> None:
    world = pair({"bodies": ["a"], "jacobian": [0, 1, 0]}, gravity=(3, -G))
    world.step(60)
    np.testing.assert_allclose(world.linear_velocity[0], [(3, 0), (3, -G)], atol=1e-10)
    assert force(world, "rule_0")[0] == pytest.approx(G, rel=1e-10)


def test_lock_between_two_shares_the_force() -> None:
    world = pair({"bodies": ["a", "b"], "jacobian": [1, 0, 0, -1, 0, 0]})
    world.apply_force("a", force=(6, 0))
    world.step()
    np.testing.assert_allclose(world.linear_velocity[0, :, 0], 3 * world.timestep, rtol=1e-12)
    assert force(world, "rule_0")[0] == pytest.approx(-3, rel=1e-12)


def test_speed_limit_between_two() -> None:
    # v_b - v_a <= 2: nothing below, the excess shared above
    rule = {"bodies": ["a", "b"], "jacobian": [-1, 0, 0, 1, 0, 0], "bias": -2.0, "upper": 0}
    slow = pair(rule, b={"linear_velocity": (1.5, 0)})
    slow.step(3)
    np.testing.assert_array_equal(slow.linear_velocity[0, :, 0], (0, 1.5))
    fast = pair(rule, b={"linear_velocity": (5, 0)})
    fast.step(3)
    np.testing.assert_allclose(fast.linear_velocity[0, :, 0], (1.5, 3.5), rtol=1e-12)


def test_one_way_clutch() -> None:
    # w_b >= w_a: b may overrun, but is carried along when a is faster
    rule = {"bodies": ["a", "b"], "jacobian": [0, 0, -1, 0, 0, 1], "lower": 0}
    overrun = pair(rule, b={"angular_velocity": 3.0})
    overrun.step(3)
    np.testing.assert_array_equal(overrun.angular_velocity[0], (0, 3))
    carried = pair(rule, a={"angular_velocity": 3.0})
    carried.step(3)
    np.testing.assert_allclose(carried.angular_velocity[0], (1.5, 1.5), rtol=1e-12)


@pytest.mark.parametrize("substeps", [1, 4])
def test_motor_row(substeps: int) -> None:
    # w = 5 with at most 2 N m on 1 kg m^2: 2.5 s at the bound, then none
    world = pair({"bodies": ["a"], "jacobian": [0, 0, 1], "bias": -5.0, "lower": -2, "upper": 2})
    world.options = Options(substeps=substeps, tolerance=1e-13, sleep=False)
    for k in range(1, 150):
        world.step()
        assert force(world, "rule_0")[0] == pytest.approx(2, rel=1e-12)
        assert world.angular_velocity[0, 0] == pytest.approx(2 * k / 60, rel=1e-11)
    world.step(10)
    assert world.angular_velocity[0, 0] == pytest.approx(5, rel=1e-12)
    assert force(world, "rule_0")[0] == pytest.approx(0, abs=1e-9)
    world.parameters.set(joint(world, "rule_0"), bias=0.0, lower=-1.0)  # brakes with 1 N m
    world.step(60)
    assert world.angular_velocity[0, 0] == pytest.approx(4, rel=1e-11)
    world.parameters.set(joint(world, "rule_0"), enabled=False)
    world.step(60)
    assert world.angular_velocity[0, 0] == pytest.approx(4, rel=1e-11)


def test_soft_row() -> None:
    # v + s r = 0 and v = v0 + r / m: v = v0 s m / (1 + s m)
    world = pair({"bodies": ["a"], "jacobian": [1, 0, 0], "softness": 3.0}, a={"linear_velocity": (8, 0)})
    world.step()
    assert world.linear_velocity[0, 0, 0] == pytest.approx(6, rel=1e-12)
    assert world.state.joints["total_impulse"][0, 0, 0] == pytest.approx(-2, rel=1e-12)


def test_redundant_and_dead_rows_are_harmless() -> None:
    lock = {"bodies": ["a"], "jacobian": [[0, 1, 0], [0, 1, 0], [0, 0, 0]]}
    world = pair(lock, lock, gravity=(0, -G))
    world.step(30)
    np.testing.assert_allclose(world.linear_velocity[0, 0], 0, atol=1e-9)
    assert np.isfinite(world.state.joints["impulse"]).all()
    assert world.state.joints["total_impulse"][0, :, :2].sum() == pytest.approx(G / 60, rel=1e-9)


def test_rules_and_contacts_are_solved_together() -> None:
    # a press: a row pushes the box down with 20 N, the ground carries that and the weight
    scene = Scene()
    scene.add_body("ground", kind="static", shapes=[HalfPlane()])
    scene.add_body("box", shapes=[Box(half_extents=(0.5, 0.5))], position=(0, 0.5))
    scene.add_constraint("press", ["box"], [0, 1, 0], lower=-20, upper=0, bias=1.0)
    world = World(scene, options=AWAKE)
    world.step(60)
    assert force(world, "press")[0] == pytest.approx(-20, rel=1e-9)
    assert world.contacts().impulse[:, 0].sum() / world.timestep == pytest.approx(20 + G, rel=1e-4)
    assert world.position[0, 1, 1] == pytest.approx(0.5, abs=1e-3)
