"""World.set_joint: coordinates and rates of joints that are set, with all bodies beyond them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.spatial import Axis
from tests.solver.bits import everything
from tests.solver.core.articulation.linkages import add_bar, slider_crank


def chain(flipped: bool = False) -> Scene:
    """Three bars on revolute joints, the last on a prismatic one."""
    scene = Scene()
    scene.add_body("hook", "static")
    for k in range(3):
        add_bar(scene, f"bar_{k}", (float(k), 0.0), (k + 1.0, 0.0))
    pairs = (("hook", "bar_0"), ("bar_0", "bar_1"), ("bar_1", "bar_2"))
    for k, pair in enumerate(pairs):
        ends = pair[::-1] if flipped else pair
        anchor = (float(k), 0.0)
        joint: Any = planar.Revolute(*ends, anchor=anchor)
        if k == 2:
            joint = planar.Prismatic(*ends, axis=(0.6, 0.8), anchor=anchor)
        scene.add_joint(f"joint_{k}", joint)
    return scene


def chain3d(flipped: bool = False) -> Scene:
    """A hinge and a slider in general directions, on a body that moves."""
    scene = Scene(dim=3)
    scene.add_body("hook", "static")
    for k in range(3):
        box = spatial.Box(half_extents=(0.3, 0.1, 0.2), mask=0)
        scene.add_body(f"box_{k}", shapes=[box], position=(float(k), 0.3 * k, 0.0), mass=1.0 + k)
    ends = [("hook", "box_0"), ("box_0", "box_1"), ("box_1", "box_2")]
    ends = [pair[::-1] if flipped else pair for pair in ends]
    scene.add_joint("joint_0", spatial.Hinge(*ends[0], anchor=(0.0, 0.0, 0.5), axis=(0.0, 0.6, 0.8)))
    scene.add_joint("joint_1", spatial.Hinge(*ends[1], anchor=(0.5, 0.2, 0.1), axis=(1.0, 0.0, 0.0)))
    scene.add_joint("joint_2", spatial.Slider(*ends[2], anchor=(1.5, 0.4, 0.0), axis=(0.6, 0.0, 0.8)))
    return scene


@pytest.mark.parametrize("build", [chain, chain3d])
@pytest.mark.parametrize("flipped", [False, True])
def test_only_the_coordinate_that_is_set_changes(build: Any, flipped: bool) -> None:
    world = World(build(flipped), 2)
    wanted = {"joint_0": (0.7, -1.0), "joint_1": (-2.5, 4.0), "joint_2": (0.3, 0.5)}
    for joint, (coordinate, rate) in wanted.items():
        world.set_joint(joint, coordinate=[coordinate, 0.5 * coordinate], rate=[rate, -rate])
    world.set_joint("joint_0", coordinate=1.1, worlds=1)
    for w, (scale, sign) in enumerate(((1.0, 1.0), (0.5, -1.0))):
        for joint, (coordinate, rate) in wanted.items():
            q = 1.1 if (joint, w) == ("joint_0", 1) else scale * coordinate
            assert_allclose(world.joint_coordinate(joint)[w], q, rtol=0.0, atol=1e-13)
            assert_allclose(world.joint_rate(joint)[w], sign * rate, rtol=0.0, atol=1e-13)
    assert world.diagnostics().joint_error.max() < 1e-13


JOINTS: dict[str, tuple[Any, list[str]]] = {
    "universal": (
        lambda *ends: spatial.Universal(
            *ends, anchor=(0.5, 0.1, 0.1), axis_a=(1, 0, 0), axis_b=(0, 0.6, 0.8), turn_a=Axis(), turn_b=Axis()
        ),
        ["turn_a", "turn_b"],
    ),
    "ball": (
        lambda *ends: spatial.Ball(
            *ends, anchor=(0.5, 0.1, 0.1), axis=(0.6, 0, 0.8), cone=2.0, twist=(-1.0, 1.0), frequency=2.0
        ),
        ["swing", "twist"],
    ),
    "wheel": (
        lambda *ends: spatial.Wheel(
            *ends, anchor=(0.5, 0.1, 0.1), axis=(0, 0, 1), spin_axis=(0, 1, 0), frequency=3.0, steering=Axis()
        ),
        ["", "steering", "spin"],
    ),
    "six-axis": (
        lambda *ends: spatial.SixAxis(
            *ends, anchor=(0.5, 0.1, 0.1), x=Axis(), z=Axis(), turn_x=Axis(), turn_y=Axis(), turn_z=Axis()
        ),
        ["x", "z", "turn_x", "turn_y", "turn_z"],
    ),
    "plane wheel": (lambda *ends: planar.Wheel(*ends, anchor=(0.5, 0.1), axis=(0.6, 0.8), frequency=3.0), [""]),
}


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("name", JOINTS)
def test_each_coordinate_of_a_joint_is_set_alone(name: str, flipped: bool) -> None:
    """The bodies have turned and move; then each coordinate and rate is set, and all others stay."""
    make, words = JOINTS[name]
    flat = name == "plane wheel"
    scene = Scene(dim=2 if flat else 3)
    scene.add_body("hook", "static")
    for k, arm in enumerate(("arm", "tip")):
        place, inertia = ((k, 0), 0.1) if flat else ((k, 0.2, 0.1), (0.1, 0.2, 0.15))
        scene.add_body(arm, position=place, mass=1.0, inertia=inertia)
    scene.add_joint("root", (planar.Revolute if flat else spatial.Ball)("hook", "arm"))
    scene.add_joint("j", make(*(("tip", "arm") if flipped else ("arm", "tip"))))
    world = World(scene, options=Options(timestep=1 / 240))
    world.set_velocity("arm", angular=1.0 if flat else (1.0, -2.0, 0.5))
    world.step(24)
    names = [f"j/{word}" if word else "j" for word in words]
    for number, one in enumerate(names):
        before = [(world.joint_coordinate(k)[0], world.joint_rate(k)[0]) for k in names]
        held = world.position[0].copy(), world.linear_velocity[0].copy()
        wanted = 0.4 - 0.1 * number
        world.set_joint(one, coordinate=wanted, rate=wanted - 1.0)
        after = [(world.joint_coordinate(k)[0], world.joint_rate(k)[0]) for k in names]
        before[number] = (wanted, wanted - 1.0)
        assert_allclose(after, before, rtol=0.0, atol=1e-12)
        assert_allclose(world.position[0, :2], held[0][:2], atol=0.0)
        assert_allclose(world.linear_velocity[0, :2], held[1][:2], atol=0.0)
    assert world.diagnostics().joint_error[0] < 1e-12


def test_a_joint_with_several_coordinates_names_them() -> None:
    scene = Scene(dim=3)
    for name in ("a", "b"):
        scene.add_body(name, mass=1.0, inertia=(0.1, 0.1, 0.1))
    scene.add_body("c", mass=1.0, inertia=(0.1, 0.1, 0.1))
    scene.add_joint(
        "cross", spatial.Universal("a", "b", axis_a=(1, 0, 0), axis_b=(0, 1, 0), turn_a=Axis(), turn_b=Axis())
    )
    scene.add_joint("ball", spatial.Ball("b", "c"))
    world = World(scene)
    with pytest.raises(ValueError, match="joint 'cross' has the coordinates 'cross/turn_a', 'cross/turn_b'; name one"):
        world.set_joint("cross", coordinate=0.1)
    with pytest.raises(ValueError, match=r"joint 'ball' is a ball, which has no coordinate that can be set\."):
        world.set_joint("ball", coordinate=0.1)


@pytest.mark.parametrize("build", [chain, chain3d])
@pytest.mark.parametrize("on", [False, True])
def test_a_world_that_was_set_continues_exactly(build: Any, on: bool) -> None:
    worlds = [World(build(), options=Options(articulated=on)) for _ in range(2)]
    worlds[0].step(5)
    worlds[0].set_joint("joint_1", coordinate=0.4, rate=2.0)
    worlds[1].restore(worlds[0].save())
    for world in worlds:
        world.step(5)
    assert everything(worlds[0]) == everything(worlds[1])
    assert abs(worlds[0].joint_coordinate("joint_1")[0] - 0.4 - 2.0 / 12.0) < 0.1
    assert worlds[0].diagnostics().relative_joint_error[0] < 1e-3


def test_bad_input_changes_nothing() -> None:
    scene = chain()
    scene.add_joint("glue", planar.Weld("bar_2", "hook", enabled=False))
    scene.add_joint("off", planar.Revolute("bar_1", "hook", anchor=(0.0, 0.0), enabled=False))
    world = World(scene)
    before = everything(world)
    for joint, given, message in (
        ("glue", {"coordinate": 1.0}, "'glue' is a weld"),
        ("off", {"rate": 1.0}, "'off' is disabled"),
        ("joint_0", {"rate": np.nan}, "rate"),
        ("joint_0", {"coordinate": [1.0, 2.0]}, "coordinate"),
        ("none", {"coordinate": 1.0}, "none"),
    ):
        with pytest.raises(ValueError, match=message):
            world.set_joint(joint, **given)
    assert everything(world) == before
    loop = World(slider_crank())
    with pytest.raises(ValueError, match="in a loop"):
        loop.set_joint("pin", coordinate=1.0)
    closing = sorted(set(range(4)) - set(loop.model.trees["joint"].tolist()))[0]
    with pytest.raises(ValueError, match="closes a loop"):
        loop.set_joint(loop.model.joint_names[closing], rate=1.0)
