"""Compilation of a Scene to a Model: names become indices, shapes records, densities masses."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ..core.broadphase import encode_exclusion
from ..dimension import dimension
from ..records.model import (
    ACTUATOR_DTYPE,
    ActuatorMode,
    Array,
    BodyKind,
    JointKind,
    Model,
    body_model_dtype,
    body_parameter_dtype,
    body_state_dtype,
    constraint_row_dtype,
    joint_model_dtype,
    joint_parameter_dtype,
    joint_state_dtype,
    shape_model_dtype,
    shape_parameter_dtype,
    world_parameter_dtype,
)
from ..records.sensors import SensorKind, sensor_dtype
from . import check
from .articulations import trees_of
from .placement import anchor_of, to_local, to_world
from .repeats import repeats_of
from .solids import mass_of
from .specs import BodySpec, JointSpec, SceneSpec, SensorSpec

ACTUATOR_MODES = {"velocity": ActuatorMode.VELOCITY, "position": ActuatorMode.POSITION, "torque": ActuatorMode.TORQUE}
BLACK = (1, 1, 1)  # (0, 0, 0) is no colour in a Model
WITH_VERTICES = ("POLYGON", "TERRAIN", "HULL", "HEIGHTFIELD")


def compile_scene(scene: SceneSpec) -> Model:
    """Return the Model: the constant data and the nominal values of a world.

    Raises:
        ValueError: a scene without bodies.
    """
    bodies = list(scene.bodies.values())
    if not bodies:
        raise ValueError("Scene: there is no body to simulate.")
    shape_count = sum(len(spec.shapes) for spec in bodies)
    models = np.zeros(len(bodies), body_model_dtype())
    shapes = np.zeros(shape_count, shape_model_dtype())
    dim = scene.dim
    modules = dimension(dim)
    nominal = np.zeros(len(bodies), body_parameter_dtype(dim))
    sizes = np.zeros(shape_count, shape_parameter_dtype(dim))
    start = np.zeros(len(bodies), body_state_dtype(dim))
    shape_names: list[str] = []
    vertices: list[Array] = []
    colors = np.zeros((shape_count, 3), np.uint8)
    vertex = 0
    s = 0
    for b, spec in enumerate(bodies):
        models[b] = (int(spec.kind), int(spec.continuous), 0, s, len(spec.shapes))
        _fill_body(spec, nominal[b : b + 1], start[b : b + 1])
        for k, shape in enumerate(spec.shapes):
            compiled = modules.shapes.shape_record(shape, sizes.dtype)
            sizes[s] = compiled.record
            shapes[s]["kind"] = int(shape.kind)
            shapes[s]["body"] = b
            shapes[s]["category"] = check.signed(int(shape.category))
            shapes[s]["mask"] = check.signed(int(shape.mask))
            shapes[s]["sensor"] = bool(shape.sensor)
            shapes[s]["vertex_first"] = vertex
            shapes[s]["vertex_count"] = len(compiled.vertices)
            vertex += len(compiled.vertices)
            vertices.append(compiled.vertices)
            shape_names.append(shape.name or f"{spec.name}/{k}")
            if spec.color is not None:
                colors[s] = spec.color if any(spec.color) else BLACK
            s += 1
    shape_kinds = {modules.kinds.ShapeKind(int(kind)).name for kind in shapes["kind"]}
    colored = any(spec.color is not None for spec in bodies)
    world = np.zeros((), world_parameter_dtype(dim))
    world["gravity"] = scene.gravity
    joints, joint_parameters, joint_states, rows = _compile_joints(scene, bodies)
    for side in ("body_a", "body_b"):
        models["jointed"][joints[side][joints["kind"] != JointKind["TARGET"]]] = 1
    return Model(
        dim=dim,
        trees=trees_of(models["kind"], joints, joint_parameters, dim),
        body_names=tuple(scene.bodies),
        joint_names=tuple(scene.joints),
        actuator_names=tuple(scene.actuators),
        sensor_names=tuple(scene.sensors),
        shape_names=tuple(shape_names),
        bodies=models,
        shapes=shapes,
        joints=joints,
        actuators=_compile_actuators(scene),
        sensors=_sensor_records(scene.sensors.values(), dim),
        sensor_rays=np.concatenate([np.zeros((0, dim)), *(spec.rays for spec in scene.sensors.values())]),
        exclusions=np.array(sorted(encode_exclusion(a, b) for a, b in scene.excluded), np.int64),
        nominal_world=world,
        nominal_bodies=nominal,
        nominal_shapes=sizes,
        nominal_joints=joint_parameters,
        nominal_rows=rows,
        nominal_vertices=np.concatenate(vertices) if vertices else np.zeros(0, modules.vertices.vertex_dtype()),
        start_bodies=start,
        start_joints=joint_states,
        updates=tuple((j, spec.update) for j, spec in enumerate(scene.joints.values()) if spec.update is not None),
        mass_given=np.array([spec.mass is not None for spec in bodies]),
        inertia_given=np.array([spec.inertia is not None for spec in bodies]),
        shape_colors=colors if colored else None,
        needs_vertices=not shape_kinds.isdisjoint(WITH_VERTICES),
        needs_fields="HEIGHTFIELD" in shape_kinds,
        needs_convex=not shape_kinds.isdisjoint(("CYLINDER", "HULL")),
    )


def _fill_body(spec: BodySpec, nominal: Array, start: Array) -> None:
    """Write mass, extent and initial state of one body to one-entry slices."""
    modules = dimension(spec.dim)
    mass, center, inertia, axes = mass_of(spec)
    if spec.kind == BodyKind.DYNAMIC:
        nominal["mass"] = mass
        nominal["inv_mass"] = 1.0 / mass if spec.enabled else 0.0
        nominal["inertia"] = inertia
        nominal["inv_inertia"] = 1.0 / inertia if spec.enabled else 0.0
    if spec.dim == 3:
        nominal["axes"] = axes if spec.kind == BodyKind.DYNAMIC else (1.0, 0.0, 0.0, 0.0)
    nominal["center"] = center
    nominal["linear_damping"] = spec.linear_damping
    nominal["angular_damping"] = spec.angular_damping
    nominal["gravity_scale"] = spec.gravity_scale
    solid = [shape for shape in spec.shapes if shape.solid and shape.mask != 0]
    nominal["extent"] = min((shape.extent() for shape in solid), default=np.inf)
    nominal["radius"] = max((modules.shapes.bounding_radius(shape, center) for shape in solid), default=0.0)
    nominal["enabled"] = spec.enabled
    start["position"] = spec.position + modules.initial_state.turned(spec, center)
    modules.initial_state.fill_pose(spec, start)
    if spec.kind != BodyKind.STATIC:
        start["velocity"] = np.hstack((spec.linear_velocity, spec.angular_velocity))


def _compile_joints(scene: SceneSpec, bodies: list[BodySpec]) -> tuple[Array, Array, Array, Array]:
    specs = list(scene.joints.values())
    models = np.zeros(len(specs), joint_model_dtype())
    dim = scene.dim
    kinds = JointKind
    parameters = np.zeros(len(specs), joint_parameter_dtype(dim))
    states = np.zeros(len(specs), joint_state_dtype(dim))
    rows = np.zeros(sum(len(spec.rows) for spec in specs), constraint_row_dtype(dim))
    actuated = {spec.joint for spec in scene.actuators.values()}
    torque = {spec.joint for spec in scene.actuators.values() if spec.mode == "torque"}
    first = 0
    for j, spec in enumerate(specs):
        model = models[j]
        model["kind"] = kinds[spec.kind.upper()]
        for name in ("body_a", "body_b", "joint_a", "joint_b", "locked", "coordinate", "motor_coordinate"):
            model[name] = getattr(spec, name)
        model["row_first"] = first
        model["row_count"] = spec.row_count
        model["driven"] = spec.kind == "target" or j in actuated or spec.update is not None
        model["effort_controlled"] = j in torque
        model["frame"] = spec.frame == "body"
        for row in spec.rows:
            for name, value in row.items():
                rows[first][name] = value
            first += 1
        _fill_joint(spec, bodies, parameters[j], states[j])
    models["repeats"] = repeats_of(specs, bodies)
    for j, spec in enumerate(specs):
        if spec.kind == "gear":
            coordinates = [_start_coordinate(specs[k], bodies, parameters[k]) for k in (spec.joint_a, spec.joint_b)]
            parameters[j]["reference_angle"] = coordinates[0] + spec.ratio * coordinates[1] + spec.offset
    return models, parameters, states, rows


PLAIN = (
    "lower", "upper", "limit_restitution", "limit_frequency", "limit_damping_ratio", "frequency", "damping_ratio",
    "stiffness", "damping", "spring_effort", "motor_effort", "motor_gain", "friction_effort", "armature", "max_force",
    "max_torque", "ratio", "rigid", "enabled",
)  # fmt: skip


def _fill_joint(spec: JointSpec, bodies: Sequence[BodySpec], parameters: Any, state: Any) -> None:
    """Write parameters and state of a joint; an anchor that was not given is at the world point of the other."""
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    point = anchor_of(spec, bodies)
    anchor_a = to_local(a, point) if spec.anchor_a is None else spec.anchor_a
    anchor_b = to_local(b, point) if spec.anchor_b is None else spec.anchor_b
    parameters["anchor_a"] = anchor_a
    parameters["anchor_b"] = anchor_b
    dimension(a.dim).initial_state.fill_reference(a, b, parameters, state)
    if a.dim == 3:
        parameters["frame"] = dimension(3).initial_state.rotation_in(a, spec.orientation)
    if spec.axis is not None:
        parameters["axis"] = to_local(a, a.position + spec.axis)
    for name in PLAIN:
        parameters[name] = getattr(spec, name)
    apart = to_world(b, anchor_b) - to_world(a, anchor_a)
    parameters["length"] = np.hypot.reduce(apart) if spec.length is None else spec.length
    state["motor_speed"] = spec.motor_speed
    state["rest"] = spec.rest
    state["target_position"] = point


def _start_coordinate(spec: JointSpec, bodies: list[BodySpec], parameters: Any) -> float:
    """Return the coordinate at the initial poses: 0, or the distance of a sliding joint's anchors along its axis."""
    if spec.axis is None or spec.kind == "hinge":
        return 0.0
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    apart = to_world(b, parameters["anchor_b"]) - to_world(a, parameters["anchor_a"])
    return float(np.dot(apart, np.asarray(spec.axis)))


def _compile_actuators(scene: SceneSpec) -> Array:
    actuators = np.zeros(len(scene.actuators), ACTUATOR_DTYPE)
    joints = list(scene.joints.values())
    for k, spec in enumerate(scene.actuators.values()):
        actuators[k] = (
            spec.joint,
            joints[spec.joint].body_b,
            spec.axis,
            int(ACTUATOR_MODES[spec.mode]),
            spec.lower,
            spec.upper,
            spec.gain,
            spec.offset,
        )
    return actuators


def _sensor_records(specs: Iterable[SensorSpec], dim: int) -> Array:
    """Return the records (sensor,) of sensor_dtype."""
    specs = list(specs)
    sensors = np.zeros(len(specs), sensor_dtype(dim))
    column = ray = 0
    for record, spec in zip(sensors, specs, strict=True):
        record["kind"] = SensorKind[spec.kind.upper()]
        record["column"] = column
        record["count"] = spec.width or len(spec.rays)
        record["ray_first"] = ray
        record["local_position"] = spec.position
        for name in ("body", "joint", "mask", "length", "subtract_gravity"):
            record[name] = getattr(spec, name)
        column += int(record["count"])
        ray += len(spec.rays)
    return sensors
