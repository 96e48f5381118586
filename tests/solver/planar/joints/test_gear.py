"""Gears: ratios held under load, on fixed, driven and free frames; racks; refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Circle, Gear, Prismatic, Revolute, Weld
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, FINE, angular_momentum, energy

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)
RATIOS = (-2.0, -1.0, 0.5, 1.0, 3.0)


def gearbox(ratio: float, frame: str = "static", options: Options = AWAKE, spin: float = 0.0, **motor: Any) -> World:
    """Wheels "p" and "q" on pins of a frame, 1.2 m apart, geared: q_p + ratio q_q = const."""
    scene = Scene(gravity=(0, 0))
    mass: dict[str, Any] = {"mass": 2.0} if frame == "dynamic" else {}
    turning: dict[str, Any] = {} if frame == "static" else {"angular_velocity": spin}
    scene.add_body("frame", frame, [Box(half_extents=(1, 0.1))], **mass, **turning)
    for name, radius, x in (("p", 0.4, -0.6), ("q", 0.2, 0.6)):
        body: dict[str, Any] = {"position": (x, 0), "linear_velocity": (0, spin * x), "angular_velocity": spin}
        scene.add_body(name, shapes=[Circle(radius=radius)], **body)
    scene.add_joint("axle_p", Revolute("frame", "p", **motor))
    scene.add_joint("axle_q", Revolute("frame", "q"))
    scene.add_joint("gear", Gear("axle_p", "axle_q", ratio=ratio))
    return World(scene, options=options)


@every_fidelity
@pytest.mark.parametrize("ratio", RATIOS)
def test_loaded_gear_holds_its_ratio(ratio: float, options: Options) -> None:
    # torques 1 N m on p and 0.3 N m on q; w_p = -ratio w_q: (I_p + I_q / ratio^2) w_p' = 1 - 0.3 / ratio
    world = gearbox(ratio, options=options)
    inertia = world.parameters.inertia[0]
    acceleration = (1.0 - 0.3 / ratio) / (inertia[1] + inertia[2] / ratio**2)
    for k in range(1, 121):
        world.apply_force("p", torque=1.0)
        world.apply_force("q", torque=0.3)
        world.step()
        assert world.joint_rate("axle_p")[0] == pytest.approx(acceleration * k / 60.0, rel=1e-5)
        assert world.joint_coordinate("gear")[0] == pytest.approx(0, abs=1e-6)
        assert world.joint_rate("gear")[0] == pytest.approx(0, abs=1e-4 * abs(world.joint_rate("axle_p")[0]))
    assert world.joint_coordinate("axle_p")[0] == pytest.approx(0.5 * acceleration * 4.0, rel=1e-4)


@pytest.mark.parametrize("ratio", RATIOS)
def test_motor_in_a_free_frame_makes_no_momentum(ratio: float) -> None:
    world = gearbox(ratio, "dynamic", motor_speed=20.0, motor_effort=1.0)
    size = 0.0
    for _ in range(120):
        world.step()
        size = max(size, abs(world.parameters.inertia[0] * world.angular_velocity[0]).max())
        assert abs(angular_momentum(world)) < 1e-5 * size
        assert abs(world.diagnostics().momentum).max() < 1e-9
        assert world.joint_coordinate("gear")[0] == pytest.approx(0, abs=1e-6)
    # in the frame w_p = 20, w_q = -20 / ratio; the frame turns back so that all of it stays 0
    assert world.joint_rate("axle_p")[0] == pytest.approx(20, rel=1e-6)
    assert world.joint_rate("axle_q")[0] == pytest.approx(-20 / ratio, rel=1e-5)
    inertia, mass = world.parameters.inertia[0], world.parameters.mass[0]
    offset = 0.6 * (mass[2] - mass[1]) / mass.sum()  # of the common centre
    whole = inertia.sum() + mass[0] * offset**2 + mass[1] * (0.6 + offset) ** 2 + mass[2] * (0.6 - offset) ** 2
    turned = -(inertia[1] * 20 - inertia[2] * 20 / ratio) / whole
    assert world.angular_velocity[0, 0] == pytest.approx(turned, rel=1e-4)


@pytest.mark.parametrize("ratio", [-2.0, 0.5, 3.0])
def test_free_gearbox_that_spins_keeps_energy_and_momentum(ratio: float) -> None:
    world = gearbox(ratio, "dynamic", spin=3.0)
    world.set_velocity("p", angular=3.0 + 6.0)
    world.set_velocity("q", angular=3.0 - 6.0 / ratio)
    spin, start = angular_momentum(world), energy(world)
    for _ in range(180):
        world.step()
        assert angular_momentum(world) == pytest.approx(spin, rel=1e-5)
        assert energy(world) == pytest.approx(start, rel=1e-4)
        assert world.joint_coordinate("gear")[0] == pytest.approx(0, abs=5e-5)
    assert world.joint_rate("axle_p")[0] == pytest.approx(6, rel=1e-4)


@pytest.mark.parametrize("ratio", [-2.0, 1.0])
def test_gear_on_a_frame_that_is_turned(ratio: float) -> None:
    # a carrier at 1 rad/s takes both wheels along; a torque turns them in it by the ratio
    world = gearbox(ratio, "kinematic", spin=1.0)
    world.step(60)
    np.testing.assert_allclose(world.angular_velocity[0], 1.0, rtol=1e-4)
    inertia = world.parameters.inertia[0]
    acceleration = 0.5 / (inertia[1] + inertia[2] / ratio**2)
    for _ in range(60):
        world.apply_force("p", torque=0.5)
        world.step()
    assert world.joint_rate("axle_p")[0] == pytest.approx(acceleration, rel=1e-3)
    assert world.joint_rate("axle_q")[0] == pytest.approx(-acceleration / ratio, rel=1e-3)
    assert world.joint_coordinate("gear")[0] == pytest.approx(0, abs=1e-5)


@every_fidelity
@pytest.mark.parametrize("first", ["rack", "pinion"])
def test_rack_and_pinion(first: str, options: Options) -> None:
    # x = 0.3 a: torque 2 N m against 5 N on the rack
    scene = Scene(gravity=(0, 0))
    scene.add_body("frame", "static")
    scene.add_body("wheel", shapes=[Circle(radius=0.3)], mass=1, inertia=0.5, position=(2, 0.3))
    scene.add_body("bar", shapes=[Box(half_extents=(1, 0.1))], mass=2, position=(2, -0.1), angle=0.3)
    scene.add_joint("pinion", Revolute("frame", "wheel"))
    scene.add_joint("rack", Prismatic("frame", "bar", axis=(0.8, 0.6)))
    if first == "rack":
        scene.add_joint("gear", Gear("rack", "pinion", ratio=-0.3))
    else:
        scene.add_joint("gear", Gear("pinion", "rack", ratio=-1 / 0.3))
    world = World(scene, options=options)
    acceleration = (2.0 - 5.0 * 0.3) / (0.5 + 2.0 * 0.3**2)
    for k in range(1, 121):
        world.apply_force("wheel", torque=2.0)
        world.apply_force("bar", force=(-4.0, -3.0))
        world.step()
        assert world.joint_rate("pinion")[0] == pytest.approx(acceleration * k / 60, rel=1e-5)
        assert world.joint_coordinate("rack")[0] == pytest.approx(0.3 * world.joint_coordinate("pinion")[0], abs=1e-6)
    push = world.joint_reaction("rack")[0, :2] @ (0.8, 0.6)
    assert push == pytest.approx(0, abs=1e-3)  # along the axis the gear pushes, not the guide


def test_planetary_train_runs_round() -> None:
    # carrier, sun held still, planet: rolling once round the sun, the planet turns 1 + r_s / r_p times
    scene = Scene(gravity=(0, 0))
    scene.add_body("base", "static")
    scene.add_body("carrier", shapes=[Box(half_extents=(0.5, 0.05))], position=(0.25, 0))
    scene.add_body("sun", shapes=[Circle(radius=0.3)])
    scene.add_body("planet", shapes=[Circle(radius=0.2)], position=(0.5, 0))
    scene.add_joint("main", Revolute("base", "carrier", anchor=(0, 0), motor_speed=2.0, motor_effort=50.0))
    scene.add_joint("sun_axle", Revolute("carrier", "sun"))
    scene.add_joint("planet_axle", Revolute("carrier", "planet"))
    scene.add_joint("mesh", Gear("sun_axle", "planet_axle", ratio=0.2 / 0.3))
    scene.add_joint("brake", Revolute("base", "sun", motor_effort=1e3))
    world = World(scene, options=FINE)
    world.step(240)
    assert world.joint_rate("main")[0] == pytest.approx(2, rel=1e-4)
    assert world.angular_velocity[0, 2] == pytest.approx(0, abs=1e-4)
    assert world.angular_velocity[0, 3] == pytest.approx(2 * (1 + 0.3 / 0.2), rel=1e-3)
    assert world.joint_coordinate("mesh")[0] == pytest.approx(0, abs=1e-5)


def test_gear_from_its_initial_pose() -> None:
    # the sum of coordinates that it keeps is that of the initial pose, also with axes apart
    scene = Scene(gravity=(0, 0))
    scene.add_body("frame", "static")
    for name, y in (("low", 0.0), ("high", 2.0)):
        scene.add_body(name, shapes=[Box(half_extents=(0.2, 0.2))], position=(1, y), angle=0.4)
        scene.add_joint(f"slide_{name}", Prismatic("frame", name, anchor_a=(0.25, y), anchor_b=(0, 0), axis=(1, 0)))
    scene.add_joint("gear", Gear("slide_low", "slide_high", ratio=2.0))
    world = World(scene, options=AWAKE)
    world.step(30)
    np.testing.assert_allclose(world.position[0, 1:, 0], 1.0, atol=1e-12)
    world.set_velocity("low", linear=(1.0, 0))
    world.step(60)
    moved = world.position[0, 1:, 0] - 1.0
    assert moved[0] == pytest.approx(-2.0 * moved[1], rel=1e-6)
    assert moved[0] > 0.1


def bench() -> Scene:
    scene = Scene()
    scene.add_body("base", "static")
    for name, x in (("arm", 0.0), ("p", 1.0), ("q", 2.0), ("r", 2.0)):
        scene.add_body(name, shapes=[Circle(radius=0.2)], position=(x, 0))
    scene.add_joint("shoulder", Revolute("base", "arm"))
    scene.add_joint("p_on_arm", Revolute("arm", "p"))
    scene.add_joint("q_on_base", Revolute("base", "q"))
    scene.add_joint("q_on_arm", Revolute("arm", "q"))
    scene.add_joint("r_on_arm", Revolute("arm", "r"))
    scene.add_joint("glue", Weld("arm", "r"))
    return scene


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"joint_a": None, "joint_b": "p_on_arm"}, "joint_a is missing"),
        ({"joint_a": "p_on_arm", "joint_b": "p_on_arm"}, "couples two different joints, got 'p_on_arm' twice"),
        ({"joint_a": "p_on_arm", "joint_b": "glue"}, "'glue' is a weld"),
        ({"joint_a": "p_on_arm", "offset": np.inf}, "offset must be finite"),
        ({"joint_a": "p_on_arm", "joint_b": "q_on_arm", "ratio": 0.0}, "ratio must not be 0"),
        ({"joint_a": "p_on_arm", "joint_b": "q_on_arm", "ratio": np.nan}, "ratio must be finite"),
        ({"joint_a": "p_on_arm", "joint_b": "elbow"}, "joint 'elbow' is unknown"),
    ],
)
def test_refusals(given: dict[str, Any], message: str) -> None:
    scene = bench()
    with pytest.raises(ValueError, match=f"joint 'gear'.*{message}"):
        scene.add_joint("gear", Gear(**given))
    assert "gear" not in scene.joints


def hand(second: str = "slides", worlds: int = 1, threads: int = 1, **options: Any) -> World:
    """A free hand that a motor of 3 N opens: the left finger slides, and the right one slides or turns with it."""
    scene = Scene(gravity=(0, 0))
    for name, x, mass in (("hand", 0.0, 1.0), ("left", -0.1, 0.3), ("right", 0.1, 0.1)):
        scene.add_body(name, position=(x, 0), mass=mass, inertia=1e6 if name == "hand" else 0.01)
    scene.add_joint("l", Prismatic("hand", "left", axis=(-1, 0), anchor=(-0.1, 0), motor_speed=100, motor_effort=3.0))
    if second == "slides":
        scene.add_joint("r", Prismatic("hand", "right", axis=(1, 0), anchor=(0.1, 0)))
    else:
        scene.add_joint("r", Revolute("hand", "right", anchor=(0.1, 0)))
    scene.add_joint("gear", Gear("l", "r", ratio=-1.0 if second == "slides" else -0.1))
    return World(scene, worlds, threads=threads, options=Options(timestep=1 / 240, sleep=False, **options))


WAYS: dict[str, dict[str, Any]] = {
    "joint coordinates": {},
    "rows": {"articulated": False},
    "pgs": {"articulated": False, "solver": "pgs", "sweeps": 200},
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("second", ["slides", "turns"])
def test_fingers_of_a_free_hand(second: str, way: str) -> None:
    """T = (M x'^2 + m_l (x' - q')^2 + m_r (x' + q')^2) / 2 where both slide; Lagrange's equations give x and q."""
    world = hand(second, **WAYS[way])
    for _ in range(24):
        world.step()
        assert world.diagnostics().unconverged[0] == 0
        assert np.abs(world.diagnostics().momentum).max() < 1e-10
    own = 0.1 if second == "slides" else 0.0  # mass of the right finger that moves along the hand
    spin = 0.0 if second == "slides" else 0.01 * 10.0**2
    masses = np.array([[1.4, own - 0.3], [own - 0.3, 0.3 + own + spin]])
    x, q = np.linalg.solve(masses, [0.0, 3.0]) * 0.1**2 / 2
    near = 1e-6 if way == "joint coordinates" else 2e-5  # sweeps end at a residual of 1e-5
    assert world.position[0, 0, 0] == pytest.approx(x, rel=near)
    assert world.joint_coordinate("l")[0] == pytest.approx(q, rel=near)
    assert world.joint_coordinate("r")[0] == pytest.approx(q if second == "slides" else 10.0 * q, rel=near)
    assert world.joint_coordinate("gear")[0] == pytest.approx(0.0, abs=1e-6)


def test_a_gear_of_a_hand_closes_where_it_was_opened() -> None:
    world = hand()
    world.set_motor("l", speed=0.0)
    world.set_joint("r", coordinate=0.02)
    assert world.diagnostics().joint_error[0] == pytest.approx(0.02)
    world.step(30)
    assert world.diagnostics().joint_error[0] < 1e-6
    assert world.joint_coordinate("l")[0] == pytest.approx(world.joint_coordinate("r")[0], abs=1e-6)


def test_a_hand_continues_bit_for_bit() -> None:
    world = hand()
    world.step(10)
    snapshot = world.save()
    world.step(10)
    after = world.state.bodies.tobytes()
    world.restore(snapshot)
    world.step(10)
    assert world.state.bodies.tobytes() == after


def test_hands_of_a_batch_equal_single_ones() -> None:
    efforts = [1.0, 3.0, 5.0]
    batch = hand(worlds=3, threads=2)
    batch.parameters.set("l", motor_effort=efforts)
    batch.step(20)
    for w, effort in enumerate(efforts):
        world = hand()
        world.parameters.set("l", motor_effort=effort)
        world.step(20)
        assert world.state.bodies[0].tobytes() == batch.state.bodies[w].tobytes()


@pytest.mark.parametrize("way", ["joint coordinates", "rows"])
def test_a_hand_grips_a_bouncing_box(way: str) -> None:
    """Both fingers meet a box that one motor alone drives them to; restitution puts the hand into body space."""
    scene = Scene(gravity=(0, 0))
    scene.add_body("hand", position=(0, 1), shapes=[Box(half_extents=(0.2, 0.03), mask=0)])
    for name, x in (("left", -0.15), ("right", 0.15)):
        scene.add_body(name, position=(x, 0.9), shapes=[Box(half_extents=(0.01, 0.1), density=500)])
    scene.add_body("box", position=(0.01, 0.85), shapes=[Box(half_extents=(0.03, 0.03), restitution=0.5)])
    scene.add_joint("l", Prismatic("hand", "left", axis=(1, 0), motor_speed=0.3, motor_effort=20.0))
    scene.add_joint("r", Prismatic("hand", "right", axis=(-1, 0)))
    scene.add_joint("gear", Gear("l", "r", ratio=-1.0))
    world = World(scene, options=Options(timestep=1 / 240, sleep=False, **WAYS[way]))
    worst = 0.0
    for _ in range(240):
        world.step()
        worst = max(worst, world.diagnostics().joint_error[0])
        assert np.abs(world.diagnostics().momentum).max() < 1e-6
    assert worst < 1e-3
    assert world.joint_coordinate("l")[0] == pytest.approx(0.11, abs=1e-3)
    assert world.joint_coordinate("r")[0] == pytest.approx(0.11, abs=1e-3)
    assert np.abs(world.linear_velocity[0] - world.linear_velocity[0, 0]).max() < 1e-3
    assert world.diagnostics().penetration[0] < 1e-3


def test_a_disabled_joint_idles_its_gear() -> None:
    world = hand()
    world.parameters.set("r", enabled=False)
    world.step(24)
    assert world.joint_coordinate("l")[0] == pytest.approx(3.0 / (1.0 * 0.3 / 1.3) * 0.1**2 / 2, rel=1e-6)
    np.testing.assert_array_equal(world.linear_velocity[0, 2], 0.0)


def test_a_brake_keeps_a_joint_and_its_offset() -> None:
    scene = Scene()
    scene.add_body("base", "static")
    scene.add_body("arm", position=(1, 0), mass=1.0, inertia=0.1)
    scene.add_joint("pin", Revolute("base", "arm", anchor=(0, 0)))
    scene.add_joint("brake", Gear("pin", offset=0.1))
    world = World(scene, options=AWAKE)
    world.step(60)
    assert world.joint_coordinate("pin")[0] == pytest.approx(0.1, abs=1e-6)
    world.parameters.set("brake", enabled=False)
    world.step(30)
    assert world.joint_coordinate("pin")[0] < -0.5


@pytest.mark.parametrize("solver", ["soft", "newton"])
def test_solvers_without_such_gears_are_refused(solver: str) -> None:
    with pytest.raises(ValueError, match=rf"the solver {solver} has no gears like joint 'gear', .*\.$"):
        hand(solver=solver)


def test_coaxial_wheels_geared_one_to_one() -> None:
    scene = bench()
    scene.add_joint("clutch", Gear("q_on_arm", "r_on_arm", ratio=-1.0))
    world = World(scene)
    world.step(3)
    assert np.isfinite(world.linear_velocity).all()
    assert np.isfinite(world.angular_velocity).all()
    assert world.diagnostics().joint_error[0] < 1e-6
