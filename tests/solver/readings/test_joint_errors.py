"""Errors of joints relative to their lengths, and what counts as torn, against numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.solver import Scene, World, planar, spatial
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
