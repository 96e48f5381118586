"""Joints that contradict, repeat or tear: everything stays finite, calm and visible in the diagnostics."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, Distance, Gear, Prismatic, Revolute, Wheel
from tests.solver.bits import everything
from tests.solver.joints import make_joint
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, INF, G, angular_momentum, chain, energy, joint

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)


def hung(*joints: dict[str, Any]) -> Scene:
    """A bar of 1 m and 1 kg from (0, 0) to the right, joined to the static "frame"."""
    scene = Scene()
    scene.add_body("frame", "static")
    scene.add_body("bar", shapes=[Box(half_extents=(0.5, 0.1))], mass=1.0, position=(0.5, 0))
    for k, given in enumerate(joints):
        scene.add_joint(f"joint_{k}", make_joint(body_a="frame", body_b="bar", **given))
    return scene


def run(scene: Scene | World, steps: int = 300, options: Options = AWAKE) -> tuple[World, float, float]:
    """(world, highest energy above the start, largest joint error, m) of a run that stays finite."""
    world = World(scene, options=options) if isinstance(scene, Scene) else scene
    start, highest, worst = energy(world), -INF, 0.0
    for _ in range(steps):
        world.step()
        now = world.diagnostics()
        highest = max(highest, now.energy[0] - start)
        worst = max(worst, now.joint_error[0])
    assert np.isfinite(world.position).all()
    assert np.isfinite(world.linear_velocity).all()
    return world, highest, worst


LEFT, MIDDLE, RIGHT = (0.0, 0.0), (0.5, 0.0), (1.0, 0.0)
WEIGHT = {"weld twice": ("weld", LEFT, "weld", RIGHT), "hinged at both ends": ("revolute", LEFT, "revolute", RIGHT)}


@every_fidelity
@pytest.mark.parametrize("redundant", WEIGHT)
def test_held_twice(redundant: str, options: Options) -> None:
    one, at, other, there = WEIGHT[redundant]
    world, highest, worst = run(hung({"kind": one, "anchor": at}, {"kind": other, "anchor": there}), options=options)
    assert highest < 1e-6
    assert worst < 1e-6
    force = world.joint_reaction("joint_0")[0] + world.joint_reaction("joint_1")[0]
    np.testing.assert_allclose(force[:2], (0, G), atol=1e-4 * G)


@every_fidelity
def test_the_same_hinge_twice_swings_like_one(options: Options) -> None:
    hinge = {"kind": "revolute", "anchor": LEFT}
    twice, highest, worst = run(hung(hinge, hinge), options=options)
    once, _, _ = run(hung(hinge), options=options)
    assert highest < 1e-3
    assert worst < 1e-4
    assert twice.angle[0, 1] == pytest.approx(once.angle[0, 1], abs=2e-3)
    assert abs(once.linear_velocity[0, 1]).max() > 0.3


@every_fidelity
@pytest.mark.parametrize("kind", ["weld", "revolute"])
def test_joints_that_contradict_each_other(kind: str, options: Options) -> None:
    # one wants the bar 0.3 m to the right of where the other wants it: it comes to rest there or between
    scene = hung(
        {"kind": kind, "anchor_a": LEFT, "anchor_b": (-0.5, 0)},
        {"kind": kind, "anchor_a": (1.3, 0), "anchor_b": (0.5, 0)},
    )
    world, highest, worst = run(scene, options=options)
    assert 0.1 < world.diagnostics().joint_error[0] < 0.31  # it says so
    assert worst < 0.35
    assert highest < 0.3 * G
    assert energy(world) < 0.05 * G
    assert abs(world.linear_velocity[0, 1]).max() < 1e-3


def linkage(points: list[tuple[float, float]], scene: Scene) -> None:
    """Bars from point to point, bar k from k to k + 1."""
    for k, (p, q) in enumerate(itertools.pairwise(points)):
        along = np.subtract(q, p)
        half = 0.5 * float(np.hypot(*along))
        middle = 0.5 * np.add(p, q)
        bar = Box(half_extents=(half, 0.03))
        scene.add_body(f"bar_{k}", shapes=[bar], mass=1.0, position=middle, angle=math.atan2(along[1], along[0]))


@every_fidelity
def test_four_bar_linkage(options: Options) -> None:
    scene = Scene()
    scene.add_body("frame", "static")
    points = [(0.0, 0.0), (0.0, 0.5), (1.2, 0.9), (1.0, 0.0)]
    linkage(points, scene)
    scene.add_joint("a", Revolute("frame", "bar_0", anchor=points[0]))
    scene.add_joint("b", Revolute("bar_0", "bar_1", anchor=points[1]))
    scene.add_joint("c", Revolute("bar_1", "bar_2", anchor=points[2]))
    scene.add_joint("d", Revolute("bar_2", "frame", anchor=points[3]))
    world, highest, worst = run(scene, options=options)
    assert highest < 1e-3 * G
    assert worst < 1e-3
    assert energy(world) > -1.5 * 3 * G


@every_fidelity
def test_ring_of_eight(options: Options) -> None:
    points = [(math.cos(k * math.pi / 4), math.sin(k * math.pi / 4)) for k in range(9)]
    scene = Scene()
    scene.add_body("frame", "static")
    linkage(points, scene)
    for k in range(8):
        scene.add_joint(f"pin_{k}", Revolute(f"bar_{k}", f"bar_{(k + 1) % 8}", anchor=points[k + 1]))
    scene.add_joint("hook", Revolute("frame", "bar_2", anchor=points[2]))
    world, highest, worst = run(scene, 600, options)
    assert highest < 1e-3 * 8 * G
    assert worst < 5e-3
    np.testing.assert_allclose(world.joint_reaction("hook")[0, 1], 8 * G, rtol=0.2)  # it swings still
    assert world.diagnostics().joint_error[0] < 1e-4


def test_speeds_that_a_gear_contradicts() -> None:
    # bounded motors: the stronger one wins; unbounded ones: it says that it did not converge
    def geared(first: float, second: float) -> World:
        scene = Scene(gravity=(0, 0))
        scene.add_body("frame", "static")
        for name, x, effort in (("p", 0.0, first), ("q", 2.0, second)):
            scene.add_body(name, shapes=[Circle(radius=0.3)], position=(x, 0))
            scene.add_joint(f"axle_{name}", Revolute("frame", name, motor_speed=10.0, motor_effort=effort))
        scene.add_joint("gear", Gear("axle_p", "axle_q"))
        return World(scene, options=AWAKE)

    world, _, _ = run(geared(2.0, 5.0), 120)
    assert world.joint_rate("axle_q")[0] == pytest.approx(10, rel=1e-5)
    assert world.joint_rate("axle_p")[0] == pytest.approx(-10, rel=1e-5)
    world, _, _ = run(geared(INF, INF), 120)
    assert abs(world.angular_velocity).max() < 10.0 + 1e-6
    assert world.diagnostics().unconverged[0] > 0


@every_fidelity
@pytest.mark.parametrize(
    ("kind", "given"),
    [
        ("revolute", {}),
        ("weld", {}),
        ("prismatic", {"axis": (1, 0)}),
        ("wheel", {"axis": (1, 0)}),
        ("distance", {"length": 0.1}),
        ("distance", {"limits": (0, 0.1)}),
    ],
)
def test_anchors_given_a_metre_apart(kind: str, given: dict[str, Any], options: Options) -> None:
    scene = hung({"kind": kind, "anchor_a": (-0.8, 0.6), "anchor_b": (-0.5, 0), **given})
    start = World(scene).diagnostics().joint_error[0]
    assert start > 0.55
    world, highest, _ = run(scene, 600, options)
    assert highest < 1.0 * G  # what the lift to the anchor takes, no more
    assert world.diagnostics().joint_error[0] < 1e-3
    if kind in ("weld", "prismatic"):
        assert world.angle[0, 1] == pytest.approx(0, abs=1e-6)
    fastest = math.sqrt(2 * G * 2.2)  # of a free fall through all that the bar can fall
    if kind != "wheel" and kind != "prismatic":
        assert np.hypot(*world.linear_velocity[0, 1]) < fastest


@every_fidelity
def test_chain_torn_a_metre_apart_closes(options: Options) -> None:
    world = chain(3, options=options)
    world.set_pose("bar_1", position=(2.0, 1.0))
    world.set_pose("bar_2", position=(2.5, -0.7))
    world, highest, worst = run(world, 300)
    assert worst < 1.78  # as it was torn
    assert highest < 0.1 * G  # the way back is partly upwards
    assert world.diagnostics().joint_error[0] < 1e-3


@every_fidelity
@pytest.mark.parametrize("ratio", [1e4, 1e-4])
def test_mass_ratio_over_a_joint(ratio: float, options: Options) -> None:
    scene = hung({"kind": "revolute", "anchor": LEFT})
    scene.add_body("load", shapes=[Box(half_extents=(0.5, 0.1))], mass=ratio, position=(1.5, 0))
    scene.add_joint("link", Revolute("bar", "load", anchor=RIGHT))
    _, highest, worst = run(scene, 300, options)
    assert highest < 1e-3 * max(ratio, 1.0) * G
    assert worst < 1e-3


@pytest.mark.parametrize(("spin", "kept"), [(10.0, 0.99), (30.0, 0.9)])
def test_fast_spin_without_gravity(spin: float, kept: float) -> None:
    # two bars that turn as one about the hinge between them; energy may be lost, never made
    world = spinning(spin)
    start, momentum = energy(world), angular_momentum(world)
    world, highest, worst = run(world, 120)
    assert highest < 1e-3 * start
    assert worst < 0.05
    assert kept * momentum < angular_momentum(world) < 1.001 * momentum


def test_a_hundred_rad_per_second_is_calm() -> None:
    # 0.8 rad a substep: more than can be followed
    world = spinning(100.0)
    start = energy(world)
    world, highest, worst = run(world, 300)
    assert highest < 1e-2 * start
    assert worst < 0.5
    assert world.diagnostics().joint_error[0] < 1e-3


def spinning(spin: float) -> World:
    scene = Scene(gravity=(0, 0))
    for name, side in (("left", -1), ("right", 1)):
        motion: dict[str, Any] = {"linear_velocity": (0, 0.5 * side * spin), "angular_velocity": spin}
        scene.add_body(name, shapes=[Box(half_extents=(0.5, 0.1))], position=(0.5 * side, 0), **motion)
    scene.add_joint("hinge", Revolute("left", "right", anchor=(0, 0)))
    return World(scene, options=AWAKE)


# ---------------------------------------------------------------- switched off and on


def test_no_joint_without_a_body_that_can_move() -> None:
    scene = Scene()
    scene.add_body("wall", "static")
    scene.add_body("lift", "kinematic")
    scene.add_body("floor", "static")
    sliding: dict[str, Any] = {"axis": (1, 0)}
    for kind, given in (("revolute", {}), ("prismatic", sliding), ("distance", {}), ("wheel", sliding)):
        for a, b in (("wall", "lift"), ("lift", "wall"), ("wall", "floor")):
            with pytest.raises(ValueError, match="joint 'joint' needs at least one dynamic body"):
                scene.add_joint("joint", make_joint(kind, a, b, **given))
    assert not scene.joints


def test_body_switched_off_under_a_joint() -> None:
    # the first bar stands still: what hung on it swings from where it was, then both go on
    world = chain(2)
    world.step(20)
    world.parameters.set("bar_0", enabled=False)
    place, moving = world.position[0, 1].copy(), world.linear_velocity[0, 1].copy()
    _, highest, worst = run(world, 120)
    np.testing.assert_array_equal(world.position[0, 1], place)
    np.testing.assert_array_equal(world.linear_velocity[0, 1], moving)  # that with which it will go on
    assert highest < 1e-2
    assert worst < 1e-3
    world.parameters.set("bar_0", enabled=True)
    _, highest, _ = run(world, 120)
    assert highest < 1e-2
    assert world.diagnostics().joint_error[0] < 1e-4


HANGERS: dict[str, dict[str, Any]] = {
    "revolute": {"anchor": (0.0, 0.0)},
    "distance": {},
    "weld": {"anchor": (0.0, 0.0), "frequency": 1.0},
    "wheel": {"anchor": (0.0, 0.0), "axis": (0.6, 0.8), "frequency": 1.0},
}


@every_fidelity
@pytest.mark.parametrize("hanger", HANGERS)
def test_a_disabled_body_is_an_anchor_at_rest(hanger: str, options: Options) -> None:
    def hang(**given: Any) -> World:
        scene = Scene()
        scene.add_body("post", shapes=[Box(half_extents=(0.2, 0.2))], **given)
        scene.add_body("bar", shapes=[Box(half_extents=(0.5, 0.1))], mass=1.0, position=(0.6, 0.0))
        scene.add_joint("joint", make_joint(hanger, "post", "bar", **HANGERS[hanger]))
        world = World(scene, options=options)
        world.step(60)
        return world

    thrown: dict[str, Any] = {"enabled": False, "linear_velocity": (3.0, 2.0), "angular_velocity": 5.0}
    fixed = hang(kind="static")
    for kind in ("dynamic", "kinematic"):
        off = hang(kind=kind, **thrown)
        np.testing.assert_allclose(off.position, fixed.position, rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(off.linear_velocity[0, 1], fixed.linear_velocity[0, 1], rtol=0.0, atol=1e-12)
        off.parameters.set("post", enabled=True)
        assert tuple(off.linear_velocity[0, 0]) == (3.0, 2.0)
        off.step()
        assert np.linalg.norm(off.position[0, 0]) > 0.01


def test_joint_switched_off_and_on() -> None:
    world = chain(2)
    link = joint(world, "hinge_1")
    world.step(30)
    world.parameters.set(link, enabled=False)
    before = world.linear_velocity[0, 2].copy()
    world.step(30)
    np.testing.assert_allclose(world.linear_velocity[0, 2] - before, (0, -0.5 * G), atol=1e-9)
    np.testing.assert_array_equal(world.joint_reaction("hinge_1"), 0.0)
    assert world.diagnostics().joint_error[0] < 1e-4  # what is off has no error
    world.parameters.set(link, enabled=True)
    assert world.diagnostics().joint_error[0] > 0.5
    world, highest, _ = run(world, 300)
    assert highest < 2.5 * G  # the bars are drawn together, partly upwards
    assert world.diagnostics().joint_error[0] < 1e-4


# ---------------------------------------------------------------- worlds side by side


def mechanism() -> Scene:
    """Every kind of linked joint in one island, with an actuator."""
    scene = Scene()
    scene.add_body("frame", "static")
    for name, x in (("arm", 0.5), ("hand", 1.5)):
        scene.add_body(name, shapes=[Box(half_extents=(0.5, 0.1))], position=(x, 0))
    for name, place in (("slider", (2, 0)), ("ball", (0, -2)), ("wheel", (-1, 0))):
        scene.add_body(name, shapes=[Circle(radius=0.2)], position=place)
    scene.add_joint("hinge", Revolute("frame", "arm", anchor=(0, 0), limits=(-2, 2), motor_speed=1, motor_effort=3))
    scene.add_joint("elbow", Revolute("arm", "hand", anchor=(1, 0), frequency=2.0, damping_ratio=0.1))
    scene.add_joint("slide", Prismatic("hand", "slider", axis=(1, 0), limits=(-0.3, 0.3), stiffness=20, damping=1))
    scene.add_joint("cord", Distance("slider", "ball", limits=(0, 3.0), frequency=1.0))
    scene.add_joint("axle", Wheel("frame", "wheel", axis=(0, 1), frequency=3.0))
    scene.add_joint("spindle", Revolute("frame", "wheel", enabled=False))
    scene.add_joint("gear", Gear("spindle", "hinge", ratio=-1.0, enabled=False))
    scene.add_actuator("push", "hinge", mode="torque", lower=-5, upper=5)
    return scene


def tune(world: World, k: int, worlds: int | None) -> None:
    """Parameters of variant ``k``."""
    changes: dict[str, dict[str, Any]] = {
        "hinge": {"lower": -0.5 - k, "upper": 0.1 + 0.2 * k, "motor_effort": 1.0 + 3.0 * k},
        "elbow": {"frequency": 1.0 + k, "damping_ratio": 0.1 * k, "spring_effort": 10.0 + k},
        "slide": {"stiffness": 20.0 + 50.0 * k, "damping": 0.3 * k, "lower": -0.1 * k, "upper": 0.2},
        "cord": {"length": 2.0 + 0.1 * k, "upper": 2.2 + 0.2 * k},
        "axle": {"frequency": 1.0 + k},
        "gear": {"enabled": k % 2 == 1},
    }
    for name, fields in changes.items():
        world.parameters.set(joint(world, name), worlds=worlds, **fields)


@pytest.fixture(scope="module")
def variants() -> tuple[World, list[World]]:
    """Four worlds of different parameters and controls, together and one by one, mid-swing."""
    together = World(mechanism(), world_count=4, threads=2)
    alone = [World(mechanism()) for _ in range(4)]
    for k in range(4):
        tune(together, k, k)
        tune(alone[k], k, None)
    random = np.random.default_rng(0)
    for _ in range(120):
        push = random.uniform(-6, 6, 4)
        together.control[:, 0] = push
        together.step()
        for k in range(4):
            alone[k].control[:] = push[k]
            alone[k].step()
    return together, alone


def test_worlds_of_different_joints_are_those_of_single_worlds(variants: tuple[World, list[World]]) -> None:
    together, alone = variants
    assert np.isfinite(together.position).all()
    assert together.diagnostics().joint_error.max() < 2e-3
    for k in range(4):
        assert everything(together, [k]) == everything(alone[k])
    assert len({everything(world) for world in alone}) == 4


def test_save_and_restore_mid_swing(variants: tuple[World, list[World]]) -> None:
    together, _ = variants
    saved = together.save()
    together.step(60)
    after = everything(together)
    together.restore(saved)
    together.step(60)
    assert everything(together) == after
    other = World(mechanism(), world_count=4)
    other.restore(saved)
    other.control[:] = together.control
    other.step(60)
    assert everything(other) == after
    other.reset()
    other.control[:] = 0.0
    assert everything(other) == everything(World(mechanism(), world_count=4))


RUNS: dict[str, Callable[[Options], World]] = {
    "chain": lambda options: chain(6, options=options),
    "mechanism": lambda options: World(mechanism(), options=options),
}


@pytest.mark.parametrize("solver", ["pgs", "nncg", "subspace"])
@pytest.mark.parametrize("name", RUNS)
def test_every_solver(name: str, solver: str) -> None:
    world = RUNS[name](Options(solver=solver, sleep=False))
    world, highest, worst = run(world, 180)
    assert highest < 0.1 * G
    assert worst < 2e-3
