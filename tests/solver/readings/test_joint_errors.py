"""Errors of joints relative to their lengths, and what counts as torn, against numbers by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from gsenv.solver.records.model import Array

BOTH = pytest.mark.parametrize("dim", [2, 3])


def ball(dim: int, radius: float) -> planar.Shape | spatial.Shape:
    return planar.Circle(radius=radius) if dim == 2 else spatial.Sphere(radius=radius)


def place(dim: int, x: float) -> Array:
    return x * np.eye(dim)[0]


def pair(dim: int, kind: str) -> World:
    """A static body and a ball of radius 0.1 m at x = 2 m, joined; and a second joint that holds."""
    joints = planar if dim == 2 else spatial
    here = (0.0,) * dim
    scene = Scene(dim=dim, gravity=here)
    scene.add_body("wall", "static", position=here)
    scene.add_body("ball", shapes=[ball(dim, 0.1)], position=place(dim, 2.0))
    scene.add_body("other", shapes=[ball(dim, 0.1)], position=place(dim, -2.0))
    scene.add_joint("holds", joints.Distance("wall", "other"))
    if kind == "rod":
        scene.add_joint("it", joints.Distance("wall", "ball"))
    elif kind == "rope":
        scene.add_joint("it", joints.Distance("wall", "ball", limits=(0.0, 2.5)))
    elif dim == 2:
        scene.add_joint("it", planar.Revolute("wall", "ball", anchor=place(dim, 2.0)))
    else:
        scene.add_joint("it", spatial.Ball("wall", "ball", anchor=place(dim, 2.0)))
    return World(scene)


@BOTH
@pytest.mark.parametrize(
    ("kind", "x", "error", "length"),
    [("rod", 2.03, 0.03, 2.0), ("rod", 1.9, 0.1, 2.0), ("rope", 2.4, 0.0, 2.5), ("rope", 2.6, 0.1, 2.5),
     ("point", 2.001, 0.001, 0.2), ("point", 2.01, 0.01, 0.2)],
)  # fmt: skip
def test_relative_error_of_a_body_that_was_put_elsewhere(
    dim: int, kind: str, x: float, error: float, length: float
) -> None:
    world = pair(dim, kind)
    world.set_pose("ball", position=place(dim, x))
    d = world.diagnostics()
    assert d.joint_error[0] == pytest.approx(error, abs=1e-12)
    assert d.relative_joint_error[0] == pytest.approx(error / length, abs=1e-12)
    assert d.unconverged[0] == (1 if error > 0.01 * length else 0)


def tilted(dim: int, angle: float) -> dict[str, object]:
    """The pose of a body that is rotated in the plane, in 3D about y, across all axes used here."""
    if dim == 2:
        return {"angle": angle}
    return {"orientation": (math.cos(0.5 * angle), 0.0, math.sin(0.5 * angle), 0.0)}


def locked(dim: int, kind: str) -> World:
    """A static body and a ball of radius 0.1 m whose rotations a joint locks, in 3D at least those about y."""
    here = (0.0,) * dim
    scene = Scene(dim=dim, gravity=here)
    scene.add_body("wall", "static", position=here)
    scene.add_body("ball", shapes=[ball(dim, 0.1)], position=here)
    x = place(dim, 1.0)
    if dim == 2:
        joint: planar.Weld | planar.Prismatic = planar.Weld("wall", "ball")
        if kind == "slider":
            joint = planar.Prismatic("wall", "ball", axis=x)
        scene.add_joint("it", joint)
    elif kind == "hinge":
        scene.add_joint("it", spatial.Hinge("wall", "ball", axis=x))
    else:
        scene.add_joint(
            "it", spatial.Slider("wall", "ball", axis=x) if kind == "slider" else spatial.Weld("wall", "ball")
        )
    return World(scene)


@pytest.mark.parametrize(("dim", "kind"), [(2, "weld"), (2, "slider"), (3, "weld"), (3, "slider"), (3, "hinge")])
@pytest.mark.parametrize("angle", [0.0, 0.015, -0.015, 0.03, 3.0])
def test_angle_of_a_body_that_was_rotated_against_its_joint(dim: int, kind: str, angle: float) -> None:
    world = locked(dim, kind)
    world.set_pose("ball", **tilted(dim, angle))
    d = world.diagnostics()
    assert d.angular_joint_error[0] == pytest.approx(abs(angle), abs=1e-9)
    assert d.relative_joint_error[0] == pytest.approx(0.5 * abs(angle), abs=1e-9)
    assert d.unconverged[0] == (1 if abs(angle) > 0.02 else 0)


@BOTH
def test_soft_weld_and_free_rotations_have_no_angle(dim: int) -> None:
    joints = planar if dim == 2 else spatial
    here = (0.0,) * dim
    scene = Scene(dim=dim, gravity=here)
    scene.add_body("wall", "static", position=here)
    scene.add_body("soft", shapes=[ball(dim, 0.1)], position=here)
    scene.add_body("free", shapes=[ball(dim, 0.1)], position=place(dim, 2.0))
    scene.add_joint("spring", joints.Weld("wall", "soft", frequency=2.0))
    y = (0.0, 1.0, 0.0)
    scene.add_joint("pin", planar.Revolute("wall", "free") if dim == 2 else spatial.Hinge("wall", "free", axis=y))
    world = World(scene)
    world.set_pose("soft", **tilted(dim, 0.5))
    world.set_pose("free", **tilted(dim, 0.5))
    d = world.diagnostics()
    assert d.angular_joint_error[0] == pytest.approx(0.0, abs=1e-12)
    assert d.unconverged[0] == 0


@BOTH
@pytest.mark.parametrize("ratio", [2.0, -3.5])
def test_gears_that_slipped(dim: int, ratio: float) -> None:
    """Of two wheels the error is the angle q_a + ratio q_b, of a rack and a pinion the length x + ratio q."""
    here = (0.0,) * dim
    y = (0.0, 1.0, 0.0)
    scene = Scene(dim=dim, gravity=here)
    scene.add_body("wall", "static", position=here)
    for k, name in enumerate(("first", "second", "rack")):
        scene.add_body(name, shapes=[ball(dim, 0.1)], position=place(dim, 1.0 + k))
    for name in ("first", "second"):
        scene.add_joint(f"q_{name}", planar.Revolute("wall", name) if dim == 2 else spatial.Hinge("wall", name, axis=y))
    slider = planar.Prismatic if dim == 2 else spatial.Slider
    scene.add_joint("x", slider("wall", "rack", axis=place(dim, 1.0)))
    joints = planar if dim == 2 else spatial
    scene.add_joint("wheels", joints.Gear("q_first", "q_second", ratio=ratio))
    scene.add_joint("mesh", joints.Gear("x", "q_second", ratio=0.1))
    world = World(scene)
    world.set_pose("first", **tilted(dim, 0.04))
    world.set_pose("second", **tilted(dim, 0.01))
    d = world.diagnostics()
    assert d.angular_joint_error[0] == pytest.approx(abs(0.04 + ratio * 0.01), abs=1e-12)
    assert d.joint_error[0] == pytest.approx(0.001, abs=1e-12)
    assert d.relative_joint_error[0] == pytest.approx(max(0.5 * abs(0.04 + ratio * 0.01), 0.001 / 0.2), abs=1e-12)
    assert d.unconverged[0] == (1 if ratio > 0.0 else 0)
    world.set_pose("rack", position=place(dim, 3.02))
    assert world.diagnostics().joint_error[0] == pytest.approx(0.021, abs=1e-12)


def test_coordinates_beyond_their_limits_are_errors() -> None:
    """A slide and a turn are set beyond rigid limits, in both dimensions; soft limits may be passed."""
    for dim in (2, 3):
        scene = Scene(dim=dim)
        scene.add_body("base", "static")
        axis: dict[str, Any] = {"axis": (1, 0, 0)[:dim]}
        kinds = (planar.Prismatic, planar.Revolute) if dim == 2 else (spatial.Slider, spatial.Hinge)
        for name, kind in zip(("slide", "turn"), kinds, strict=True):
            inertia = 0.1 if dim == 2 else (0.1, 0.1, 0.1)
            scene.add_body(name, mass=1.0, inertia=inertia, gravity_scale=0.0)
            arguments = {} if kind is planar.Revolute else axis
            scene.add_joint(f"on_{name}", kind("base", name, limits=(-0.2, 0.3), **arguments))
        world = World(scene, options=Options(sleep=False))
        world.set_joint("on_slide", coordinate=0.31)
        world.set_joint("on_turn", coordinate=-0.25)
        readings = world.diagnostics()
        assert readings.joint_error[0] == pytest.approx(0.01, rel=1e-9)
        assert readings.angular_joint_error[0] == pytest.approx(0.05, rel=1e-9)
        world.step(60)
        readings = world.diagnostics()
        assert readings.joint_error[0] < 1e-6
        assert readings.angular_joint_error[0] < 1e-6
        world.parameters.set("on_slide", limit_frequency=3.0)
        world.set_joint("on_slide", coordinate=0.31)
        assert world.diagnostics().joint_error[0] < 1e-6
