"""3D worlds to pictures. The world here is a stand-in with a World's arrays."""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from gsenv.render.spatial import SpatialCamera, SpatialRenderer, make_primitives, render_primitives
from gsenv.render.spatial.primitives import BOX, CAPSULE, PLANE, SPHERE
from gsenv.render.spatial.style import GROUND_COLOR
from gsenv.render.spatial.world_view import read_primitives, read_table
from gsenv.render.theme import PALETTE
from gsenv.solver.records.model import (
    BodyKind,
    body_model_dtype,
    body_parameter_dtype,
    body_state_dtype,
    joint_model_dtype,
    joint_parameter_dtype,
    shape_model_dtype,
    shape_parameter_dtype,
)
from gsenv.solver.spatial.vertices import vertex_dtype
from tests.render.spatial import oracles

CAMERA = SpatialCamera((3.0, -4.0, 2.5), (0.0, 0.0, 0.5), width=90, height=70)


class Model(NamedTuple):
    dim: int
    bodies: NDArray[np.void]
    shapes: NDArray[np.void]
    shape_colors: NDArray[np.uint8] | None
    joints: NDArray[np.void]
    nominal_joints: NDArray[np.void]
    nominal_bodies: NDArray[np.void]


class Parameters(NamedTuple):
    bodies: NDArray[np.void]
    shapes: NDArray[np.void]
    vertices: NDArray[np.void]
    joints: NDArray[np.void]


class State(NamedTuple):
    bodies: NDArray[np.void]


class World(NamedTuple):
    model: Model
    parameters: Parameters
    state: State


def make_world() -> World:
    """Two worlds of a ground, a body of a box and a capsule with its centre aside, a ball, and a sensor."""
    bodies, shapes = np.zeros(3, body_model_dtype()), np.zeros(5, shape_model_dtype())
    bodies["kind"] = (BodyKind.STATIC, BodyKind.DYNAMIC, BodyKind.DYNAMIC)
    shapes["kind"], shapes["body"] = (PLANE, BOX, CAPSULE, SPHERE, SPHERE), (0, 1, 1, 2, 2)
    shapes["sensor"][4] = 1
    parameters = np.zeros((2, 5), shape_parameter_dtype(3))
    parameters["local_rotation"][..., 0], parameters["enabled"] = 1.0, 1
    parameters["local_rotation"][:, 2] = (0.6, 0.8, 0.0, 0.0)
    parameters["local_position"][:, 2] = (0.0, 0.5, 0.3)
    parameters["size"][:, 1], parameters["size"][:, 2] = (0.4, 0.3, 0.2), (0.0, 0.0, 0.4)
    parameters["radius"] = (0.0, 0.0, 0.15, 0.3, 2.0)
    body_parameters, states = np.zeros((2, 3), body_parameter_dtype(3)), np.zeros((2, 3), body_state_dtype(3))
    body_parameters["enabled"], body_parameters["center"][:, 1] = 1, (0.1, 0.2, 0.05)
    states["rotation"][..., 0] = 1.0
    states["rotation"][:, 1] = (0.5, 0.5, -0.5, 0.5)
    states["position"][:, 1], states["position"][:, 2] = (0.2, 0.1, 0.8), (-1.0, 0.0, 0.3)
    states["position"][1, 2] = (1.0, -1.0, 0.3)
    vertices = np.zeros((2, 0), vertex_dtype())
    joints = (np.zeros(0, joint_model_dtype()), np.zeros(0, joint_parameter_dtype(3)))
    model = Model(3, bodies, shapes, None, *joints, body_parameters[0])
    joint_parameters = np.zeros((2, 0), joint_parameter_dtype(3))
    return World(model, Parameters(body_parameters, parameters, vertices, joint_parameters), State(states))


def test_shapes_sit_in_their_bodies_frames() -> None:
    world = make_world()
    primitives = read_primitives(world, 0, read_table(world))
    turn = oracles.turn_matrix((0.5, 0.5, -0.5, 0.5))
    expected = np.array([0.2, 0.1, 0.8]) + turn @ (np.array([0.0, 0.5, 0.3]) - [0.1, 0.2, 0.05])
    np.testing.assert_allclose(primitives.position[2], expected, atol=1e-14)
    both = oracles.turn_matrix(primitives.rotation[2])
    np.testing.assert_allclose(both, turn @ oracles.turn_matrix((0.6, 0.8, 0.0, 0.0)), atol=1e-14)
    assert primitives.kind.tolist() == [PLANE, BOX, CAPSULE, SPHERE]  # no sensors


def test_a_frame_is_the_picture_of_its_primitives() -> None:
    world = make_world()
    renderer = SpatialRenderer(world, 90, 70, CAMERA, "fast")
    table = read_table(world)
    pictures = [renderer.frame(k) for k in range(2)]
    assert (pictures[0] != pictures[1]).any()
    for k, picture in enumerate(pictures):
        primitives = read_primitives(world, k, table)
        np.testing.assert_array_equal(picture, render_primitives(CAMERA, primitives, None, "fast"))
    assert (renderer.width, renderer.height) == (90, 70)
    other = CAMERA.following((0.5, 0.0, 0.5))
    assert (renderer.frame(0, other) != pictures[0]).any()


def test_colors_are_the_models_or_the_palette() -> None:
    world = make_world()
    table = read_table(world)
    np.testing.assert_array_equal(table.color, [GROUND_COLOR, PALETTE[0], PALETTE[0], PALETTE[1]])
    colors = np.arange(15, dtype=np.uint8).reshape(5, 3)
    table = read_table(world._replace(model=world.model._replace(shape_colors=colors)))
    np.testing.assert_array_equal(table.color[1:], colors[1:4])
    colors[1:] = 0  # what bodies without a colour have; black ones have 1, 1, 1
    table = read_table(world._replace(model=world.model._replace(shape_colors=colors)))
    np.testing.assert_array_equal(table.color, [(0, 1, 2), PALETTE[0], PALETTE[0], PALETTE[1]])


def test_without_a_camera_all_moving_bodies_are_in_view_and_stay_there() -> None:
    world = make_world()
    renderer = SpatialRenderer(world, 90, 70)
    renderer.frame()
    camera = renderer.camera
    assert camera is not None
    pixels = camera.to_pixel(world.state.bodies[0]["position"][1:])
    assert ((pixels > 5) & (pixels < (85, 65))).all()
    world.state.bodies[0]["position"][2] += 0.05
    renderer.frame()
    assert renderer.camera is camera
    world.state.bodies[0]["position"][2] += 1.0
    renderer.frame()
    assert renderer.camera is not None
    pixels = renderer.camera.to_pixel(world.state.bodies[0]["position"][1:])
    assert ((pixels > 0) & (pixels < (90, 70))).all()


def test_disabled_bodies_are_not_drawn() -> None:
    world = make_world()
    renderer = SpatialRenderer(world, 90, 70, CAMERA, "fast")
    world.parameters.bodies["enabled"][0, 1:] = 0
    ground = make_primitives([PLANE], [(0, 0, 0)], color=[GROUND_COLOR])
    np.testing.assert_array_equal(renderer.frame(), render_primitives(CAMERA, ground, None, "fast"))


def test_rendering_leaves_the_world_alone() -> None:
    world: Any = make_world()
    arrays = [world.state.bodies, world.parameters.bodies, world.parameters.shapes]
    before = [array.tobytes() for array in arrays]
    SpatialRenderer(world, 30, 20).frame()
    assert [array.tobytes() for array in arrays] == before


def test_a_2d_world_gets_one_sentence() -> None:
    world = make_world()
    with pytest.raises(ValueError, match="draws 3D worlds, got one with dim 2"):
        SpatialRenderer(world._replace(model=world.model._replace(dim=2)))
