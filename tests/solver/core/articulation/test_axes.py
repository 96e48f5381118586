"""Joints of several degrees of freedom in joint coordinates: against MuJoCo, against the rows of joints, snapshots."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from gsenv.mjcf import build_scene, coordinates, set_coordinates
from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Axis, Ball, Box, Hinge, SixAxis, Slider, Universal, Wheel
from tests.mjcf.test_motion import CASES, both
from tests.solver.bits import everything
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_step3d import space

Array = np.ndarray[Any, Any]
G = 9.81


def errors(name: str, rates: tuple[int, ...], seconds: float = 1.0) -> list[float]:
    """Largest differences of a coordinate to MuJoCo's, m or rad, from random velocities and constant controls."""
    ours, theirs = both(name)
    rng = np.random.default_rng(0)
    data = mujoco.MjData(theirs)
    data.qvel[:] = 0.3 * rng.normal(size=theirs.nv)
    data.ctrl[:] = CASES[name] * rng.uniform(-1.0, 1.0, theirs.nu) * theirs.actuator_ctrlrange[:, 1]
    start, speeds = data.qpos.copy(), data.qvel.copy()
    for _ in range(round(seconds / theirs.opt.timestep)):
        mujoco.mj_step(theirs, data)
    assert abs(data.qpos - start).max() > 0.3
    scene, names = build_scene(ours)
    found = []
    for rate in rates:
        world = articulated(scene, timestep=1.0 / rate, substeps=1, max_substeps=1, sleep=False)
        set_coordinates(world, ours, names, start, speeds)
        world.control[0] = data.ctrl
        world.step(round(seconds * rate))
        diagnostics = world.diagnostics()
        assert diagnostics.rows[0] == 0  # torques, springs, dampers and rotors need none
        assert diagnostics.joint_error[0] < 1e-13
        q, v = coordinates(world, ours, names)
        known = ~np.isnan(v[0])
        assert known.sum() >= ours.rate_count - 6
        found.append(float(abs(q[0] - data.qpos).max()))
    return found


FILES = [
    "humanoid.xml", "half_cheetah.xml", "hopper.xml", "walker2d.xml", "inverted_double_pendulum.xml", "reacher.xml",
    "swimmer.xml",
]  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_gymnasiums_robots_move_as_in_mujoco(name: str) -> None:
    coarse, fine = errors(name, (200, 400))
    print(coarse, fine)
    assert coarse < 1e-2
    assert fine < 0.35 * coarse


def machine(seed: int, flipped: bool, gravity: float = G) -> Scene:
    """Boxes in a row on a universal, two six-axis, a wheel and a ball joint, of random directions and springs."""
    rng = np.random.default_rng(seed)

    def sprung() -> Axis:
        return Axis(stiffness=rng.uniform(2.0, 20.0), damping=rng.uniform(0.0, 0.2), armature=rng.uniform(0.0, 0.05))

    scene = space(gravity)
    scene.add_body("hook", "static")
    at = np.zeros(3)
    last = "hook"
    for k, kind in enumerate(("universal", "slides", "steered", "spinning", "turns")):
        anchor = at
        at = at + rng.uniform(-0.3, 0.3, 3) + (0.3, 0.0, 0.0)
        box = Box(half_extents=tuple(rng.uniform(0.05, 0.2, 3).tolist()), mask=0)
        scene.add_body(f"b{k}", shapes=[box], position=at, mass=rng.uniform(0.5, 2.0))
        turn = rng.normal(size=4)
        turn /= np.linalg.norm(turn)
        one = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pair: dict[str, Any] = {"anchor": 0.5 * (anchor + at), "body_a": last, "body_b": f"b{k}"}
        if flipped == (k % 2 == 0):
            pair |= {"body_a": f"b{k}", "body_b": last}
        joint: Any = None
        if kind == "universal":
            joint = Universal(**pair, axis_a=one[0], axis_b=one[1], turn_a=sprung(), turn_b=sprung())
        elif kind == "slides":
            free: dict[str, Any] = {"x": sprung(), "z": sprung(), "turn_y": sprung()}
            joint = SixAxis(**pair, orientation=turn, **free)
        elif kind == "steered":
            joint = Wheel(
                **pair, axis=one[0], spin_axis=one[1], steering=sprung(), stiffness=60.0, damping=1.0, armature=0.02,
                motor_speed=3.0, motor_effort=0.1,
            )  # fmt: skip
        elif kind == "spinning":
            joint = Wheel(**pair, axis=one[0], spin_axis=one[1], stiffness=60.0, damping=1.0)
        else:
            joint = SixAxis(**pair, orientation=turn, turn_x=sprung(), turn_y=sprung(), turn_z=sprung())
        scene.add_joint(kind, joint)
        last = f"b{k}"
    return scene


COORDINATES = (
    "universal/turn_a", "universal/turn_b", "slides/x", "slides/z", "slides/turn_y", "steered", "steered/spin",
    "steered/steering", "spinning", "spinning/spin", "turns/turn_x", "turns/turn_y", "turns/turn_z",
)  # fmt: skip
MAINS = ("universal", "slides", "steered", "spinning", "turns")


def readings(on: bool, seed: int, flipped: bool, rate: int) -> dict[str, Array]:
    options = Options(timestep=1.0 / rate, substeps=1, max_substeps=1, sleep=False, articulated=on)
    world = World(machine(seed, flipped), options=options)
    world.step(rate // 4)
    assert world.diagnostics().rows[0] == 1 if on else world.diagnostics().rows[0] > 20
    return {
        "coordinate": np.array([world.joint_coordinate(name)[0] for name in COORDINATES]),
        "rate": np.array([world.joint_rate(name)[0] for name in COORDINATES]),
        "reaction": np.array([world.joint_reaction(name)[0] for name in MAINS]),
        "impulse": rate * world.state.joints["impulse"][0],
        "angle": world.state.joints["angle"][0],
    }


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("seed", range(2))
def test_a_machine_moves_as_by_rows(seed: int, flipped: bool) -> None:
    """Coordinates, rates, reactions and the impulses from which rows would start."""
    ours = readings(True, seed, flipped, 2000)
    rows = readings(False, seed, flipped, 4000)
    assert abs(ours["coordinate"]).max() > 0.1
    for name in ("coordinate", "rate", "reaction", "angle"):
        scale = 1.0 + abs(rows[name]).max()
        assert_allclose(ours[name], rows[name], atol=2e-3 * scale, err_msg=name)
    servos = slice(6, None)
    scale = 1.0 + abs(rows["impulse"]).max()
    assert_allclose(ours["impulse"][:, servos], rows["impulse"][:, servos], atol=5e-3 * scale)


def test_energy_of_a_machine_is_kept() -> None:
    """Without springs and motors, by second order."""
    drifts = []
    for rate in (480, 960):
        scene = space()
        scene.add_body("hook", "static")
        for k in range(3):
            box = Box(half_extents=(0.1, 0.15, 0.2), mask=0)
            scene.add_body(f"b{k}", shapes=[box], position=(0.4 * k + 0.2, 0.1, 0.0), mass=1.0 + k)
        free: dict[str, Any] = {word: Axis() for word in ("turn_x", "turn_y", "turn_z")}
        scene.add_joint("one", SixAxis("hook", "b0", anchor=(0.0, 0.0, 0.0), **free))
        scene.add_joint(
            "two", Universal("b1", "b0", axis_a=(1.0, 0.0, 0.0), axis_b=(0.0, 1.0, 0.0), anchor=(0.4, 0, 0))
        )
        scene.add_joint("three", Wheel("b1", "b2", axis=(1.0, 0.0, 0.0), spin_axis=(0.0, 0.0, 1.0), steering=Axis()))
        world = articulated(scene, timestep=1.0 / rate, substeps=1, max_substeps=1, sleep=False)
        start = world.diagnostics().energy[0]
        world.step(rate // 2)
        assert world.diagnostics().rows[0] == 0
        assert np.linalg.norm(world.linear_velocity[0]) > 1.0
        drifts.append(abs(world.diagnostics().energy[0] - start))
    print(drifts)
    assert drifts[0] < 1e-2
    assert drifts[1] < 0.35 * drifts[0]


def dangling(**ball: Any) -> Scene:
    """Two boxes on ball joints below a hook, the upper one sideways."""
    scene = space()
    scene.add_body("hook", "static")
    for k in range(2):
        box = Box(half_extents=(0.05, 0.1, 0.15), mask=0)
        spin = (1.0, 0.5 - k, 2.0)
        scene.add_body(f"b{k}", shapes=[box], position=(0.3 * k + 0.15, 0.0, 0.0), mass=1.0 + k, angular_velocity=spin)
        pair = (f"b{k}", "b0") if k else ("hook", "b0")
        scene.add_joint(f"j{k}", Ball(*pair, anchor=(0.3 * k, 0.0, 0.0), **ball))
    return scene


BALLS: dict[str, dict[str, Any]] = {
    "cone": {"axis": (1.0, 0.0, 0.0), "cone": 0.5, "twist": (-0.3, 0.4)},
    "soft": {"axis": (1.0, 0.0, 0.0), "cone": 0.4, "limit_frequency": 4.0, "limit_damping_ratio": 0.5},
    "sprung": {"stiffness": 3.0, "damping": 0.1},
    "heavy": {"stiffness": 3.0, "damping": 0.1, "armature": 0.02},
    "stiff": {"stiffness": 300.0, "damping": 3.0, "rest": 0.1},
    "bounded": {"stiffness": 3.0, "damping": 0.1, "armature": 0.02, "spring_effort": 100.0},
    "driven": {"motor_speed": 1.0, "motor_effort": 0.5, "friction_effort": 0.1},
}


@pytest.mark.parametrize("name", list(BALLS))
def test_balls_with_limits_and_drives_move_as_by_rows(name: str) -> None:
    found = []
    for on in (True, False):
        options = Options(timestep=2.5e-4, substeps=1, max_substeps=1, sleep=False, articulated=on)
        world = World(dangling(**BALLS[name]), options=options)
        world.step(2000)
        found.append(world)
    ours, rows = found
    assert ours.diagnostics().rows[0] <= rows.diagnostics().rows[0] - 6
    assert_allclose(ours.position, rows.position, atol=2e-3)
    assert_allclose(ours.linear_velocity, rows.linear_velocity, atol=2e-2)
    if name in ("sprung", "stiff"):
        assert ours.diagnostics().rows[0] == 0
        assert_allclose(ours.joint_reaction("j0"), rows.joint_reaction("j0"), rtol=1e-2, atol=0.1)
        impulses = [world.state.joints["impulse"][..., 6:] / world.timestep for world in found]
        assert_allclose(impulses[0], impulses[1], rtol=1e-2, atol=2e-2)
    if name == "cone":
        assert ours.joint_coordinate("j0/swing")[0] < 0.5 + 1e-3
        assert_allclose(max(ours.joint_coordinate(f"j{k}/swing")[0] for k in range(2)), 0.5, atol=1e-2)


def test_rows_and_joint_coordinates_take_turns() -> None:
    """A state of either goes on in the other as if nothing had changed."""
    step: dict[str, Any] = {"timestep": 1.0 / 960, "substeps": 1, "max_substeps": 1, "sleep": False}
    worlds = [World(machine(0, False), options=Options(articulated=on, **step)) for on in (True, False)]
    whole = articulated(machine(0, False), **step)
    whole.step(240)
    for k in range(8):
        worlds[k % 2].step(30)
        worlds[1 - k % 2].restore(worlds[k % 2].save())
    assert_allclose(worlds[0].position, whole.position, atol=1e-3)
    for name in COORDINATES:
        assert_allclose(worlds[0].joint_rate(name), whole.joint_rate(name), atol=2e-2)


def test_worlds_threads_and_snapshots_do_not_matter() -> None:
    one = [articulated(machine(0, True)) for _ in range(3)]
    batch = World(machine(0, True), 3, 2, options=Options(articulated=True))
    for w, world in enumerate(one):
        for target in (world, batch):
            target.parameters.set("turns/turn_x", armature=0.1 * w, worlds=None if target is world else w)
    for world in [*one, batch]:
        world.step(20)
    saved = one[0].save()
    for world in [*one, batch]:
        world.step(20)
    for w, world in enumerate(one):
        assert_array_equal(batch.state.bodies[w], world.state.bodies[0])
    assert abs(batch.position[0] - batch.position[2]).max() > 1e-6
    again = articulated(machine(0, True))
    again.restore(saved)
    again.step(20)
    assert everything(again) == everything(one[0])


@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
@pytest.mark.parametrize("flipped", [False, True])
def test_limits_bounce_by_newtons_law(restitution: float, flipped: bool) -> None:
    scene = space(0.0)
    scene.add_body("hook", "static")
    limits: dict[str, Any] = {"limits": (-0.5, 0.1), "limit_restitution": restitution}
    joints: Any = {"hinge": Hinge, "slider": Slider}
    for k, kind in enumerate(joints):
        box = Box(half_extents=(0.1, 0.1, 0.1), mask=0)
        motion: dict[str, Any] = {"linear_velocity" if k else "angular_velocity": (0.0, 0.0, 2.0)}
        sign = -1.0 if flipped else 1.0
        scene.add_body(kind, shapes=[box], position=(0.0, 3.0 * k, 0.0), **motion)
        pair = (kind, "hook") if flipped else ("hook", kind)
        scene.add_joint(f"{kind} joint", joints[kind](*pair, axis=(0.0, 0.0, sign), **limits))
    world = articulated(scene, sleep=False)
    world.step(12)
    for kind in joints:
        assert_allclose(world.joint_rate(f"{kind} joint"), -2.0 * restitution, atol=1e-9)
        assert world.joint_coordinate(f"{kind} joint")[0] < 0.1 + 1e-3


def test_soft_limits_swing_back_at_their_frequency() -> None:
    scene = space(0.0)
    scene.add_body("hook", "static")
    scene.add_body("disc", shapes=[Box(half_extents=(0.1, 0.1, 0.1), mask=0)], angular_velocity=(0.0, 0.0, 1.0))
    soft: dict[str, Any] = {"limits": (-5.0, 0.0), "limit_frequency": 2.0, "limit_damping_ratio": 0.0}
    scene.add_joint("joint", Hinge("hook", "disc", axis=(0.0, 0.0, 1.0), **soft))
    world = articulated(scene, timestep=1e-3, substeps=1, sleep=False)
    world.step(125)  # half of the time in the limit
    assert_allclose(world.joint_coordinate("joint"), 1.0 / (4.0 * np.pi), rtol=1e-2)
    world.step(225)
    assert_allclose(world.joint_rate("joint"), -1.0, rtol=1e-2)
    assert_allclose(world.joint_coordinate("joint"), -0.1, atol=2e-3)
