"""What of the step kernel a scene needs."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, planar, spatial
from gsenv.solver.records.kernel_variants import (
    ONE_KERNEL,
    OWN_KERNELS,
    KernelVariant,
    choose_variant,
    general_variant,
    kernel_variant_of,
)
from gsenv.solver.records.scratch import Scratch

TRIANGLE = [(0, 0), (1, 0), (0, 1)]
TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]


def plain(dim: int) -> Scene:
    """A ball and a box on level ground."""
    scene = Scene(dim=dim)
    shapes: tuple[Any, ...] = (planar.HalfPlane(), planar.Circle(radius=0.5), planar.Box(half_extents=(1, 1)))
    if dim == 3:
        shapes = (spatial.Plane(), spatial.Sphere(radius=0.5), spatial.Box(half_extents=(1, 1, 1)))
    scene.add_body("ground", "static", shapes=[shapes[0]])
    scene.add_body("ball", shapes=[shapes[1]])
    scene.add_body("box", shapes=[shapes[2]])
    return scene


def add_shape(shape: Any) -> Callable[[Scene], Any]:
    return lambda scene: scene.add_body("new", shapes=[shape])


def add_joint(joint: Any) -> Callable[[Scene], Any]:
    return lambda scene: scene.add_joint("new", joint)


FLAT = spatial.Heightfield(heights=np.zeros((2, 2)), size=(1, 1))
NEEDS: list[tuple[int, str, Callable[[Scene], Any], set[str]]] = [
    (2, "nothing", lambda scene: None, set()),
    (2, "capsule", add_shape(planar.Capsule(half_length=1, radius=0.5)), set()),
    (2, "polygon", add_shape(planar.Polygon(vertices=TRIANGLE)), {"vertices"}),
    (2, "weld", add_joint(planar.Weld("ball", "box")), {"joints"}),
    (2, "revolute", add_joint(planar.Revolute("ball", "box")), {"joints", "linked"}),
    (2, "continuous", lambda scene: scene.add_body("new", mass=1, inertia=1, continuous=True), {"continuous"}),
    (3, "nothing", lambda scene: None, set()),
    (3, "capsule", add_shape(spatial.Capsule(half_length=1, radius=0.5)), set()),
    (3, "cylinder", add_shape(spatial.Cylinder(half_length=1, radius=0.5)), {"convex"}),
    (3, "hull", add_shape(spatial.Hull(vertices=TETRAHEDRON)), {"convex", "vertices"}),
    (3, "heightfield", lambda scene: scene.add_body("new", "static", shapes=[FLAT]), {"fields", "vertices"}),
    (3, "weld", add_joint(spatial.Weld("ball", "box")), {"joints"}),
    (3, "ball joint", add_joint(spatial.Ball("ball", "box")), {"joints", "linked"}),
    (3, "cone", add_joint(spatial.Ball("ball", "box", axis=(0, 0, 1), cone=1)), {"joints", "linked", "axes"}),
    (3, "hinge", add_joint(spatial.Hinge("ball", "box", axis=(0, 0, 1))), {"joints", "linked", "axes"}),
]


@pytest.mark.parametrize(
    ("dim", "add", "needed"), [(n[0], *n[2:]) for n in NEEDS], ids=[f"{n[0]}D {n[1]}" for n in NEEDS]
)
def test_features_of_a_scene(
    monkeypatch: pytest.MonkeyPatch, dim: int, add: Callable[[Scene], Any], needed: set[str]
) -> None:
    monkeypatch.delenv(ONE_KERNEL, raising=False)
    scene = plain(dim)
    add(scene)
    variant = kernel_variant_of(scene.compile())
    assert {name for name in KernelVariant._fields if getattr(variant, name)} == needed


@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_one_kernel_for_scenes_that_differ_in_everything(monkeypatch: pytest.MonkeyPatch, dim: int) -> None:
    """Buffers of a scene of three shapes and of one with hundreds, joints in trees and a rope are of the same types."""
    few, many = plain(dim), plain(dim)
    kinds_of: Any = (planar.Revolute, planar.Distance) if dim == 2 else (spatial.Ball, spatial.Distance)
    many.add_joint("joint", kinds_of[0]("ball", "box"))
    many.add_joint("rope", kinds_of[1]("ground", "box", length=2.0))
    for k in range(300):
        many.add_body(f"pebble_{k}", shapes=[planar.Circle(radius=1) if dim == 2 else spatial.Sphere(radius=1)])

    def kinds() -> list[Any]:
        models = [scene.compile() for scene in (few, many)]
        scratches = [Scratch(model, kernel_variant_of(model), 16) for model in models]
        return [scratch.bundle(articulated=True).seal().numba_type for scratch in scratches]

    monkeypatch.setenv(ONE_KERNEL, "3,2")
    one, other = kinds()
    assert one == other
    monkeypatch.delenv(ONE_KERNEL)
    one, other = kinds()
    assert one != other


@pytest.mark.parametrize("dim", [2, 3], ids=["2D", "3D"])
def test_the_general_kernel_steps_a_scene_while_it_alone_is_compiled(monkeypatch: pytest.MonkeyPatch, dim: int) -> None:
    monkeypatch.delenv(ONE_KERNEL, raising=False)
    monkeypatch.delenv(OWN_KERNELS, raising=False)
    model = plain(dim).compile()
    own, general = kernel_variant_of(model), general_variant(dim)
    chosen = {
        compiled: choose_variant(model, lambda variant, some=compiled: variant in some)  # type: ignore[misc]
        for compiled in ((), (own,), (general,), (own, general))
    }
    assert chosen == {(): own, (own,): own, (general,): general, (own, general): own}
    monkeypatch.setenv(OWN_KERNELS, "1")
    assert choose_variant(model, lambda variant: variant == general) == own
