"""Joints in 3D against closed forms: weld, target, distance, ball; contradictions stay calm; reactions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Ball, Box, Capsule, Distance, Sphere, Target, Weld
from tests.solver.joints import make_joint
from tests.solver.spatial.one_kernel import full_world, space

G = 9.81
FINE = Options(timestep=1.0 / 240.0, sleep=False)
TURNS = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0), "all": (0.6, -0.48, 0.64)}


def quaternion(axis: Any, angle: float) -> np.ndarray:
    return np.array((math.cos(0.5 * angle), *(math.sin(0.5 * angle) * np.asarray(axis))))


def hung(kind: str, gravity: float = G, mass: float = 2.0, place: Any = (0, 0, -1), **joint: Any) -> Scene:
    """A body on a joint to the world at the origin."""
    scene = space(gravity)
    scene.add_body("base", "static")
    scene.add_body("it", shapes=[Sphere(radius=0.1)], mass=mass, inertia=(0.3, 0.3, 0.3), position=place)
    scene.add_joint("joint", make_joint(kind, "base", "it", **joint))
    return scene


def damped_oscillation(frequency: float, ratio: float, t: float) -> float:
    """x'' + 2 z w x' + w^2 x = 0 from x = 1 at rest, with z up to 1."""
    omega = 2.0 * math.pi * frequency
    damped = omega * math.sqrt(max(1.0 - ratio**2, 0.0))
    if ratio == 1.0:
        return math.exp(-omega * t) * (1.0 + omega * t)
    return math.exp(-ratio * omega * t) * (math.cos(damped * t) + ratio * omega / damped * math.sin(damped * t))


# ---------------------------------------------------------------- weld


def test_a_welded_pair_turns_as_one_body() -> None:
    """Free in space: both have the same spin, the middle moves straight on, momenta are kept."""
    scene = space()
    for k in range(2):
        scene.add_body(
            f"b{k}", shapes=[Box(half_extents=(0.3, 0.2, 0.1))], position=(1.0 * k, 0, 0),
            linear_velocity=(0, 2.0 * k, 0), angular_velocity=(0, 0, 2.0),
        )  # fmt: skip
    scene.add_joint("weld", Weld("b0", "b1"))
    world = full_world(scene)
    start = world.diagnostics()
    for _ in range(60):
        world.step()
        assert_allclose(world.angular_velocity[0, 0], world.angular_velocity[0, 1], atol=1e-4)
        gap = world.position[0, 1] - world.position[0, 0]
        assert np.hypot.reduce(gap) == pytest.approx(1.0, abs=2e-3)
    assert_allclose(world.position[0, :2].mean(0), (0.5, 1.0, 0), atol=1e-6)
    assert_allclose(world.angular_velocity[0, :2], [(0, 0, 2)] * 2, atol=5e-3)
    assert_allclose(world.orientation[0, 0], quaternion((0, 0, 1), 2.0), atol=5e-3)
    end = world.diagnostics()
    assert_allclose(end.momentum, start.momentum, atol=1e-10)
    assert_allclose(end.angular_momentum, start.angular_momentum, atol=5e-3 * abs(start.angular_momentum).max())


@pytest.mark.parametrize("axis", TURNS)
def test_a_weld_keeps_its_initial_rotation(axis: str) -> None:
    q = quaternion(TURNS[axis], 1.2)
    scene = space(G)
    scene.add_body("base", "static", orientation=quaternion((0, 0, 1), 0.5))
    scene.add_body("arm", shapes=[Box(half_extents=(0.5, 0.1, 0.1))], position=(0.5, 0, 0), orientation=q)
    scene.add_joint("weld", Weld("base", "arm", anchor=(0, 0, 0)))
    world = full_world(scene)
    world.step(60)
    assert_allclose(world.position[0, 1], (0.5, 0, 0), atol=1e-4)
    assert abs(world.orientation[0, 1] @ q) == pytest.approx(1.0, abs=1e-8)
    mass = world.parameters.mass[0, 1]
    # its weight, and that weight's torque about the body's own origin, the anchor is half a metre off
    assert_allclose(world.joint_reaction("weld")[0], (0, 0, mass * G, 0, -0.5 * mass * G, 0), atol=1e-3 * mass * G)


@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0])
@pytest.mark.parametrize("axis", TURNS)
def test_soft_weld_swings_at_its_frequency(axis: str, ratio: float) -> None:
    """Of the place and of the turn, along and about any axis."""
    f = 2.0
    u = np.array(TURNS[axis])
    world = full_world(hung("weld", 0.0, place=(0, 0, 0), frequency=f, damping_ratio=ratio), options=FINE)
    world.set_pose("it", position=0.1 * u, orientation=quaternion(u, 0.2))
    for k in range(1, 241):
        world.step()
        t = k / 240.0
        x = damped_oscillation(f, ratio, t)
        assert_allclose(world.position[0, 1], 0.1 * x * u, atol=2e-3)
        turn = 2.0 * world.orientation[0, 1, 1:] * np.sign(world.orientation[0, 1, 0])
        assert_allclose(turn, 0.2 * x * u, atol=5e-3)


def test_soft_weld_sags_by_its_stiffness() -> None:
    world = full_world(hung("weld", G, mass=2.0, place=(0, 0, 0), stiffness=400.0, damping=60.0))
    world.step(240)
    assert_allclose(world.position[0, 1], (0, 0, -2.0 * G / 400.0), atol=1e-5)
    world.parameters.set("it", mass=4.0)
    world.step(240)
    assert_allclose(world.position[0, 1], (0, 0, -4.0 * G / 400.0), atol=1e-5)


# ---------------------------------------------------------------- target


def targeted(driven: bool = True, **given: Any) -> World:
    scene = space()
    scene.add_body("it", shapes=[Box(half_extents=(0.3, 0.2, 0.1))], mass=2.0)
    scene.add_joint("target", Target("it", **given))
    for axis in ("x", "turn_x", "turn_y", "turn_z") if driven else ():
        scene.add_actuator(axis, "target", axis, "position" if axis == "x" else "velocity")
    return full_world(scene)


@pytest.mark.parametrize("axis", TURNS)
def test_target_drives_to_a_pose(axis: str) -> None:
    world = targeted(frequency=2.0)
    u = np.array(TURNS[axis])
    world.set_target("target", position=(0, 1, 2), orientation=quaternion(u, 2.5))
    world.control[:, 0] = -1.0
    world.step(240)
    assert_allclose(world.position[0, 0], (-1, 1, 2), atol=1e-4)
    assert abs(world.orientation[0, 0] @ quaternion(u, 2.5)) == pytest.approx(1.0, abs=1e-6)
    assert np.abs(world.state.bodies["velocity"][0, 0]).max() < 1e-3


@pytest.mark.parametrize("k", range(3))
def test_actuators_turn_about_the_worlds_axes(k: int) -> None:
    world = targeted(frequency=4.0)
    world.control[:, 1 + k] = 1.5
    world.step(240)
    assert_allclose(world.angular_velocity[0, 0], 1.5 * np.eye(3)[k], atol=1e-3)
    assert abs(world.orientation[0, 0] @ quaternion(np.eye(3)[k], 1.5 * 4.0)) == pytest.approx(1.0, abs=1e-4)


@pytest.mark.parametrize("k", range(3))
def test_targets_force_and_torque_are_bounded(k: int) -> None:
    """Far away it pulls with exactly the bound: v = F t / m, w = T t / I."""
    unit = np.eye(3)[k]
    world = targeted(driven=False, frequency=5.0, max_force=3.0, max_torque=0.02)
    world.set_target("target", position=100.0 * unit, orientation=quaternion(unit, 3.0))
    world.step(30)
    inertia = world.parameters.inertia[0, 0, k]
    assert_allclose(world.linear_velocity[0, 0], 3.0 / 2.0 * 0.5 * unit, atol=1e-9)
    assert_allclose(world.angular_velocity[0, 0], 0.02 / inertia * 0.5 * unit, rtol=1e-6, atol=1e-9)
    assert_allclose(world.joint_reaction("target")[0, :3], 3.0 * unit, atol=1e-9)


# ---------------------------------------------------------------- distance

PLACES = ((0.0, 0.0, -1.0), (0.6, 0.0, -0.8), (0.36, -0.48, -0.8))


@pytest.mark.parametrize("place", PLACES)
def test_rod_keeps_its_length_and_its_energy(place: tuple[float, ...]) -> None:
    world = full_world(hung("distance", place=place))
    world.set_velocity("it", linear=(0.5, 1.0, 0.0))
    x, v = np.array(place), np.array((0.5, 1.0, 0.0))
    world.set_velocity("it", linear=v - (v @ x) * x)
    start = world.diagnostics().energy[0]
    for _ in range(120):
        world.step()
        assert np.hypot.reduce(world.position[0, 1]) == pytest.approx(1.0, abs=1e-3)
        assert world.diagnostics().energy[0] == pytest.approx(start, abs=2e-3 * 2.0 * G)


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5])
def test_conical_pendulum_goes_round(heading: float) -> None:
    """w^2 = g / (L cos a), tension m g / cos a."""
    a = 0.5
    omega = math.sqrt(G / math.cos(a))
    way = np.array((math.cos(heading), math.sin(heading), 0.0))
    across = np.array((-way[1], way[0], 0.0))
    place = math.sin(a) * way + (0, 0, -math.cos(a))
    world = full_world(hung("distance", place=place))
    world.set_velocity("it", linear=omega * math.sin(a) * across)
    for k in range(1, 121):
        world.step()
        t = omega * k / 60.0
        expected = math.sin(a) * (math.cos(t) * way + math.sin(t) * across) + (0, 0, -math.cos(a))
        assert_allclose(world.position[0, 1], expected, atol=5e-3)
    tension = np.hypot.reduce(world.joint_reaction("joint")[0, :3])
    assert tension == pytest.approx(2.0 * G / math.cos(a), rel=5e-3)


def test_rope_is_slack_and_then_holds() -> None:
    world = full_world(hung("distance", place=(0, 0, 0.2), limits=(0.0, 1.0)))
    world.step(18)  # 0.3 s of free fall
    assert world.position[0, 1, 2] == pytest.approx(0.2 - 0.5 * G * 0.09, abs=1e-9)
    world.step(60)
    assert world.position[0, 1, 2] == pytest.approx(-1.0, abs=1e-3)
    assert_allclose(world.joint_reaction("joint")[0, :3], (0, 0, 2.0 * G), atol=1e-3 * G)


@pytest.mark.parametrize("place", PLACES[1:])
@pytest.mark.parametrize("ratio", [0.0, 0.2, 1.0])
def test_spring_swings_at_its_frequency(ratio: float, place: tuple[float, ...]) -> None:
    f, u = 2.0, np.array(place)
    world = full_world(hung("distance", 0.0, place=place, length=0.8, frequency=f, damping_ratio=ratio), options=FINE)
    for k in range(1, 241):
        world.step()
        t = k / 240.0
        x = damped_oscillation(f, ratio, t)
        assert_allclose(world.position[0, 1], (0.8 + 0.2 * x) * u, atol=2e-3)


def test_spring_sags_by_its_stiffness() -> None:
    world = full_world(hung("distance", stiffness=100.0, damping=20.0))
    world.step(300)
    assert_allclose(world.position[0, 1], (0, 0, -1.0 - 2.0 * G / 100.0), atol=1e-5)
    assert_allclose(world.joint_coordinate("joint"), 1.0 + 2.0 * G / 100.0, atol=1e-5)


@pytest.mark.parametrize("kind", ["distance", "weld"])
def test_stiff_springs_of_light_and_heavy_bodies_are_solved(kind: str) -> None:
    """Springs the substep can't follow, light links above a heavy end: sweeps alone would need thousands."""
    scene = space(G)
    scene.add_body("base", "static")
    last = "base"
    masses = [0.01] * 9 + [10.0]
    for k, mass in enumerate(masses):
        scene.add_body(f"link_{k}", shapes=[Sphere(radius=0.05)], mass=mass, position=(0, 0, -0.2 * (k + 1)))
        anchor: dict[str, Any] = {"anchor": (0, 0, -0.2 * k - 0.1)} if kind == "weld" else {}
        scene.add_joint(f"spring_{k}", make_joint(kind, last, f"link_{k}", stiffness=1e6, damping=1e3, **anchor))
        last = f"link_{k}"
    world = full_world(scene, options=Options(solver="pgs", sweeps=10, sleep=False))
    for _ in range(60):
        world.step()
        assert world.state.worlds["unconverged"][0] == 0
    load = [sum(masses[k:]) * G for k in range(10)]
    reactions = [world.joint_reaction(f"spring_{k}")[0, 2] for k in range(10)]
    assert_allclose(reactions, load, rtol=1e-4)
    assert_allclose(world.position[0, 10, 2], -2.0 - sum(load) / 1e6, rtol=1e-6)


# ---------------------------------------------------------------- ball, reactions, contradictions


@pytest.mark.parametrize("kind", ["ball", "weld", "distance"])
def test_a_hanging_weight_pulls_with_m_g(kind: str) -> None:
    anchors: dict[str, Any] = {} if kind == "distance" else {"anchor": (0, 0, 0)}
    world = full_world(hung(kind, mass=3.0, **anchors))
    world.step(60)
    assert_allclose(world.joint_reaction("joint")[0], (0, 0, 3.0 * G, 0, 0, 0), atol=1e-4)


def test_a_chain_of_balls_carries_what_hangs_below() -> None:
    scene = space(G)
    scene.add_body("base", "static")
    last = "base"
    for k in range(6):
        scene.add_body(
            f"link_{k}", shapes=[Capsule(half_length=0.2, radius=0.05)], mass=1.0 + k, position=(0, 0, -0.25 - 0.5 * k)
        )
        scene.add_joint(f"pin_{k}", Ball(last, f"link_{k}", anchor=(0, 0, -0.5 * k)))
        last = f"link_{k}"
    world = full_world(scene)
    world.step(60)
    for k in range(6):
        load = sum(1.0 + j for j in range(k, 6))
        assert_allclose(world.joint_reaction(f"pin_{k}")[0, :3], (0, 0, load * G), atol=1e-3 * load * G)
    assert world.diagnostics().joint_error[0] < 1e-4


@pytest.mark.parametrize("kinds", [("ball", "ball"), ("weld", "weld"), ("ball", "weld"), ("weld", "distance")])
def test_doubled_joints_stay_calm(kinds: tuple[str, str]) -> None:
    """Twice the same thing said: the body hangs still, and both together carry it."""
    scene = hung(kinds[0], anchor=(0, 0, 0))
    scene.add_joint("again", make_joint(kinds[1], "base", "it", anchor=(0, 0, 0) if kinds[1] != "distance" else None))
    world = full_world(scene)
    for _ in range(120):
        world.step()
        assert np.abs(world.state.bodies["velocity"][0, 1]).max() < 1e-3
    assert_allclose(world.position[0, 1], (0, 0, -1), atol=1e-4)
    both = world.joint_reaction("joint")[0] + world.joint_reaction("again")[0]
    assert_allclose(both[:3], (0, 0, 2.0 * G), atol=1e-2)


@pytest.mark.parametrize("kind", ["ball", "weld", "distance"])
def test_contradictory_joints_stay_calm(kind: str) -> None:
    """Held at two places 0.2 m apart: no explosion, and it settles between them."""
    anchors: dict[str, Any] = {} if kind == "distance" else {"anchor": (0, 0, -1)}
    scene = hung(kind, place=(0, 0, -1), **anchors)
    scene.add_body("other", "static", position=(0.2, 0, 0))
    if kind == "distance":
        scene.add_body("third", "static", position=(0, 0, -2.2))
        scene.add_joint("against", Distance("third", "it", length=0.8))
    else:
        scene.add_joint("against", make_joint(kind, "other", "it", anchor_a=(0, 0, -1), anchor_b=(0, 0, 0)))
    world = full_world(scene)
    for k in range(240):
        world.step()
        speed = np.abs(world.state.bodies["velocity"][0, 1]).max()
        assert speed < (5.0 if k < 60 else 0.5)
        assert np.hypot.reduce(world.position[0, 1] - (0.1, 0, -1.1)) < 1.0


def test_a_loop_of_balls_holds_together() -> None:
    """A square of four rods hung at a corner: one joint too many, none comes apart."""
    scene = space(G)
    scene.add_body("base", "static")
    corners = np.array([(0, 0, 0), (0.5, 0, -0.5), (0, 0, -1.0), (-0.5, 0, -0.5)])
    for k in range(4):
        a, b = corners[k], corners[(k + 1) % 4]
        turn = quaternion((0, 1, 0), math.atan2(b[0] - a[0], b[2] - a[2]))
        rod = Capsule(half_length=0.3, radius=0.03)
        scene.add_body(f"rod_{k}", shapes=[rod], mass=1.0, position=0.5 * (a + b), orientation=turn)
    for k in range(4):
        scene.add_joint(f"pin_{k}", Ball(f"rod_{k}", f"rod_{(k + 1) % 4}", anchor=corners[(k + 1) % 4]))
    scene.add_joint("hook", Ball("base", "rod_0", anchor=corners[0]))
    world = full_world(scene)
    start = world.diagnostics().energy[0]
    for _ in range(240):
        world.step()
        d = world.diagnostics()
        assert d.joint_error[0] < 5e-3
        assert d.energy[0] <= start + 1e-2
    assert np.isfinite(world.position).all()
