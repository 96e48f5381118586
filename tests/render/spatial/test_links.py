"""Rods, ropes and springs as thin capsules."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.render.spatial.links import find_colors, with_links
from gsenv.render.spatial.primitives import CAPSULE, Primitives
from gsenv.render.spatial.scene_renderer import SpatialRenderer
from gsenv.render.spatial.world_view import read_link_table, read_links, read_primitives, read_table
from gsenv.render.theme import ROD_COLOR, ROPE_COLOR, SPRING_COLOR
from gsenv.solver import Scene, World
from gsenv.solver.spatial import Ball, Distance, Sphere
from tests.render.spatial import oracles

TURN = (0.5, 0.5, -0.5, 0.5)


def linked(worlds: int = 1) -> World:
    """A hook at the origin; balls on a rod, a rope and a spring, and one on a ball joint."""
    scene = Scene(dim=3)
    scene.add_body("hook", "static")
    for k, name in enumerate(("rod", "rope", "spring", "ball")):
        scene.add_body(name, shapes=[Sphere(radius=0.2)], position=(0.5 * k, 0.3, -1.0), orientation=TURN)
    scene.add_joint("rod", Distance("hook", "rod", anchor_b=(0.0, 0.1, 0.2)))
    scene.add_joint("rope", Distance("hook", "rope", limits=(0.0, 2.0)))
    scene.add_joint("spring", Distance("hook", "spring", stiffness=10.0))
    scene.add_joint("ball", Ball("hook", "ball", anchor=(0.0, 0.0, 0.0)))
    return World(scene, worlds)


def drawn(world: World, index: int = 0) -> Primitives:
    table = read_link_table(world)
    return with_links(read_primitives(world, index, read_table(world)), table, read_links(world, index, table))


def test_links_reach_from_anchor_to_anchor_in_each_world() -> None:
    world = linked(2)
    world.set_pose("rod", position=(0.0, 0.0, 2.0), worlds=1)
    assert_allclose(find_colors(read_link_table(world)), [ROD_COLOR, ROPE_COLOR, SPRING_COLOR])
    for w in range(2):
        all_of_it = drawn(world, w)
        n = len(read_table(world).kind)
        assert all_of_it.kind[n:].tolist() == [CAPSULE] * 3
        for k, name in enumerate(("rod", "rope", "spring")):
            anchor = (0.0, 0.1, 0.2) if name == "rod" else (0.0, 0.0, 0.0)
            end = world.position[w, 1 + k] + oracles.turn_matrix(world.orientation[w, 1 + k]) @ anchor
            axis = oracles.turn_matrix(all_of_it.rotation[n + k])[:, 2] * all_of_it.size[n + k, 2]
            assert_allclose(all_of_it.position[n + k] - axis, np.zeros(3), atol=1e-12)
            assert_allclose(all_of_it.position[n + k] + axis, end, atol=1e-12)
            assert 0.0 < all_of_it.radius[n + k] < 0.05


@pytest.mark.parametrize("place", [(0.0, 0.0, -1.0), (0.0, 0.0, 0.0)])
def test_links_straight_down_and_of_no_length(place: tuple[float, float, float]) -> None:
    world = linked()
    world.set_pose("rope", position=place)
    link = drawn(world)
    axis = oracles.turn_matrix(link.rotation[-2])[:, 2] * link.size[-2, 2]
    assert_allclose(link.position[-2] + axis, place, atol=1e-12)
    assert bool(link.enabled[-2]) is (place != (0.0, 0.0, 0.0))


def test_a_joint_that_is_off_is_not_drawn() -> None:
    world = linked()
    shown = SpatialRenderer(world, 120, 90).render()
    world.parameters.joints["enabled"][:, 2] = 0
    assert (SpatialRenderer(world, 120, 90).render() != shown).any()
    link = drawn(world)
    assert link.enabled[-3:].tolist() == [True, True, False]
