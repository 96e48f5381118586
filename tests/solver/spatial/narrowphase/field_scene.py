"""A shape over a heightfield, and what the kernel says of it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.core.geometry import PlacedShape
from gsenv.solver.records.model import contact_dtype, shape_model_dtype, shape_parameter_dtype
from gsenv.solver.records.plain import as_records
from gsenv.solver.spatial.math import Pose, pose_of
from gsenv.solver.spatial.narrowphase.heightfields import heightfield_contacts, heightfield_gap
from gsenv.solver.spatial.shapes import Heightfield, Shape, shape_record
from tests.solver.kernel_worlds import narrowphase_bundle, shapes_bundle

Array = NDArray[Any]
ROOM = 16


class Found(NamedTuple):
    """Contacts as arrays (n, 3) and (n,)."""

    point: Array
    normal: Array
    separation: Array
    feature: Array
    deepest: float

    @property
    def number(self) -> int:
        return len(self.separation)


def pose_at(at: Any, rotation: Any = (1.0, 0.0, 0.0, 0.0)) -> Pose:
    q = np.asarray(rotation, float) / np.linalg.norm(rotation)
    x, y, z = (float(v) for v in at)
    return pose_of((x, y, z), (float(q[0]), float(q[1]), float(q[2]), float(q[3])))


class OverField:
    """One heightfield and one shape, anywhere."""

    def __init__(self, field: Heightfield, shape: Shape) -> None:
        made = [shape_record(one, shape_parameter_dtype(3)) for one in (field, shape)]
        models = np.zeros(2, shape_model_dtype())
        models["kind"] = [int(field.kind), int(shape.kind)]
        models["vertex_first"] = [0, len(made[0].vertices)]
        parameters = np.array([one.record for one in made])
        vertices = np.concatenate([one.vertices for one in made])
        self.shapes = shapes_bundle(3, models, parameters, vertices).seal()
        self.narrowphase = narrowphase_bundle(3, fields=True).seal()

    def contacts(
        self,
        at: Any,
        rotation: Any = (1.0, 0.0, 0.0, 0.0),
        margin: float = 0.01,
        field: Pose | None = None,
        room: int = ROOM,
        turn: float = 0.0,
    ) -> Found:
        out = as_records(np.zeros(room, contact_dtype(3)))
        ground = PlacedShape(0, field or pose_at((0, 0, 0)))
        shape = PlacedShape(1, pose_at(at, rotation))
        count = heightfield_contacts(self.shapes, ground, shape, margin, turn, out, 0, self.narrowphase)
        self.total = count
        n = min(count, room)
        point, normal, separation, feature = (
            np.array(out[f][:n]) for f in ("point", "normal", "separation", "feature")
        )
        return Found(point, normal, separation, feature, float(self.narrowphase.manifold["separation"]))

    def lowered(self, xy: Any, rotation: Any, by: float) -> Array:
        """Where the shape is `by` m below first contact, coming down over a place."""
        at = np.array([*xy, 1.0])
        for _ in range(100):
            distance = self.contacts(at, rotation, margin=3.0).deepest
            if distance < 1e-9:
                break
            at[2] -= distance
        at[2] -= by
        return at

    def gap(self, at: Any, rotation: Any = (1.0, 0.0, 0.0, 0.0), margin: float = 1.0) -> float:
        ground = PlacedShape(0, pose_at((0, 0, 0)))
        shape = PlacedShape(1, pose_at(at, rotation))
        return float(heightfield_gap(self.shapes, ground, shape, margin, self.narrowphase.field))


def field_over(function: Any, samples: int = 21, size: float = 4.0) -> Heightfield:
    """Square field of a function of x and y."""
    line = (np.arange(samples) / (samples - 1) - 0.5) * size
    x, y = np.meshgrid(line, line)
    return Heightfield(heights=function(x, y) + 0.0 * x, size=(size, size))
