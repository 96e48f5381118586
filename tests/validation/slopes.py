"""Bodies on slopes and on level ground, in 2D and in any horizontal direction in 3D."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gsenv.scenes import box_on_incline, disk_on_incline, sliding_disk
from gsenv.scenes.spatial import block_on_incline, roller_on_incline, sliding_roller
from gsenv.scenes.spatial.turning import level
from gsenv.solver import Scene, World
from tests.validation.reference import Array


class Direction(NamedTuple):
    """Where a slope falls to, and how the block is turned on it."""

    dim: int
    heading: float = 0.0  # degrees from the x axis, in 3D
    turn: float = 0.0  # degrees about the slope's normal, in 3D

    def __str__(self) -> str:
        return "2D" if self.dim == 2 else f"3D towards {self.heading:g} turned {self.turn:g}"

    def forward(self) -> Array:
        """The horizontal unit vector."""
        return np.array((1.0, 0.0) if self.dim == 2 else level(self.heading))

    def downhill(self, degrees: float) -> Array:
        """Unit vector down a slope of so many degrees."""
        down = np.eye(self.dim)[-1] * -math.sin(math.radians(degrees))
        return np.asarray(math.cos(math.radians(degrees)) * self.forward() + down)

    def block(self, degrees: float, friction: float = 0.5, half_width: float = 0.25, half_height: float = 0.1) -> Scene:
        """A block at rest on the slope."""
        if self.dim == 2:
            return box_on_incline(degrees, friction, (half_width, half_height))
        half_extents = (half_width, half_width, half_height)
        return block_on_incline(degrees, self.heading, self.turn, friction, half_extents)


class Roller(NamedTuple):
    """A round body and where it rolls to."""

    kind: str
    heading: float = 0.0  # degrees from the x axis, in 3D

    def __str__(self) -> str:
        return self.kind if self.kind == "disk" else f"{self.kind} towards {self.heading:g}"

    @property
    def direction(self) -> Direction:
        return Direction(2 if self.kind == "disk" else 3, self.heading)

    @property
    def inertia(self) -> float:
        """Moment of inertia over m r^2."""
        return {"disk": 0.5, "sphere": 0.4, "cylinder": 0.5}[self.kind]

    def on_slope(self, degrees: float) -> Scene:
        return disk_on_incline(degrees) if self.kind == "disk" else roller_on_incline(self.kind, degrees, self.heading)

    def sliding(self, speed: float, friction: float, radius: float) -> Scene:
        """On level ground, without rotation."""
        if self.kind == "disk":
            return sliding_disk(speed, friction, radius)
        return sliding_roller(self.kind, speed, friction, radius, self.heading)

    def speeds(self, world: World) -> tuple[float, float]:
        """(m/s forwards, rad/s of rolling forwards) of body 1."""
        forward = self.direction.forward()
        v, w = world.linear_velocity[0, 1], world.angular_velocity[0, 1]
        rate = -w if self.kind == "disk" else w @ np.cross((0.0, 0.0, 1.0), forward)
        return float(v @ forward), float(rate)


def turned_by(world: World, start: World) -> float:
    """rad by which body 1 has turned since ``start``."""
    if world.model.dim == 2:
        return float(abs(world.angle[0, 1] - start.angle[0, 1]))
    return 2.0 * math.acos(min(1.0, abs(float(start.orientation[0, 1] @ world.orientation[0, 1]))))
