"""Reads from a World what the overlays show: contact forces, and anchors and axes of joints."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.render.spatial.world_view import multiply
from gsenv.render.spatial.world_view import rotate as rotate_3d
from gsenv.render.world_view import rotate as rotate_2d
from gsenv.solver.api.world import World
from gsenv.solver.records.model import JointKind
from gsenv.solver.spatial.joints.axes import FIRST_TURN, LAST_TURN, NODE_TURN, TWIST

FloatArray = NDArray[np.float64]

WITHOUT_PLACE = (JointKind.GEAR, JointKind.ROWS, JointKind.TARGET)
SLIDES_2D = (JointKind.PRISMATIC, JointKind.WHEEL)


def read_contacts(world: World, index: int) -> tuple[FloatArray, FloatArray]:
    """Return points (contact, dim) in m and mean forces (contact, dim) in N of the touching contacts."""
    contacts = world.contacts(index)
    touching = contacts.touching & ~contacts.sensor
    return contacts.point[touching], contacts.force_vector(world.timestep)[touching]


class JointPlaces(NamedTuple):
    """Where the enabled joints of a world are; m in the world's axes."""

    anchors: FloatArray  # (joint, dim), on body b; of axes that belong to one joint several times the same
    links: FloatArray  # (link, 2, dim), both ends of rods, ropes and springs
    centers: FloatArray  # (axis, dim)
    axes: FloatArray  # (axis, dim), unit
    slides: NDArray[np.bool_]  # (axis,), whether it is a direction of translation
    radii: FloatArray  # (axis,) m, of body b


def read_joints(world: World, index: int) -> JointPlaces:
    """Return anchors and axes of one world's joints."""
    model = world.model
    dim = model.dim
    kinds = model.joints["kind"]
    bodies_on = world.parameters.bodies[index]["enabled"] != 0
    on = (world.parameters.joints[index]["enabled"] != 0) & ~np.isin(kinds, WITHOUT_PLACE)
    body_a, body_b = model.joints["body_a"], model.joints["body_b"]
    chosen = np.flatnonzero(on & (body_a >= 0) & (body_b >= 0))
    chosen = chosen[bodies_on[body_a[chosen]] & bodies_on[body_b[chosen]]]
    on_a, on_b = (_places(world, index, chosen, side) for side in "ab")
    links = kinds[chosen] == JointKind.DISTANCE
    frames = _axes_2d if dim == 2 else _axes_3d
    numbers, axes, slides = frames(world, index, chosen)
    ends = np.stack([on_a[links], on_b[links]], axis=1)
    radii = world.parameters.bodies["radius"][index, body_b[chosen[numbers]]]
    return JointPlaces(on_b[~links], ends, on_b[numbers], axes, slides, radii)


def _places(world: World, index: int, chosen: NDArray[np.int64], side: str) -> FloatArray:
    """Return the anchors (joint, dim) on body a or b."""
    body = world.model.joints[f"body_{side}"][chosen]
    state = world.state.bodies[index][body]
    local = world.parameters.joints[index][f"anchor_{side}"][chosen] - world.parameters.bodies[index]["center"][body]
    rotate = rotate_2d if world.model.dim == 2 else rotate_3d
    return np.asarray(state["position"] + rotate(state["rotation"], local))


_Axes = tuple[NDArray[np.int64], FloatArray, NDArray[np.bool_]]  # numbers among the chosen joints, axes, slides


def _axes_2d(world: World, index: int, chosen: NDArray[np.int64]) -> _Axes:
    numbers = np.flatnonzero(np.isin(world.model.joints["kind"][chosen], SLIDES_2D))
    joints = chosen[numbers]
    rotation = world.state.bodies[index]["rotation"][world.model.joints["body_a"][joints]]
    axes = rotate_2d(rotation, world.parameters.joints[index]["axis"][joints])
    return numbers, axes, np.ones(len(numbers), np.bool_)


def _axes_3d(world: World, index: int, chosen: NDArray[np.int64]) -> _Axes:
    joints = world.model.joints[chosen]
    parameters = world.parameters.joints[index][chosen]
    rotation = world.state.bodies[index]["rotation"]
    frame_a = multiply(rotation[joints["body_a"]], parameters["frame"])
    back = parameters["reference"] * np.array([1.0, -1.0, -1.0, -1.0])
    frame_b = multiply(rotation[joints["body_b"]], multiply(back, parameters["frame"]))
    coordinate = np.where(joints["kind"] == JointKind.DISTANCE, -1, joints["coordinate"])
    axes = np.zeros((len(chosen), 3))
    unit = np.eye(3)
    first, last = rotate_3d(frame_a, unit[0]), rotate_3d(frame_b, unit[2])
    for k in range(3):
        axes[coordinate == k] = rotate_3d(frame_a, unit[k])[coordinate == k]
    axes[coordinate == FIRST_TURN] = first[coordinate == FIRST_TURN]
    axes[np.isin(coordinate, (LAST_TURN, TWIST))] = last[np.isin(coordinate, (LAST_TURN, TWIST))]
    axes[coordinate == NODE_TURN] = np.cross(last, first)[coordinate == NODE_TURN]
    length = np.sqrt((axes**2).sum(-1))
    numbers = np.flatnonzero(length > 1e-9)
    return numbers, axes[numbers] / length[numbers, None], (coordinate < FIRST_TURN)[numbers]
