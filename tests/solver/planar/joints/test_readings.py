"""What is read of joints: coordinates against poses, rates against differences, reactions against momentum."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.planar import Box, Circle, Distance, Gear, Prismatic, Revolute, Weld, Wheel
from tests.solver.joints import make_joint
from tests.solver.planar.joints import reading_oracle
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, G, angular_momentum, held, joint

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
KINDS: dict[str, dict[str, Any]] = {
    "revolute": {"anchor": (-0.4, 0.1), "stiffness": 5.0, "damping": 0.3, "motor_speed": 1.0, "motor_effort": 2.0},
    "prismatic": {"anchor": (0.3, 0.1), "axis": (0.6, 0.8), "frequency": 0.7, "limits": (-0.2, 0.15)},
    "weld": {"anchor": (-0.4, 0.1), "frequency": 1.5, "damping_ratio": 0.1},
    "distance": {"anchor_a": (-0.7, 0.9), "anchor_b": (-0.3, 0.1)},
    "wheel": {"anchor": (0.1, 0.1), "axis": (0.6, 0.8), "frequency": 1.0, "motor_speed": 9.0, "motor_effort": 2.0},
    "target": {"anchor": (0.3, 0.1), "max_force": 15.0},
}


def pushed(kind: str, gravity: float, options: Options) -> World:
    """Two bars on a joint (a target: one), thrown into the air turning."""
    scene = Scene(gravity=(0, -gravity))
    thrown: dict[str, Any] = {"linear_velocity": (0.4, 0.3), "angular_velocity": 1.5}
    scene.add_body("b", shapes=[Box(half_extents=(0.4, 0.1))], mass=1.3, angle=0.5, **thrown)
    place = (-5.0, 0.0) if kind == "target" else (-0.8, 0.2)  # where nothing touches
    scene.add_body("a", shapes=[Box(half_extents=(0.5, 0.2))], mass=2.0, position=place, **thrown)
    scene.add_joint("joint", make_joint(kind, "a", "b", **KINDS[kind]))
    return World(scene, options=options)


@every_fidelity
@pytest.mark.parametrize("kind", KINDS)
def test_reactions_are_what_changes_momentum(kind: str, options: Options) -> None:
    # m dv = (F + m g) dt to the bit of rounding; I dw = (T + r x F) dt with the arm of the middle of the step
    world = pushed(kind, G, options)
    dt = world.timestep
    p = world.parameters
    for k in range(60):
        before = world.state.bodies[0].copy()
        world.step()
        after = world.state.bodies[0]
        force = world.joint_reaction("joint")[0]
        gain = p.mass[0, 0] * (after["velocity"][0, :2] - before["velocity"][0, :2]) / dt
        np.testing.assert_allclose(force[:2], np.add(gain, (0, p.mass[0, 0] * G)), atol=1e-9)
        if kind != "target":
            back = p.mass[0, 1] * (after["velocity"][1, :2] - before["velocity"][1, :2]) / dt
            np.testing.assert_allclose(-force[:2], np.add(back, (0, p.mass[0, 1] * G)), atol=1e-9)
        if k > 0:  # at first the two may be torn together
            angle = 0.5 * (before["angle"][0] + after["angle"][0])
            c, s = math.cos(angle), math.sin(angle)
            arm = np.array([[c, -s], [s, c]]) @ p.joints["anchor_b"][0, 0]
            torque = force[2] + arm[0] * force[1] - arm[1] * force[0]
            gained = p.inertia[0, 0] * (after["velocity"][0, 2] - before["velocity"][0, 2]) / dt
            assert torque == pytest.approx(gained, abs=0.02 * (1 + np.hypot(*force[:2])))


@pytest.mark.parametrize("kind", ["revolute", "distance", "wheel"])
def test_pins_carry_no_torque_but_the_motor_s(kind: str) -> None:
    given = {word: value for word, value in KINDS[kind].items() if word in ("anchor", "anchor_a", "anchor_b", "axis")}
    world = held(kind, gravity=G, position=(0.3, 0.4), spin=4.0, **given)
    for k in range(60):
        world.step()
        if k > 0:
            assert world.joint_reaction("joint")[0, 2] == pytest.approx(0, abs=1e-9)
    if kind != "distance":
        driven = held(kind, position=(0.3, 0.4), motor_speed=1e3, motor_effort=2.5, **given)
        driven.step(20)
        assert driven.joint_reaction("joint")[0, 2] == pytest.approx(2.5, rel=1e-6)


@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind not in ("weld", "target")])
def test_rate_is_the_change_of_the_coordinate(kind: str) -> None:
    # central difference over two steps, second order
    world = pushed(kind, 0.0, AWAKE)
    world.step(2)
    q, rates = [], []
    for _ in range(40):
        world.step()
        q.append(world.joint_coordinate("joint")[0])
        rates.append(world.joint_rate("joint")[0])
    difference = (np.array(q[2:]) - q[:-2]) / (2 * world.timestep)
    jumps = np.abs(np.diff(rates, 2)) > 0.02  # at a limit
    np.testing.assert_allclose(np.where(jumps, 0, difference), np.where(jumps, 0, rates[1:-1]), atol=0.01)


def test_coordinates_of_poses() -> None:
    scene = Scene(gravity=(0, 0))
    scene.add_body("a", shapes=[Box(half_extents=(0.5, 0.2))], angle=0.3)
    scene.add_body("b", shapes=[Box(half_extents=(0.5, 0.2))], position=(1, 1), angle=1.0)
    scene.add_body("base", "static")
    scene.add_joint("hinge", Revolute("a", "b"))
    scene.add_joint("slide", Prismatic("a", "b", axis=(0, 2)))
    scene.add_joint("wheel", Wheel("a", "b", axis=(1, 0)))
    scene.add_joint("rod", Distance("a", "b", anchor_a=(0, 0), anchor_b=(0.1, 0)))
    scene.add_joint("second", Revolute("a", "base"))
    scene.add_joint("glue", Weld("a", "b"))
    world = World(scene, world_count=2)
    read = {name: world.joint_coordinate(name) for name in ("hinge", "slide", "wheel", "rod", "second")}
    length = math.hypot(1 + 0.1 * math.cos(1), 1 + 0.1 * math.sin(1))
    for name, value in (("hinge", 0.0), ("slide", 0.0), ("wheel", 0.0), ("rod", length), ("second", 0.0)):
        np.testing.assert_allclose(read[name], value, atol=1e-14)
    # a turns by pi/2 in place: its axes turn with it; b moves away and turns by 7 rad
    world.set_pose("a", angle=0.3 + math.pi / 2, worlds=1)
    world.set_pose("b", position=(3, 1), angle=8.0, worlds=1)
    turn = 7.0 - math.pi / 2
    pin = np.array((-1.0, 1.0))  # where a's anchor at (1, 1) has gone
    apart = np.array((3.0, 1.0)) - pin
    assert world.joint_coordinate("hinge")[1] == pytest.approx(turn, rel=1e-14)
    assert world.joint_coordinate("slide")[1] == pytest.approx(-apart[0], rel=1e-14)  # "up" is now -x
    assert world.joint_coordinate("wheel")[1] == pytest.approx(apart[1], abs=1e-14)
    assert world.joint_coordinate("rod")[1] == pytest.approx(math.hypot(3 + 0.1 * math.cos(8), 1 + 0.1 * math.sin(8)))
    assert world.joint_coordinate("second")[1] == pytest.approx(-math.pi / 2, rel=1e-14)
    np.testing.assert_allclose([read[name][0] for name in read], [world.joint_coordinate(name)[0] for name in read])
    with pytest.raises(ValueError, match="joint 'glue' is a weld and has no coordinate"):
        world.joint_coordinate("glue")
    with pytest.raises(ValueError, match="joint 'glue' is a weld and has no coordinate"):
        world.joint_rate("glue")
    with pytest.raises(ValueError, match=r"joint 'hing' is unknown.*did you mean 'hinge'"):
        world.joint_reaction("hing")
    with pytest.raises(ValueError, match="joint_coordinate needs a joint, got the body 'a'"):
        world.joint_coordinate(Handle("body", "a", 0))


@pytest.mark.parametrize(
    ("kind", "given", "error"),
    [
        ("revolute", {}, 0.5),
        ("weld", {}, 0.5),
        ("weld", {"frequency": 1.0}, 0.0),
        ("weld", {"damping": 1.0}, 0.0),
        ("prismatic", {"axis": (1, 0)}, 0.4),
        ("wheel", {"axis": (0, 1)}, 0.3),
        ("distance", {"anchor_a": (0, -1)}, math.hypot(0.3, 1.4) - 1.0),
        ("distance", {"anchor_a": (0, -1), "limits": (0, 1.25)}, math.hypot(0.3, 1.4) - 1.25),
        ("distance", {"anchor_a": (0, -1), "limits": (2, 3)}, 2.0 - math.hypot(0.3, 1.4)),
        ("distance", {"anchor_a": (0, -1), "frequency": 1.0}, 0.0),
    ],
)
def test_joint_error_of_a_body_that_was_put_elsewhere(kind: str, given: dict[str, Any], error: float) -> None:
    world = held(kind, worlds=2, **given)
    world.set_pose("bar", position=(0.3, 0.4), worlds=1)
    assert world.diagnostics().joint_error[1] == pytest.approx(error, rel=1e-12)
    if "limits" not in given:
        assert world.diagnostics().joint_error[0] == pytest.approx(0, abs=1e-15)
    world.parameters.set(joint(world), enabled=False)
    np.testing.assert_array_equal(world.diagnostics().joint_error, 0.0)


def test_spring_energy_of_poses() -> None:
    omega = 2.0 * math.pi
    for kind, given, expected in (
        ("revolute", {"stiffness": 40.0, "rest": 0.1}, 20.0 * 0.4**2),
        ("revolute", {"frequency": 1.0}, 0.5 * 3.0 * omega**2 * 0.5**2),
        ("prismatic", {"stiffness": 40.0, "axis": (0, 1), "rest": 0.1}, 20.0 * 0.3**2),
        ("wheel", {"frequency": 1.0, "axis": (1, 0)}, 0.5 * 2.0 * omega**2 * 0.3**2),
        ("distance", {"stiffness": 40.0, "anchor_a": (0, -1), "length": 0.9}, 20.0 * (math.hypot(0.3, 1.4) - 0.9) ** 2),
        ("weld", {"stiffness": 40.0}, 20.0 * (0.3**2 + 0.4**2 + 0.5**2)),
        ("weld", {"frequency": 1.0}, 0.5 * omega**2 * (2.0 * 0.25 + 3.0 * 0.5**2)),
        ("prismatic", {"damping": 40.0, "axis": (0, 1)}, 0.0),
    ):
        world = held(kind, **given)
        world.set_pose("bar", position=(0.3, 0.4), angle=0.5)
        diagnostics = world.diagnostics()
        assert diagnostics.spring_energy[0] == pytest.approx(expected, rel=1e-12)
        assert diagnostics.energy[0] == pytest.approx(expected, rel=1e-12)
        world.parameters.set(joint(world), enabled=False)
        assert world.diagnostics().spring_energy[0] == 0.0


def test_inside_forces_leave_the_whole_alone() -> None:
    # springs, motors and limits between free bodies: momentum and angular momentum stay
    scene = Scene(gravity=(0, 0))
    for name, x in (("a", 0.0), ("b", 1.0), ("c", 2.0), ("d", 3.0)):
        scene.add_body(name, shapes=[Box(half_extents=(0.4, 0.1))], position=(x, 0.1 * x), angular_velocity=0.5 * x)
    scene.add_body("e", shapes=[Circle(radius=0.2)], position=(3, 1))
    scene.add_joint("ab", Revolute("a", "b", anchor=(0.5, 0), motor_speed=4.0, motor_effort=0.1, limits=(-0.5, 0.5)))
    scene.add_joint("bc", Prismatic("b", "c", axis=(1, 0.1), frequency=1.0, limits=(-0.2, 0.2)))
    scene.add_joint("cd", Weld("c", "d", frequency=2.0, damping_ratio=0.2))
    scene.add_joint("de", Wheel("d", "e", axis=(0, 1), stiffness=3.0, motor_speed=20.0, motor_effort=0.05))
    scene.add_joint("ae", Distance("a", "e", limits=(0, 3.3)))
    world = World(scene, options=AWAKE)
    world.step(2)
    momentum, spin = world.diagnostics().momentum.copy(), angular_momentum(world)
    for _ in range(240):
        world.step()
        np.testing.assert_allclose(world.diagnostics().momentum, momentum, atol=1e-10)
    assert angular_momentum(world) == pytest.approx(spin, rel=1e-2)


SPRINGS: dict[str, list[dict[str, Any]]] = {
    "weld": [{}, {"frequency": 2.0}, {"stiffness": 30.0, "damping": 1.0}, {"damping": 1.0}],
    "revolute": [{}, {"frequency": 2.0, "limits": (-1, 1)}, {"stiffness": 9.0}],
    "prismatic": [{"axis": (0.6, 0.8), **spring} for spring in ({}, {"frequency": 2.0}, {"stiffness": 9.0})],
    "wheel": [{"axis": (0.6, 0.8), **spring} for spring in ({}, {"frequency": 2.0}, {"stiffness": 9.0})],
    "distance": [{}, {"limits": (0.5, 1.0)}, {"frequency": 2.0, "limits": (0.5, 1.0)}, {"stiffness": 9.0}],
    "target": [{}],
}


def test_errors_and_energies_are_those_of_plain_numpy() -> None:
    random = np.random.default_rng(3)
    scene = Scene()
    given = [(kind, spring) for kind, springs in SPRINGS.items() for spring in springs]
    for k in range(len(given) + 1):
        shape = Box(half_extents=random.uniform(0.1, 0.5, 2), position=random.uniform(-0.2, 0.2, 2))
        scene.add_body(f"body_{k}", "dynamic" if k else "static", [shape], position=random.uniform(-1, 1, 2))
    for k, (kind, spring) in enumerate(given):
        before = 0 if kind == "revolute" else random.integers(k + 1)  # a gear needs what is fixed
        scene.add_joint(f"joint_{k}", make_joint(kind, f"body_{before}", f"body_{k + 1}", **spring))
    scene.add_constraint("rule", ["body_1"], [1, 0, 0])
    hinges = [k for k, (kind, _) in enumerate(given) if kind == "revolute"]
    scene.add_joint("gear", Gear(f"joint_{hinges[0]}", f"joint_{hinges[1]}"))
    world = World(scene, world_count=4)
    turn = random.uniform(-9, 9, world.angle.shape)
    world.state.bodies["angle"] += turn
    world.state.bodies["rotation"] = np.stack([np.cos(turn), np.sin(turn)], -1)
    world.state.bodies["position"] += random.normal(size=world.center_of_mass.shape)
    world.state.joints["rest"] = random.normal(size=world.state.joints["rest"].shape)
    world.parameters.set("body_3", enabled=False, worlds=2)
    for k in range(0, len(given), 3):
        world.parameters.set(joint(world, f"joint_{k}"), enabled=False, worlds=1)
    read = world.diagnostics()
    error = reading_oracle.joint_error(world.model, world.parameters, world.state)
    stored = reading_oracle.spring_energy(world.model, world.parameters, world.state)
    assert (error > 0.1).all()
    assert len(set(stored)) == 4
    np.testing.assert_allclose(read.joint_error, error, rtol=1e-13)
    np.testing.assert_allclose(read.spring_energy, stored, rtol=1e-13)
    for k in range(len(given)):  # one by one: the largest error hides the others
        only = np.arange(len(world.model.joints)) == k
        world.parameters.joints["enabled"] = only
        error = reading_oracle.joint_error(world.model, world.parameters, world.state)
        stored = reading_oracle.spring_energy(world.model, world.parameters, world.state)
        np.testing.assert_allclose(world.diagnostics().joint_error, error, rtol=1e-12, err_msg=str(given[k]))
        np.testing.assert_allclose(world.diagnostics().spring_energy, stored, rtol=1e-12, err_msg=str(given[k]))
