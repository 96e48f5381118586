"""Sensors: what a user asks for, how it is stored, how it is read; and rays cast by hand.

All sensors of all worlds are read by one jitted call; only joints are read through the World.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import int64

from . import check
from .jit import njit
from .model import Array, Model
from .optional import as_records, at
from .planar import rays
from .planar.authored import rotation_of
from .planar.math import rotate, unrotate
from .planar.shapes import ALL_BITS

if TYPE_CHECKING:
    from .parameters import Parameters
    from .state import State
    from .world import World


class SensorKind(IntEnum):
    POSE = 0
    VELOCITY = 1
    CONTACT = 2
    FRAME = 3
    JOINT = 4
    RAYS = 5


SENSOR_KINDS = {kind.name.lower(): kind for kind in SensorKind}
POSE, VELOCITY, CONTACT, FRAME, JOINT, RAYS = (int(kind) for kind in SensorKind)
WIDTHS = {  # numbers in a reading, by dimension
    2: {"pose": 3, "velocity": 3, "contact": 3, "frame": 7, "joint": 5},
    3: {"pose": 7, "velocity": 6, "contact": 4, "joint": 6},
}
ONLY_PLANAR = ("frame", "rays")

SENSOR_DTYPE = np.dtype(
    [
        ("kind", "i4"),  # SensorKind
        ("body", "i4"),  # -1: none
        ("joint", "i4"),  # -1: none
        ("column", "i4"),  # of its first number among those of all sensors
        ("count", "i4"),  # how many numbers
        ("ray_first", "i4"),
        ("mask", "i8"),  # categories that its rays see
        ("length", "f8"),  # m, of its rays
        ("local_position", "f8", (2,)),  # m, of the site in the body's own frame
    ],
    align=True,
)


@dataclass
class SensorSpec:
    name: str
    kind: str
    body: int
    joint: int
    local_position: Array
    angles: Array
    length: float
    mask: int


def sensor_spec(
    name: str, kind: str, body: int, joint: int, local_position: Any, angles: Any, length: Any, mask: Any,
    dim: int = 2,
) -> SensorSpec:  # fmt: skip
    """A checked spec; body and joint are indices, -1 where none was given.

    Raises:
        ValueError: something is missing, out of its range, or not of this kind of sensor.
    """
    what = f"sensor {name!r}"
    check.choice(kind, SENSOR_KINDS, f"{what}: kind")
    if dim == 3 and kind in ONLY_PLANAR:
        raise ValueError(f"{what}: sensors of kind {kind!r} are there in 2D only.")
    bits = category_bits(mask, f"{what}: mask")
    given = {
        "body": body >= 0,
        "joint": joint >= 0,
        "local_position": local_position is not None,
        "angles": angles is not None,
        "length": length is not None,
        "mask": bits != ALL_BITS,
    }
    needed = {"joint": ("joint",), "rays": ("body", "angles", "length")}.get(kind, ("body",))
    optional = {"frame": ("local_position",), "rays": ("local_position", "mask")}.get(kind, ())
    for word, present in given.items():
        if word in needed and not present:
            raise ValueError(f"{what}: {word} is missing.")
        if present and word not in (*needed, *optional):
            raise ValueError(f"{what}: a sensor of kind {kind!r} has no {word}.")
    site = check.vector((0.0, 0.0) if local_position is None else local_position, 2, f"{what}: local_position")
    fan = np.zeros(0) if angles is None else _numbers(angles, f"{what}: angles")
    if angles is not None and (fan.ndim != 1 or not fan.size):
        raise ValueError(f"{what}: angles must be a list of numbers, got an array of shape {fan.shape}.")
    reach = 0.0 if length is None else check.positive(length, f"{what}: length")
    return SensorSpec(name, kind, body, joint, site, fan, reach, bits)


def _numbers(value: Any, what: str) -> Array:
    """Finite float64 values of any shape, a copy."""
    try:
        array = np.array(value, np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be numbers, got {value!r}.") from None
    return check.values(array, array.shape, what)


def category_bits(mask: Any, what: str) -> int:
    """Category bits as a signed 64-bit number."""
    if isinstance(mask, bool) or not isinstance(mask, (int, np.integer)) or not -(2**63) <= int(mask) < 2**64:
        raise ValueError(f"{what} must be an integer of 64 bits, got {mask!r}.")
    bits = int(mask) & (2**64 - 1)
    return bits - 2**64 if bits >= 2**63 else bits


def sensor_rays(specs: Iterable[SensorSpec]) -> Array:
    """(ray, 2) unit directions of all sensors' rays in the frames of their bodies."""
    return np.array([rotation_of(a) for spec in specs for a in spec.angles]).reshape(-1, 2)


def sensor_records(specs: Iterable[SensorSpec], dim: int = 2) -> Array:
    """(sensor,) of SENSOR_DTYPE."""
    specs = list(specs)
    sensors = np.zeros(len(specs), SENSOR_DTYPE)
    column = ray = 0
    for record, spec in zip(sensors, specs, strict=True):
        count = WIDTHS[dim].get(spec.kind, len(spec.angles))
        record["kind"] = SENSOR_KINDS[spec.kind]
        record["column"], record["count"] = column, count
        record["ray_first"] = ray
        for name in ("body", "joint", "mask", "length", "local_position"):
            record[name] = getattr(spec, name)
        column += count
        ray += len(spec.angles)
    return sensors


# ---------------------------------------------------------------- reading


def read_sensors(world: World, first: int, last: int) -> Array:
    """(world, number) readings of the sensors first .. last - 1, side by side."""
    model, parameters, state = world.model, world.parameters, world.state
    sensors = model.sensors[first:last]
    out = np.zeros((world.world_count, int(sensors["count"].sum())))
    if not len(sensors):
        return out
    if model.dim == 3:
        from .spatial.sensors import read_into

        read_into(out, world, sensors)
        return out
    looks = len(model.sensor_rays) > 0
    arguments = (
        sensors, parameters.bodies, state.worlds, state.bodies, state.contacts,
        model.shapes if looks else None,
        parameters.shapes if looks else None,
        parameters.vertices if looks and model.needs_vertices else None,
        model.sensor_rays if looks else None,
        np.zeros(int(sensors["count"].max()), rays.RAY_DTYPE) if looks else None,
    )  # fmt: skip
    _read(out, world.timestep, *(as_records(array) for array in arguments))
    for sensor in sensors[sensors["kind"] == JOINT]:
        column = sensor["column"] - sensors[0]["column"]
        out[:, column : column + sensor["count"]] = _joint_reading(world, int(sensor["joint"]))
    return out


def _joint_reading(world: Any, joint: int) -> Array:
    """(world, 5): coordinate, rate, reaction force x and y, torque."""
    return np.column_stack([world.joint_coordinate(joint), world.joint_rate(joint), world.joint_reaction(joint)])


@njit
def _read(
    out: Array,
    timestep: float,
    sensors: Array,
    body_parameters: Array,
    world_states: Array,
    bodies: Array,
    contacts: Array,
    shape_models: Any,
    shape_parameters: Any,
    vertices: Any,
    directions: Any,
    ray_scratch: Any,
) -> None:
    """Fill `out` (world, number); what only rays need is None in a scene without them."""
    for w in range(len(bodies)):
        for s in range(len(sensors)):
            sensor = sensors[s]
            column = sensor.column - sensors[0].column
            reading = out[w, column : column + sensor.count]
            body = int64(sensor.body)
            if sensor.kind == POSE:
                _read_pose(bodies[w, body], body_parameters[w, body], reading)
            elif sensor.kind == VELOCITY:
                for axis in range(3):  # a slice would take seconds to compile
                    reading[axis] = bodies[w, body].velocity[axis]
            elif sensor.kind == CONTACT:
                _read_contact(contacts[w, : world_states[w].contact_count], body, timestep, reading)
            elif sensor.kind == FRAME:
                _read_frame(bodies[w, body], body_parameters[w, body], sensor, reading)
            elif directions is not None:
                if sensor.kind == RAYS:
                    fan = ray_scratch[: sensor.count]
                    _place_rays(sensor, directions, bodies[w, body], body_parameters[w, body], fan)
                    rays.cast_rays_in_world(
                        bodies[w], body_parameters[w], shape_models, shape_parameters[w],
                        at(vertices, w), sensor.mask, body, fan,
                    )  # fmt: skip
                    for r in range(len(fan)):
                        reading[r] = fan[r].distance


@njit
def _site(body: Any, body_parameter: Any, x: float, y: float) -> tuple[float, float]:
    """A point of the body's own frame from its centre of mass, in the axes of the world, m."""
    center = body_parameter.center
    return rotate(body.rotation[0], body.rotation[1], x - center[0], y - center[1])


@njit
def _read_pose(body: Any, body_parameter: Any, reading: Array) -> None:
    x, y = _site(body, body_parameter, 0.0, 0.0)
    reading[0] = body.position[0] + x
    reading[1] = body.position[1] + y
    reading[2] = body.angle


@njit
def _read_contact(contacts: Array, body: int, timestep: float, reading: Array) -> None:
    """Mean force over the step, as Contacts.force_vector and Contacts.touching have it."""
    for k in range(len(contacts)):
        contact = contacts[k]
        if contact.body_b == body:
            scale = 1.0 / timestep
        elif contact.body_a == body:
            scale = -1.0 / timestep
        else:
            continue
        push = contact.total_impulse[0]
        drag = contact.total_impulse[1]
        if push > 0.0 or contact.separation <= 0.0:
            reading[0] = 1.0
        reading[1] += scale * (contact.normal[0] * push - contact.normal[1] * drag)
        reading[2] += scale * (contact.normal[1] * push + contact.normal[0] * drag)


@njit
def _read_frame(body: Any, body_parameter: Any, sensor: Any, reading: Array) -> None:
    x, y = _site(body, body_parameter, sensor.local_position[0], sensor.local_position[1])
    spin = body.velocity[2]
    vx = body.velocity[0] - spin * y
    vy = body.velocity[1] + spin * x
    reading[0] = body.position[0] + x
    reading[1] = body.position[1] + y
    reading[2] = body.rotation[0]
    reading[3] = body.rotation[1]
    reading[4], reading[5] = unrotate(body.rotation[0], body.rotation[1], vx, vy)
    reading[6] = spin


@njit
def _place_rays(sensor: Any, directions: Array, body: Any, body_parameter: Any, fan: Array) -> None:
    x, y = _site(body, body_parameter, sensor.local_position[0], sensor.local_position[1])
    for r in range(len(fan)):
        local = directions[sensor.ray_first + r]
        dx, dy = rotate(body.rotation[0], body.rotation[1], local[0], local[1])
        ray = fan[r]
        ray.origin[0] = body.position[0] + x
        ray.origin[1] = body.position[1] + y
        ray.direction[0] = dx
        ray.direction[1] = dy
        ray.distance = sensor.length


# ---------------------------------------------------------------- rays by hand


@dataclass(frozen=True)
class RayHits:
    """First hits of rays; arrays (chosen world, ray), vectors with two numbers more.

    Attributes:
        distance: m from the start; the ray's length where nothing is hit.
        shape, body: indices, -1 where nothing is hit.
        normal: unit, outward of the surface; against the ray where it starts inside a shape (at
            distance 0), zero where nothing is hit.
        point: m, where the hit is, or the end of the ray.
    """

    distance: Array
    shape: Array
    body: Array
    normal: Array
    point: Array

    @property
    def hit(self) -> Array:
        """(chosen world, ray) bool."""
        return self.shape >= 0


def cast_rays(
    model: Model, parameters: Parameters, state: State, worlds: Array,
    origin: Any, direction: Any, length: Any, mask: Any, exclude: int,
) -> RayHits:  # fmt: skip
    """World.cast_rays for world and body indices (`exclude` -1: none)."""
    bits = category_bits(mask, "cast_rays: mask")
    fan = _checked_rays(origin, direction, length, len(worlds))
    rays.cast_rays(
        worlds, as_records(state.bodies), as_records(parameters.bodies), as_records(model.shapes),
        as_records(parameters.shapes), as_records(parameters.vertices if model.needs_vertices else None),
        bits, exclude, as_records(fan),
    )  # fmt: skip
    shape = fan["shape"]
    body = np.where(shape >= 0, model.shapes["body"][shape], -1)
    point = fan["origin"] + fan["distance"][..., None] * fan["direction"]
    return RayHits(fan["distance"].copy(), shape.copy(), body, fan["normal"].copy(), point)


def _checked_rays(origin: Any, direction: Any, length: Any, worlds: int) -> Array:
    """(chosen world, ray) of RAY_DTYPE."""
    parts = {"origin": origin, "direction": direction, "length": length}
    given = {name: _numbers(value, f"cast_rays: {name}") for name, value in parts.items()}
    shapes = (given["origin"].shape, given["direction"].shape, (*given["length"].shape, 1))
    try:
        shape = np.broadcast_shapes((worlds, 1, 2), *shapes)
    except ValueError:
        shape = ()
    if len(shape) != 3 or shape[0] != worlds or shape[2] != 2:
        got = ", ".join(str(array.shape) for array in given.values())
        raise ValueError(
            f"cast_rays: origin, direction and length must fit ({worlds}, rays, 2), ({worlds}, rays, 2) and "
            f"({worlds}, rays), got arrays of shape {got}."
        )
    if (given["length"] <= 0.0).any():
        raise ValueError(f"cast_rays: length must be positive, got {given['length'].min()!r}.")
    largest = np.abs(given["direction"]).max(-1, initial=0.0, keepdims=True)
    if (largest == 0.0).any():
        raise ValueError("cast_rays: direction must not be zero.")
    way = given["direction"] / largest  # or squares might overflow
    fan = np.zeros(shape[:2], rays.RAY_DTYPE)
    fan["origin"] = given["origin"]
    fan["direction"] = way / np.sqrt((way * way).sum(-1, keepdims=True))
    fan["distance"] = given["length"]
    return fan
