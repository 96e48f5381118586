"""Bodies that the mouse picks and drags by a spring."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.solver.api.world import World
from gsenv.solver.records.model import BodyKind
from gsenv.view.camera_control import Control, Pixel

FloatArray = NDArray[np.float64]

REACH = 6.0  # px: nearer to the mouse than this, thin bodies are picked
DIRECTIONS = 12  # of the rays around the mouse
FREQUENCY = 3.0  # 1/s, of the spring with a free body on it
STIFFEST, MOST_DAMPING = 0.3, 0.8  # of what stops a point within a step: stable if STIFFEST + 2 MOST_DAMPING < 4
LEARNING = 0.1  # rate at which the spring learns its load, over the one at which it would begin to swing
MOST_LOAD = 1.5  # over the weight of all connected bodies
STRONGEST = 100.0  # m/s^2, times the least inertia of the point, and
STRONGEST_LIFT = 20.0  # m/s^2, times the mass of all connected bodies: the largest force


@dataclass(frozen=True)
class Picked:
    """A body and a point of it: `local` in m in its own axes, from its centre of mass; `point` in the world."""

    body: int
    local: FloatArray
    point: FloatArray


class Picker:
    """Finds the body under the mouse, by rays."""

    def __init__(self, world: World) -> None:
        self._world = world
        far = np.full(world.model.dim, 1e6)
        world.cast_rays(far, far, 1.0, worlds=0)  # compiles the kernel now rather than at the first click
        dynamic = world.model.bodies["kind"] == BodyKind.DYNAMIC
        self.movable: NDArray[np.bool_] = dynamic

    def pick(self, control: Control, pixel: Pixel, world_index: int) -> Picked | None:
        """Return what is under a pixel, or else the movable body nearest to it within a few px; None: nothing."""
        first = self._cast(control, [pixel], world_index)[0]
        if first is not None and self.movable[first.body]:
            return first
        angles = np.arange(DIRECTIONS) * (2.0 * math.pi / DIRECTIONS)
        for reach in (0.5 * REACH, REACH):
            around = [(pixel[0] + reach * math.cos(a), pixel[1] + reach * math.sin(a)) for a in angles]
            for picked in self._cast(control, around, world_index):
                if picked is not None and self.movable[picked.body]:
                    return picked
        return first

    def _cast(self, control: Control, pixels: list[Pixel], world_index: int) -> list[Picked | None]:
        """Return the first body on the ray through each pixel; in 2D what covers the point."""
        rays = [control.ray(pixel) for pixel in pixels]
        origin = np.array([start for start, _ in rays])
        if self._world.model.dim == 2:  # a ray that starts inside a shape hits it at once
            direction, length = np.array([[1.0, 0.0]] * len(rays)), 1e-9
        else:
            direction, length = np.array([way for _, way in rays]), 1e6
        hits = self._world.cast_rays(origin, direction, length, worlds=world_index)
        found: list[Picked | None] = []
        for k, body in enumerate(hits.body[0]):
            found.append(None if body < 0 else self._picked(int(body), hits.point[0, k], world_index))
        return found

    def _picked(self, body: int, point: FloatArray, world_index: int) -> Picked:
        state = self._world.state.bodies[world_index, body]
        local = rotate_back(state["rotation"], point - state["position"])
        return Picked(body, local, point.copy())


class Spring:
    """A spring from a body's point to the mouse, critically damped and bounded in force.

    It is made for the mass of all bodies that joints connect with this one, but no stiffer than is stable for the least
    inertia that the point can have: that of the body alone, in the direction in which it is lightest. What hangs on
    the body only adds to that, so light bodies on heavy chains are stable too. The spring learns to carry what it
    holds, within the weight of the connected bodies, so that these can be lifted.
    """

    def __init__(self, world: World, world_index: int, picked: Picked) -> None:
        self._world = world
        self._index = world_index
        self.picked = picked
        self.target = picked.point.copy()
        parameters = world.parameters.bodies[world_index]
        members = connected(world, world_index, picked.body)
        self._total = float(parameters["mass"][members].sum())
        self._load = np.zeros(world.model.dim)  # N, what the spring has learnt to carry

    def move(self, target: FloatArray) -> None:
        """Set the point in m that the spring pulls to."""
        if np.isfinite(target).all():
            self.target = np.asarray(target, np.float64).copy()

    @property
    def point(self) -> FloatArray:
        """m, the point of the body that is held"""
        state = self._world.state.bodies[self._index, self.picked.body]
        return np.asarray(state["position"] + rotate(state["rotation"], self.picked.local))

    def pull(self) -> None:
        """Apply the force of the spring for the next step of the engine; this wakes the body."""
        force = self.force()
        if force is not None:
            name = self._world.model.body_names[self.picked.body]
            self._world.apply_force(name, force=force, point=self.point, worlds=self._index)

    def force(self) -> FloatArray | None:
        """Return the force in N over the next step; None where the body cannot be moved."""
        body = self.picked.body
        parameters = self._world.parameters.bodies[self._index, body]
        if not (parameters["enabled"] and parameters["inv_mass"] > 0.0):
            return None
        dim = self._world.model.dim
        state = self._world.state.bodies[self._index, body]
        arm = rotate(state["rotation"], self.picked.local)
        velocity = state["velocity"][:dim] + turn_velocity(state["velocity"][dim:], arm)
        least = 1.0 / (parameters["inv_mass"] + _inverse_turning(parameters, dim) * float(arm @ arm))
        h, omega = self._world.timestep, 2.0 * math.pi * FREQUENCY
        stiffness = min(self._total * omega**2, STIFFEST * least / (h * h))
        damping = min(2.0 * self._total * omega, MOST_DAMPING * least / h)
        error = self.target - (state["position"] + arm)
        gravity = self._world.parameters.worlds["gravity"][self._index]
        weight = self._total * float(np.sqrt(gravity @ gravity))
        gain = LEARNING * damping * stiffness / self._total  # N/(m s), stable below LEARNING = 1 (Routh)
        self._load = bounded(self._load + h * gain * error, MOST_LOAD * weight)
        bound = STRONGEST * least + STRONGEST_LIFT * self._total
        return bounded(stiffness * error - damping * velocity + self._load, bound)


def bounded(force: FloatArray, bound: float) -> FloatArray:
    """Return a force of at most `bound` N; zero for one that is not finite."""
    size = float(np.sqrt(force @ force))
    if not math.isfinite(size):
        return np.zeros_like(force)
    return np.asarray(force * min(1.0, bound / max(size, 1e-300)))


def _inverse_turning(parameters: Any, dim: int) -> float:
    """Return the largest inverse inertia in 1/(kg m^2)."""
    return float(parameters["inv_inertia"] if dim == 2 else parameters["inv_inertia"].max())


def connected(world: World, world_index: int, body: int) -> NDArray[np.int64]:
    """Return the dynamic bodies that enabled joints connect with a body, itself included, not through other bodies."""
    model = world.model
    dynamic = model.bodies["kind"] == BodyKind.DYNAMIC
    enabled = world.parameters.joints[world_index]["enabled"] != 0
    a, b = model.joints["body_a"][enabled], model.joints["body_b"][enabled]
    both = (a >= 0) & (b >= 0)
    a, b = a[both], b[both]
    both = dynamic[a] & dynamic[b]
    a, b = a[both], b[both]
    found = np.zeros(len(dynamic), np.bool_)
    found[body] = True
    while True:
        more = np.concatenate([b[found[a] & ~found[b]], a[found[b] & ~found[a]]])
        if not len(more):
            return np.flatnonzero(found)
        found[more] = True


def rotate(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """Rotate a vector by (cos, sin) or by a quaternion (w, x, y, z)."""
    if len(vector) == 2:
        (c, s), (x, y) = rotation, vector
        return np.array([c * x - s * y, s * x + c * y])
    u = rotation[1:]
    t = 2.0 * np.cross(u, vector)
    return np.asarray(vector + rotation[0] * t + np.cross(u, t))


def rotate_back(rotation: FloatArray, vector: FloatArray) -> FloatArray:
    """Rotate a vector by the inverse rotation."""
    signs = (1.0, -1.0) if len(vector) == 2 else (1.0, -1.0, -1.0, -1.0)
    return rotate(np.asarray(rotation) * signs, vector)


def turn_velocity(spin: FloatArray, arm: FloatArray) -> FloatArray:
    """Return the velocity in m/s of a point at `arm` from the centre of mass, of a rotation in rad/s."""
    if len(arm) == 2:
        return np.array([-spin[0] * arm[1], spin[0] * arm[0]])
    return np.cross(spin, arm)
