"""Scene -> Model: names become indices, shapes become records, densities become masses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .broadphase import encode_exclusion
from .dimension import PACKAGES, dimension
from .model import (
    ACTUATOR_DTYPE,
    ActuatorMode,
    Array,
    BodyKind,
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
from .sensors import sensor_rays, sensor_records

if TYPE_CHECKING:
    from .joint_spec import JointSpec
    from .scene import BodySpec, Scene

BASE_ROWS = {
    2: {"weld": 3, "target": 3, "revolute": 2, "prismatic": 2, "distance": 0, "wheel": 1, "gear": 1},
    3: {"weld": 6, "target": 6, "ball": 3, "distance": 0},
}
ACTUATOR_MODES = {"velocity": ActuatorMode.VELOCITY, "position": ActuatorMode.POSITION, "torque": ActuatorMode.TORQUE}
WITH_VERTICES = {2: ("POLYGON", "TERRAIN"), 3: ("HULL", "HEIGHTFIELD")}


def check_body(spec: BodySpec) -> None:
    """Refuse a body whose shapes or mass make no sense, naming it."""
    what = f"body {spec.name!r}"
    modules = dimension(spec.dim)
    for shape in spec.shapes:
        if not isinstance(shape, modules.shapes.Shape):
            raise ValueError(f"{what}: {_not_a_shape(shape, spec.dim)}.")
        try:
            modules.shapes.validate(shape, spec.dim)
        except ValueError as error:
            raise ValueError(f"{what}: {error}.") from None
        if not shape.solid and spec.kind == BodyKind.DYNAMIC:
            name = type(shape).__name__
            raise ValueError(f"{what}: a {name} belongs on a static or kinematic body.")
    if spec.kind != BodyKind.DYNAMIC:
        return
    if spec.mass is None and not modules.authored.solid_mass(spec.shapes)[0] > 0.0:
        raise ValueError(f"{what} is dynamic and needs a mass or a shape with density.")
    if not modules.authored.has_inertia(spec):
        raise ValueError(f"{what} is dynamic and needs an inertia or a shape with density.")


def _not_a_shape(shape: Any, dim: int) -> str:
    other = 5 - dim
    if type(shape).__module__ == f"{__package__}.{PACKAGES[other]}.shapes":
        return f"a {type(shape).__name__} of gsenv.solver.{PACKAGES[other]} has {other} dimensions, the scene {dim}"
    return f"{shape!r} is not a shape"


def compile_scene(scene: Scene) -> Model:
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
        models[b] = (int(spec.kind), int(spec.fast), 0, s, len(spec.shapes))
        _fill_body(spec, nominal[b : b + 1], start[b : b + 1])
        for k, shape in enumerate(spec.shapes):
            compiled = modules.shapes.shape_record(shape, sizes.dtype)
            sizes[s] = compiled.record
            shapes[s]["kind"] = int(shape.kind)
            shapes[s]["body"] = b
            shapes[s]["category"] = _int64(shape.category)
            shapes[s]["mask"] = _int64(shape.mask)
            shapes[s]["sensor"] = bool(shape.sensor)
            shapes[s]["vertex_first"] = vertex
            shapes[s]["vertex_count"] = len(compiled.vertices)
            vertex += len(compiled.vertices)
            vertices.append(compiled.vertices)
            shape_names.append(shape.name or f"{spec.name}/{k}")
            if spec.color is not None:
                colors[s] = spec.color
            s += 1
    with_vertices = [modules.shapes.ShapeKind[name] for name in WITH_VERTICES[dim]]
    colored = any(spec.color is not None for spec in bodies)
    world = np.zeros((), world_parameter_dtype(dim))
    world["gravity"] = scene.gravity
    joints, joint_parameters, joint_states, rows = _compile_joints(scene, bodies)
    for side in ("body_a", "body_b"):
        models["jointed"][joints[side][joints["kind"] != modules.joint_kinds["TARGET"]]] = 1
    return Model(
        dim=dim,
        body_names=tuple(scene.bodies),
        joint_names=tuple(scene.joints),
        actuator_names=tuple(scene.actuators),
        sensor_names=tuple(scene.sensors),
        shape_names=tuple(shape_names),
        bodies=models,
        shapes=shapes,
        joints=joints,
        actuators=_compile_actuators(scene),
        sensors=sensor_records(scene.sensors.values(), dim),
        sensor_rays=sensor_rays(scene.sensors.values()),
        exclusions=np.array(sorted(encode_exclusion(a, b) for a, b in scene.excluded), np.int64),
        nominal_world=world,
        nominal_bodies=nominal,
        nominal_shapes=sizes,
        nominal_joints=joint_parameters,
        nominal_rows=rows,
        nominal_vertices=np.concatenate(vertices) if vertices else np.zeros(0, modules.shapes.vertex_dtype()),
        start_bodies=start,
        start_joints=joint_states,
        updates=tuple((j, spec.update) for j, spec in enumerate(scene.joints.values()) if spec.update is not None),
        mass_given=np.array([spec.mass is not None for spec in bodies]),
        inertia_given=np.array([spec.inertia is not None for spec in bodies]),
        shape_colors=colors if colored else None,
        needs_vertices=bool(np.isin(shapes["kind"], with_vertices).any()),
    )


def _int64(bits: int) -> int:
    """Bits of a mask as a signed 64-bit number."""
    bits = int(bits) & (2**64 - 1)
    return bits - 2**64 if bits >= 2**63 else bits


def _fill_body(spec: BodySpec, nominal: Array, start: Array) -> None:
    """Mass, extent and authored state of one body, into one-entry slices."""
    modules = dimension(spec.dim)
    mass, center, inertia = modules.authored.mass_of(spec)
    if spec.kind == BodyKind.DYNAMIC:
        nominal["mass"] = mass
        nominal["inv_mass"] = 1.0 / mass if spec.enabled else 0.0
        modules.authored.fill_mass(spec, nominal, mass, inertia)
    elif spec.dim == 3:
        nominal["axes"][:, 0] = 1.0
    nominal["center"] = center
    nominal["linear_damping"] = spec.linear_damping
    nominal["angular_damping"] = spec.angular_damping
    nominal["gravity_scale"] = spec.gravity_scale
    solid = [shape for shape in spec.shapes if shape.solid and shape.mask != 0]
    nominal["extent"] = min((modules.shapes.extent(shape) for shape in solid), default=np.inf)
    nominal["radius"] = max((modules.shapes.bounding_radius(shape, center) for shape in solid), default=0.0)
    nominal["enabled"] = spec.enabled
    start["position"] = spec.position + modules.authored.turned(spec, center)
    modules.authored.fill_pose(spec, start)
    if spec.kind != BodyKind.STATIC:
        start["velocity"] = modules.authored.velocity_of(spec)


def _compile_joints(scene: Scene, bodies: list[BodySpec]) -> tuple[Array, Array, Array, Array]:
    specs = list(scene.joints.values())
    models = np.zeros(len(specs), joint_model_dtype())
    dim = scene.dim
    kinds = dimension(dim).joint_kinds
    parameters = np.zeros(len(specs), joint_parameter_dtype(dim))
    states = np.zeros(len(specs), joint_state_dtype(dim))
    rows = np.zeros(sum(len(spec.rows) for spec in specs), constraint_row_dtype(dim))
    wakes = {spec.joint for spec in scene.actuators.values()}
    torque = {spec.joint for spec in scene.actuators.values() if spec.mode == "torque"}
    first = 0
    for j, spec in enumerate(specs):
        model = models[j]
        model["kind"] = kinds[spec.kind.upper()]
        for name in ("body_a", "body_b", "joint_a", "joint_b"):
            model[name] = getattr(spec, name)
        model["row_first"] = first
        model["row_count"] = BASE_ROWS[dim].get(spec.kind, len(spec.rows))
        model["wakes"] = spec.kind == "target" or j in wakes or spec.update is not None
        model["torque"] = j in torque
        model["frame"] = spec.frame == "body"
        for row in spec.rows:
            for name, value in row.items():
                rows[first][name] = value
            first += 1
        _fill_joint(spec, bodies, parameters[j], states[j])
    for j, spec in enumerate(specs):
        if spec.kind == "gear":
            coordinates = [_start_coordinate(specs[k], bodies, parameters[k]) for k in (spec.joint_a, spec.joint_b)]
            parameters[j]["reference_angle"] = coordinates[0] + spec.ratio * coordinates[1]
    return models, parameters, states, rows


PLAIN = (
    "lower", "upper", "frequency", "damping_ratio", "stiffness", "damping", "spring_effort", "motor_effort",
    "max_force", "max_torque", "ratio", "rigid", "enabled",
)  # fmt: skip


def pin_of(spec: JointSpec, bodies: Sequence[BodySpec]) -> Array:
    """Where the joint holds on to body b in the world, m; what is not given of its anchors follows from that."""
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    if spec.anchor_b is not None:
        return to_world(b, spec.anchor_b)
    return b.position if spec.anchor_a is None else to_world(a, spec.anchor_a)


def _fill_joint(spec: JointSpec, bodies: Sequence[BodySpec], parameters: Any, state: Any) -> None:
    """Anchors that were not given follow from the one that was: both at one point of the world."""
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    point = pin_of(spec, bodies)
    anchor_a = local_point(a, point) if spec.anchor_a is None else spec.anchor_a
    anchor_b = local_point(b, point) if spec.anchor_b is None else spec.anchor_b
    parameters["anchor_a"] = anchor_a
    parameters["anchor_b"] = anchor_b
    dimension(a.dim).authored.fill_reference(a, b, parameters, state)
    if spec.axis is not None:
        parameters["axis"] = local_point(a, a.position + spec.axis)
    for name in PLAIN:
        parameters[name] = getattr(spec, name)
    apart = to_world(b, anchor_b) - to_world(a, anchor_a)
    parameters["length"] = np.hypot.reduce(apart) if spec.length is None else spec.length
    state["motor_speed"] = spec.motor_speed
    state["rest"] = spec.rest
    state["target_position"] = point


def _start_coordinate(spec: JointSpec, bodies: list[BodySpec], parameters: Any) -> float:
    """q as authored: 0, or along the axis where the anchors of a prismatic joint are apart."""
    if spec.kind == "revolute":
        return 0.0
    a, b = bodies[spec.body_a], bodies[spec.body_b]
    apart = to_world(b, parameters["anchor_b"]) - to_world(a, parameters["anchor_a"])
    return float(np.dot(apart, np.asarray(spec.axis)))


def local_point(body: BodySpec, point: Array) -> Array:
    """A world point in the frame of a body at its authored pose."""
    turned_back: Array = dimension(body.dim).authored.turned_back(body, point - body.position)
    return turned_back


def to_world(body: BodySpec, point: Array) -> Array:
    turned: Array = dimension(body.dim).authored.turned(body, point)
    return body.position + turned


def _compile_actuators(scene: Scene) -> Array:
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
        )
    return actuators
