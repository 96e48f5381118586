"""Which joints of a scene are in trees, and which body hangs on which."""

from __future__ import annotations

from typing import Any

import numpy as np

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Box, Distance, Revolute, Weld
from gsenv.solver.records.articulation import TURN, LinkKind
from gsenv.solver.records.kernel_variants import kernel_variant_of
from gsenv.solver.records.scratch import Scratch
from gsenv.solver.spatial import Axis, SixAxis
from gsenv.solver.spatial import Box as Brick


def boxes(count: int) -> Scene:
    scene = Scene()
    scene.add_body("wall", "static")
    for k in range(count):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.1, 0.1))], position=(float(k), 0.0))
    return scene


def test_a_chain_hangs_on_its_static_body_whatever_the_order() -> None:
    scene = boxes(3)
    scene.add_joint("low", Revolute("box_0", "box_1"))
    scene.add_joint("mid", Revolute("box_2", "box_1"))
    scene.add_joint("top", Weld("box_2", "wall"))
    trees = scene.compile().trees
    assert trees["parent"].tolist() == [-1, 2, 3, 0]
    assert trees["joint"].tolist() == [-1, 0, 1, 2]
    assert trees["flipped"].tolist() == [0, 1, 0, 1]
    assert (trees["kind"][1:] == LinkKind.AXES).all()
    assert trees["count"][1:].tolist() == [1, 1, 0]
    assert (trees["numbers"][1:3, 0] == TURN).all()
    assert trees["depth"].tolist() == [0, 2, 1, 0]
    assert np.all(np.diff(trees["rank"][[0, 3, 2, 1]]) > 0)


def test_loops_and_soft_joints_are_in_no_tree() -> None:
    scene = boxes(3)
    scene.add_joint("one", Revolute("box_0", "box_1", enabled=False))
    scene.add_joint("two", Revolute("box_0", "box_1"))
    scene.add_joint("soft", Weld("box_1", "box_2", frequency=3.0))
    scene.add_joint("rope", Distance("wall", "box_0", limits=(0.0, 1.0)))
    trees = scene.compile().trees
    assert trees["joint"].tolist() == [-1, -1, 1, -1]  # enabled joints first
    assert trees["depth"].tolist() == [0, 3, 4, 3]


def test_only_rigid_joints_make_trees() -> None:
    scene = boxes(2)
    scene.add_joint("rope", Distance("box_0", "box_1", limits=(0.0, 2.0)))
    assert not scene.compile().has_trees
    scene.add_joint("pin", Revolute("box_0", "box_1"))
    assert scene.compile().has_trees


def test_only_the_option_adds_the_part() -> None:
    scene = boxes(2)
    scene.add_joint("pin", Revolute("box_0", "box_1"))
    world = World(scene)
    assert Options().articulated
    scratch = Scratch(world.model, kernel_variant_of(world.model), 16)
    off: Any = scratch.bundle()
    on: Any = scratch.bundle(True)
    assert off.articulation is None
    assert on.articulation is not None


def test_several_coordinates_are_listed_from_the_parent_outward() -> None:
    scene = Scene(dim=3)
    for name in ("a", "b", "c", "d"):
        scene.add_body(name, shapes=[Brick(half_extents=(0.1, 0.1, 0.1))])
    free: dict[str, Any] = {"x": Axis(), "turn_x": Axis(), "turn_z": Axis()}
    scene.add_joint("down", SixAxis("a", "b", **free))
    scene.add_joint("up", SixAxis("c", "b", **free))
    scene.add_joint("nothing", SixAxis("b", "d", **free, y=Axis(), z=Axis(), turn_y=Axis(limits=(-1.0, 1.0))))
    trees = scene.compile().trees
    assert trees["joint"].tolist() == [-1, 0, trees["joint"][2], -1]
    assert trees["flipped"].tolist() == [0, 0, 1, 0]
    assert trees["count"].tolist() == [0, 3, 3, 0]
    down, up = trees["numbers"][1:3, :3].tolist()
    assert down == up[::-1]
    assert down[0] < 3 <= min(down[1:])
    assert down[1:] == [3, 5]
    assert trees["depth"].tolist() == [6, 9, 12, 6]
