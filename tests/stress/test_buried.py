"""The vertical depth of bodies under uneven ground, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from gsenv.solver import Scene, planar, spatial
from tests.stress.buried import buried, height_at

SLOPE = 1.5


def plane_field(scene: Scene) -> None:
    """The ground z = 1.5 x + 0.2, on a body at (1, 0, 0.2)."""
    heights = [[-5.0 * SLOPE, 5.0 * SLOPE]] * 2
    field = spatial.Heightfield(heights=np.array(heights) + SLOPE, size=(10.0, 10.0))
    scene.add_body("field", "static", [field], position=(1.0, 0.0, 0.2))


def test_a_sphere_under_a_slope() -> None:
    scene = Scene(dim=3)
    plane_field(scene)
    scene.add_body("sphere", shapes=[spatial.Sphere(radius=0.5)], position=(0.4, 1.0, 0.3))
    wanted = 0.5 * math.hypot(1.0, SLOPE) + SLOPE * 0.4 + 0.2 - 0.3
    assert buried(scene) == pytest.approx([0.0, wanted], rel=1e-2)


def test_a_turned_box_under_a_slope_and_above_it() -> None:
    turn = (math.cos(0.3), 0.0, math.sin(0.3), 0.0)  # by 0.6 rad about y
    scene = Scene(dim=3)
    plane_field(scene)
    box = spatial.Box(half_extents=(0.3, 0.2, 0.1))
    scene.add_body("low", shapes=[box], position=(0.0, 0.0, 0.0), orientation=turn)
    scene.add_body("high", shapes=[box], position=(0.0, 0.0, 5.0), orientation=turn)
    scene.add_body("beside", shapes=[box], position=(20.0, 0.0, -5.0), orientation=turn)
    c, s = math.cos(0.6), math.sin(0.6)
    corners = [(c * x + s * z, -s * x + c * z) for x in (-0.3, 0.3) for z in (-0.1, 0.1)]
    wanted = max(SLOPE * x + 0.2 - z for x, z in corners)
    assert buried(scene) == pytest.approx([0.0, wanted, 0.0, 0.0], rel=1e-12)


def test_both_triangles_of_a_cell() -> None:
    """A cell whose two triangles meet along the diagonal from low to high x and y, which is level."""
    field = spatial.Heightfield(heights=np.array([[0.0, 3.0], [3.0, 0.0]]), size=(2.0, 2.0))
    points = np.array([(0.5, -0.5, 0.0), (-0.5, 0.5, 0.0), (0.3, 0.3, 0.0), (1.5, 0.0, 0.0)])
    assert height_at(field, points) == pytest.approx([1.5, 1.5, 0.0, -np.inf], abs=1e-12)


def test_no_deeper_than_a_contact_can_be() -> None:
    """A body far behind a surface is raised by no more than its width along the steepest slope."""
    scene = Scene(dim=3)
    plane_field(scene)
    scene.add_body("deep", shapes=[spatial.Sphere(radius=0.1)], position=(0.0, 0.0, -3.0))
    assert buried(scene)[1] == pytest.approx(0.2 * math.hypot(1.0, SLOPE), rel=1e-2)


def test_a_disc_in_a_valley_and_a_capsule_under_terrain() -> None:
    scene = Scene()
    valley = planar.Terrain(vertices=[(-4.0, 4.0 * SLOPE), (0.0, 0.0), (4.0, 4.0 * SLOPE)])
    scene.add_body("valley", "static", [valley])
    scene.add_body("disc", shapes=[planar.Circle(radius=0.5)], position=(0.0, 0.1))
    capsule = planar.Capsule(half_length=0.4, radius=0.1)
    scene.add_body("capsule", shapes=[capsule], position=(2.0, 2.0), angle=0.5 * math.pi)
    up = math.hypot(1.0, SLOPE)
    assert buried(scene) == pytest.approx([0.0, 0.5 * up - 0.1, 0.1 * up + 2.0 * SLOPE - 1.6], rel=1e-2)
