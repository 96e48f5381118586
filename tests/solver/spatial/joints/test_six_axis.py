"""Six-axis: any axes locked, limited, sprung or driven; Cardan angles; equal to the joints that it generalises."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver.spatial import Axis, Hinge, SixAxis, Slider, Weld
from tests.solver.spatial.joints.rigs import FINE, INERTIA, MASS, G, held, multiplied, oscillator, quaternion, scene_of

FREE = Axis()
NAMES = ("x", "y", "z", "turn_x", "turn_y", "turn_z")


def six(**given: Any) -> SixAxis:
    return SixAxis("base", "it", anchor=(0, 0, 0), **given)


def value(world: Any, word: str) -> float:
    return float(world.joint_coordinate(f"joint/{word}")[0])


@pytest.mark.parametrize(
    ("general", "special"),
    [
        (six(), Weld("base", "it", anchor=(0, 0, 0))),
        (six(turn_y=FREE), Hinge("base", "it", anchor=(0, 0, 0), axis=(0, 1, 0))),
        (six(x=FREE), Slider("base", "it", anchor=(0, 0, 0), axis=(1, 0, 0))),
    ],
)
def test_moves_as_the_joint_that_it_generalises(general: Any, special: Any) -> None:
    motion: dict[str, Any] = {
        "position": (0.3, 0.1, 0),
        "angular_velocity": (0.2, 1.0, 0.4),
        "linear_velocity": (0.5, 0, 0),
    }
    one, other = (held(joint, G, options=FINE, **motion) for joint in (general, special))
    for _ in range(60):
        one.step()
        other.step()
        assert_allclose(one.position, other.position, atol=1e-5)
        assert_allclose(abs((one.orientation * other.orientation).sum(-1)), 1.0, atol=1e-9)
        assert_allclose(one.joint_reaction("joint"), other.joint_reaction("joint"), atol=0.05 * MASS * G)


@pytest.mark.parametrize("word", NAMES)
def test_each_axis_swings_on_its_spring(word: str) -> None:
    """About the centre, each of the six is an oscillator of its own; the others are locked."""
    f, ratio, rest = 1.5, 0.1, 0.3
    world = held(six(**{word: Axis(frequency=f, damping_ratio=ratio, rest=rest)}), options=FINE)
    for k in range(1, 121):
        world.step()
        wave = oscillator(np.array([k / 240.0]), -rest, 0.0, 2.0 * math.pi * f, ratio)[0]
        assert value(world, word) == pytest.approx(rest + wave, abs=2e-3)


@pytest.mark.parametrize("word", NAMES)
def test_each_axis_has_its_motor_and_its_limits(word: str) -> None:
    axis = Axis(limits=(-0.2, 0.3), motor_speed=1.0, motor_effort=500.0)
    world = held(six(**{word: axis}), orientation=(1, 0.3, -0.2, 0.4))
    world.step(12)
    assert value(world, word) == pytest.approx(0.2, abs=0.02)
    assert world.joint_rate(f"joint/{word}")[0] == pytest.approx(1.0, rel=5e-3)
    world.step(30)
    assert value(world, word) == pytest.approx(0.3, abs=1e-3)
    world.set_motor(f"joint/{word}", speed=-1.0)
    world.step(60)
    assert value(world, word) == pytest.approx(-0.2, abs=1e-3)


@pytest.mark.parametrize("free", ["xyz", "xz", "xy", "yz"])
def test_rotations_are_cardan_angles(free: str) -> None:
    """Poses made of successive rotations read back as their angles, over more than half a turn."""
    world = held(six(**{f"turn_{letter}": FREE for letter in free}))
    angles = dict(zip("xyz", (1.1, -0.6, 2.0), strict=True))
    locked = set("xyz") - set(free)
    order = "xyz" if not locked else {"x": "zxy", "y": "xyz", "z": "yzx"}[locked.pop()]
    turn = np.array((1.0, 0, 0, 0))
    for letter in order:
        if letter in free:
            turn = multiplied(turn, quaternion(np.eye(3)["xyz".index(letter)], angles[letter]))
    world.set_pose("it", orientation=turn)
    for letter in free:
        assert value(world, f"turn_{letter}") == pytest.approx(angles[letter], abs=1e-12)


def test_all_free_but_springs_is_a_body_on_six_springs() -> None:
    stiffness = dict(zip(NAMES, (50.0, 80.0, 30.0, 4.0, 6.0, 5.0), strict=True))
    world = held(six(**{word: Axis(stiffness=k, damping=0.1 * k) for word, k in stiffness.items()}), G)
    world.apply_force("it", torque=(0.1, 0, 0))
    world.step(900)
    assert value(world, "z") == pytest.approx(-MASS * G / 30.0, rel=1e-4)
    for word in ("x", "y", "turn_x", "turn_y", "turn_z"):
        assert value(world, word) == pytest.approx(0.0, abs=1e-4)
    assert world.diagnostics().spring_energy[0] == pytest.approx(0.5 * 30.0 * (MASS * G / 30.0) ** 2, rel=1e-3)
    assert_allclose(world.joint_reaction("joint")[0, :3], (0, 0, MASS * G), rtol=1e-3, atol=1e-3)


def test_torque_on_an_axis_turns_about_it() -> None:
    joint = six(turn_x=FREE, turn_y=Axis(motor_effort=5.0), turn_z=FREE)
    world = held(joint, actuator={"joint": "joint/turn_y", "mode": "torque"})
    world.control[:] = 0.4
    world.step(30)
    assert world.joint_rate("joint/turn_y")[0] == pytest.approx(0.4 * 0.5 / INERTIA[1], rel=1e-5)


def test_disabling_the_joint_disables_its_axes() -> None:
    world = held(six(z=Axis(stiffness=1e3, damping=10.0)), G)
    world.parameters.set("joint", enabled=False)
    world.step(30)
    assert world.position[0, 1, 2] == pytest.approx(-0.5 * G * 0.25, rel=1e-6)


def test_bad_arguments_are_named() -> None:
    with pytest.raises(ValueError, match="joint 'joint/turn_x' must be an Axis"):
        scene_of(six(turn_x=1.0))
    with pytest.raises(ValueError, match="joint 'joint/x': the lower limit must not be above the upper one"):
        scene_of(six(x=Axis(limits=(1, 0))))
    with pytest.raises(ValueError, match="all of its axes are free"):
        scene_of(six(**dict.fromkeys(NAMES, FREE)))
    with pytest.raises(ValueError, match=r"joint 'joint/turn_y': limits of the second rotation must be within"):
        scene_of(six(turn_x=FREE, turn_y=Axis(limits=(-2, 2)), turn_z=FREE))
    scene = scene_of(six(x=FREE))
    with pytest.raises(ValueError, match="joint 'joint' exists already"):
        scene.add_joint("joint", six())
