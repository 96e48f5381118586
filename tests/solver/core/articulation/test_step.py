"""Steps in joint coordinates: motion against Runge-Kutta steps, momentum, contacts, limits, motors, springs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Capsule, Circle, Distance, HalfPlane, Prismatic, Revolute
from tests.solver.bits import everything
from tests.solver.core.articulation.opened import articulated

Array = np.ndarray[Any, Any]
G = 9.81


def rods(count: int = 2, degrees: float = 90.0, flipped: bool = False, free: bool = False, **joint: Any) -> Scene:
    """Uniform rods of 1 m and 1 kg in a straight line, at rest, on a hook at the origin or free."""
    scene = Scene(gravity=(0.0, 0.0) if free else (0.0, -G))
    scene.add_body("hook", "static")
    turn = np.radians(degrees)
    along = np.array([np.sin(turn), -np.cos(turn)])
    for k in range(count):
        rod = Capsule(half_length=0.5, radius=0.05, mask=0)
        at = (k + 0.5) * along
        scene.add_body(f"rod_{k}", shapes=[rod], position=at, angle=turn - np.pi / 2, mass=1.0, inertia=1.0 / 12.0)
        if k > 0 or not free:
            pair = ("hook" if k == 0 else f"rod_{k - 1}", f"rod_{k}")
            swap = flipped and k % 2 == 1
            scene.add_joint(f"joint_{k}", Revolute(*(pair[::-1] if swap else pair), anchor=k * along, **joint))
    return scene


def runge_kutta(angles: Array, seconds: float, steps: int) -> Array:
    """Where the end of two uniform rods is that start at rest at these angles from the vertical."""

    def rate(y: Array) -> Array:
        (a, b), (u, w) = y[:2], y[2:]
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[4.0 / 3.0, 0.5 * c], [0.5 * c, 1.0 / 3.0]])
        force = [-0.5 * w * w * s - 1.5 * G * np.sin(a), 0.5 * u * u * s - 0.5 * G * np.sin(b)]
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    y = np.concatenate([angles, [0.0, 0.0]])
    h = seconds / steps
    for _ in range(steps):
        k = rate(y)
        m = rate(y + 0.5 * h * k)
        n = rate(y + 0.5 * h * m)
        y = y + h / 6.0 * (k + 2.0 * m + 2.0 * n + rate(y + h * n))
    return np.array([np.sin(y[0]) + np.sin(y[1]), -np.cos(y[0]) - np.cos(y[1])])


def tip(world: World, rod: int) -> Array:
    angle = world.angle[0, rod]
    return np.asarray(world.position[0, rod] + 0.5 * np.array([np.cos(angle), np.sin(angle)]))


@pytest.mark.parametrize("flipped", [False, True])
def test_a_double_pendulum_converges_with_fourth_order(flipped: bool) -> None:
    exact = runge_kutta(np.full(2, np.pi / 2), 1.5, 20_000)
    errors = []
    for rate in (60, 120, 240):
        world = articulated(rods(flipped=flipped), timestep=1.0 / rate, substeps=1, sleep=False)
        world.step(rate * 3 // 2)
        errors.append(np.linalg.norm(tip(world, 2) - exact))
        diagnostics = world.diagnostics()
        assert diagnostics.rows[0] == 0
        assert diagnostics.joint_error[0] < 1e-14
    assert errors[-1] < 1e-6
    assert_allclose(np.divide(errors[:-1], errors[1:]), 16.0, rtol=0.3)


def test_a_free_chain_keeps_its_momentum_and_energy() -> None:
    drifts = []
    for rate in (120, 240):
        world = articulated(rods(5, free=True), timestep=1.0 / rate, substeps=1, sleep=False)
        speed = before = 0.0
        for k, spin in enumerate((1.0, -2.0, 3.0, 0.5, -1.0)):
            speed += 0.5 * (before + spin)
            before = spin
            world.set_velocity(f"rod_{k}", linear=(0.2, speed), angular=spin)
        start = world.diagnostics()
        world.step(2 * rate)
        end = world.diagnostics()
        assert end.rows[0] == 0
        momentum = np.append(end.momentum - start.momentum, end.angular_momentum - start.angular_momentum)
        drifts.append([abs(momentum).max(), abs(end.energy - start.energy)[0]])
    print(drifts)
    assert_allclose(drifts[1], 0.0, atol=1e-3)


def test_reactions_carry_what_hangs_below() -> None:
    world = articulated(rods(4, degrees=0.0, flipped=True), sleep=False)
    world.step(60)
    for k in range(4):
        sign = -1.0 if k % 2 else 1.0
        assert_allclose(world.joint_reaction(f"joint_{k}")[0], [0.0, sign * (4 - k) * G, 0.0], atol=1e-9)


def on_ground(**joint: Any) -> Scene:
    """A trunk with two arms, half a metre above the ground, and a loose ball."""
    scene = Scene()
    scene.add_body("ground", "static", shapes=[HalfPlane(friction=0.6)])
    scene.add_body("trunk", shapes=[Box(half_extents=(0.3, 0.1), friction=0.6)], position=(0.0, 0.5))
    for side in (-1.0, 1.0):
        arm = Capsule(half_length=0.2, radius=0.06, friction=0.6)
        scene.add_body(f"arm_{side:+.0f}", shapes=[arm], position=(side * 0.55, 0.55), angle=0.3 * side)
        scene.add_joint(f"joint_{side:+.0f}", Revolute("trunk", f"arm_{side:+.0f}", anchor=(side * 0.33, 0.5), **joint))
    scene.add_body("ball", shapes=[Circle(radius=0.1, friction=0.6)], position=(0.05, 0.75))
    return scene


def test_contacts_carry_the_weight_and_the_island_falls_asleep() -> None:
    world = articulated(on_ground(damping=0.02))
    world.step(240)
    contacts = world.contacts()
    weight = world.parameters.mass[0].sum() * G
    force = contacts.force_vector(world.timestep)[contacts.body_a == 0].sum(0)
    assert_allclose(force, [0.0, weight], atol=2e-3 * weight)
    assert world.diagnostics().penetration[0] < 1e-3
    world.step(120)
    assert world.asleep[0, 1:].all()


def test_motion_with_contacts_is_that_of_rows() -> None:
    """Both paths converge to the same motion."""
    ends = []
    for on in (True, False):
        world = World(on_ground(), options=Options(timestep=1e-4, substeps=1, sleep=False, articulated=on))
        world.step(3500)
        ends.append(world.position[0])
    assert_allclose(ends[0], ends[1], atol=5e-4)


def servo(**joint: Any) -> World:
    """A rod of 1 kg on a revolute joint at the origin, level, without gravity."""
    scene = Scene(gravity=(0.0, 0.0))
    scene.add_body("hook", "static")
    for k in range(2):
        rod = Capsule(half_length=0.5, radius=0.05, mask=0)
        scene.add_body(f"rod_{k}", shapes=[rod], position=(0.5, 2.0 * k), mass=1.0, inertia=1.0 / 12.0)
        pair = (f"rod_{k}", "hook") if k else ("hook", f"rod_{k}")
        scene.add_joint(f"joint_{k}", Revolute(*pair, anchor=(0.0, 2.0 * k), **joint))
    return articulated(scene, sleep=False)


def test_a_motor_keeps_its_speed_and_its_bound() -> None:
    world = servo(motor_speed=2.0, motor_effort=0.5)
    world.step(12)  # 0.2 s at 0.5 N m on 1/3 kg m^2
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_rate(joint), 0.3, rtol=1e-9)
    world.step(120)
    for joint, side in (("joint_0", 1.0), ("joint_1", -1.0)):
        assert_allclose(world.joint_rate(joint), 2.0, rtol=1e-9)
        assert_allclose(world.angular_velocity[0, 1 if side > 0 else 2], side * 2.0, rtol=1e-9)


def test_a_limit_holds() -> None:
    world = servo(motor_speed=2.0, motor_effort=0.5, limits=(-1.0, 0.3))
    world.step(120)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_coordinate(joint), 0.3, atol=1e-6)
        assert_allclose(world.joint_rate(joint), 0.0, atol=1e-9)


@pytest.mark.parametrize("flipped", [False, True])
def test_a_limit_holds_where_another_one_pushes_its_joint_to_it(flipped: bool) -> None:
    """Two rods turn as one until the limit of the first stops it, which throws the second against its own.

    Without the first limit the second joint would not move, so that only the solution shows that it needs a row.
    """
    scene = rods(1, 0.0, limits=(-0.1, 0.05))
    rod = Capsule(half_length=0.5, radius=0.05, mask=0)
    scene.add_body("rod_1", shapes=[rod], position=(0.0, -1.5), angle=-np.pi / 2, mass=1.0, inertia=1.0 / 12.0)
    pair, limits = (("rod_1", "rod_0"), (-0.05, 0.1)) if flipped else (("rod_0", "rod_1"), (-0.1, 0.05))
    scene.add_joint("joint_1", Revolute(*pair, anchor=(0.0, -1.0), limits=limits))
    world = articulated(scene, timestep=1.0 / 120, sleep=False)
    world.set_joint("joint_0", rate=10.0)  # 0.083 rad in a step
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_coordinate(joint), 0.0, atol=1e-12)
    world.step()
    for joint in ("joint_0", "joint_1"):
        assert_allclose(abs(world.joint_coordinate(joint)), 0.05, atol=1e-5)


@pytest.mark.parametrize("effort", [np.inf, 100.0])
def test_a_spring_oscillates_at_its_frequency(effort: float) -> None:
    """1/3 kg m^2 on 3 N m/rad: 3 rad/s."""
    world = servo(stiffness=3.0, rest=0.1, spring_effort=effort)
    seconds = 2.0
    world.step(120)
    for joint in ("joint_0", "joint_1"):
        assert_allclose(world.joint_coordinate(joint), 0.1 - 0.1 * np.cos(3.0 * seconds), atol=2e-4)


def test_a_slide_falls_along_its_axis() -> None:
    scene = Scene(gravity=(0.0, -G))
    scene.add_body("rail", "static")
    turn = np.radians(30.0)
    axis = (np.cos(turn), -np.sin(turn))
    for k in range(2):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.1, 0.1), mask=0)], position=(0.0, 2.0 * k))
        pair = ("rail", f"box_{k}") if k else (f"box_{k}", "rail")
        scene.add_joint(f"slide_{k}", Prismatic(*pair, axis=axis))
    world = articulated(scene, sleep=False)
    world.step(60)
    for k, sign in ((0, -1.0), (1, 1.0)):
        assert_allclose(world.joint_coordinate(f"slide_{k}"), sign * 0.25 * G, rtol=1e-9)
        assert_allclose(world.position[0, 1 + k] - [0.0, 2.0 * k], 0.25 * G * np.array(axis), rtol=1e-9)


def test_worlds_and_threads_do_not_matter() -> None:
    one = [articulated(on_ground()) for _ in range(3)]
    batch = World(on_ground(), 3, 2, options=Options(articulated=True))
    for w, world in enumerate(one):
        for target in (world, batch):
            target.parameters.set("trunk", mass=1.0 + w, worlds=None if target is world else w)
    for world in [*one, batch]:
        world.step(60)
    for w, world in enumerate(one):
        assert_array_equal(batch.state.bodies[w], world.state.bodies[0])


def test_a_snapshot_continues_bit_for_bit() -> None:
    world = articulated(on_ground())
    world.step(20)
    saved = world.save()
    world.step(20)
    again = articulated(on_ground())
    again.restore(saved)
    again.step(20)
    assert everything(again) == everything(world)


def test_what_is_not_covered_takes_the_rows_of_its_joints() -> None:
    """Rods without joints in trees give the same bits with and without the option."""

    def chain_of_rods() -> Scene:
        scene = Scene(gravity=(0.0, -G))
        for k in range(4):
            kind = "dynamic" if k else "static"
            scene.add_body(f"bead_{k}", kind, shapes=[Circle(radius=0.1, mask=0)], position=(0.5 * k, 0.0))
            if k:
                scene.add_joint(f"rod_{k}", Distance(f"bead_{k - 1}", f"bead_{k}"))
        return scene

    for scene in (chain_of_rods,):
        worlds = [World(scene(), options=Options(articulated=on)) for on in (False, True)]
        for world in worlds:
            world.step(30)
        assert everything(worlds[0]) == everything(worlds[1])


def test_a_joint_that_is_switched_off_lets_go() -> None:
    world = articulated(rods(2, degrees=0.0), sleep=False)
    world.step(10)
    world.parameters.set("joint_1", enabled=False)
    before = world.position[0, 2, 1]
    world.step(60)
    assert_allclose(world.position[0, 2, 1] - before, -0.5 * G, rtol=1e-6)
    assert_allclose(world.joint_reaction("joint_0")[0, 1], G, rtol=1e-6)


def test_anchors_that_are_apart_are_brought_together_first() -> None:
    world = articulated(rods(2, degrees=0.0), sleep=False)
    world.set_pose("rod_1", position=(0.3, -1.5))
    world.step(120)
    diagnostics = world.diagnostics()
    assert diagnostics.joint_error[0] < 1e-12
    assert diagnostics.rows[0] == 0
