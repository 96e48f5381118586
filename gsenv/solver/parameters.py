"""Parameters: what may differ from world to world, set by name and always from checked values.

Reading gives read-only arrays, ``world.parameters.friction`` (world, shape); writing goes through
``set``, which derives masses anew and refuses bad values before it changes anything.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from collections.abc import Set as AbstractSet
from typing import Any

import numpy as np

from . import check
from .dimension import dimension
from .joint_spec import fields_of
from .model import Array, BodyKind, Model
from .planar.shapes import TERRAIN, chain_vertices
from .planar.vertices import linked_vertices
from .scene import Handle, find

BODY_FIELDS = ("mass", "inertia", "linear_damping", "angular_damping", "gravity_scale", "enabled")
SHAPE_FIELDS = ("friction", "restitution", "density", "half_extents", "radius", "half_length")
SPATIAL_FIELDS = ("torsional_friction", "rolling_friction")
JOINT_FIELDS = (
    "lower", "upper", "length", "frequency", "damping_ratio", "stiffness", "damping", "spring_effort",
    "motor_effort", "max_force", "max_torque", "enabled",
)  # fmt: skip
ROW_FIELDS = ("lower", "upper", "bias", "softness")
UNBOUNDED = ("max_force", "max_torque", "spring_effort", "motor_effort", "lower", "upper")  # may be infinite


class Parameters:
    """Masses, sizes, materials, gains, gravity and ``enabled`` flags of N worlds.

    The structured arrays ``bodies``, ``shapes``, ``joints``, ``rows``, ``vertices`` (world, item)
    and ``worlds`` (world,) are for kernels that know what they do; users call ``set``.
    """

    def __init__(self, model: Model, world_count: int, on_change: Callable[[Array], None] | None = None) -> None:
        self._model = model
        self._dimension = dimension(model.dim)
        self._on_change = on_change  # told which worlds to wake
        self.worlds = _tiled(model.nominal_world[None], world_count)[:, 0]
        self.bodies = _tiled(model.nominal_bodies, world_count)
        self.shapes = _tiled(model.nominal_shapes, world_count)
        self.joints = _tiled(model.nominal_joints, world_count)
        self.rows = _tiled(model.nominal_rows, world_count)
        self.vertices = _tiled(model.nominal_vertices, world_count)

    def __getattr__(self, name: str) -> Array:
        """(world, body), (world, shape) or (world, joint) values of a field, read-only."""
        if name.startswith("_"):
            raise AttributeError(name)
        if name in ("mass", "inertia", "linear_damping", "angular_damping", "gravity_scale"):
            return _frozen(self.bodies[name])
        if name == "enabled":
            return _frozen(self.bodies[name] != 0)
        if name in ("friction", "restitution", "density", "radius", *SPATIAL_FIELDS) and (
            name in (self.shapes.dtype.names or ())
        ):
            return _frozen(self.shapes[name])
        if name == "half_extents":
            return _frozen(self.shapes["size"])
        if name in JOINT_FIELDS:
            return _frozen(self.joints[name])
        if name == "gravity":
            return _frozen(self.worlds["gravity"])
        raise AttributeError(f"Parameters has no field {name!r}.")

    def set(self, item: Handle | str | None = None, worlds: Any = None, **fields: Any) -> None:
        """Set fields of a body (with all its shapes), of a joint or of the world, in chosen worlds.

        Args:
            item: a body's or joint's handle, or a body's name; None for ``gravity``.
            worlds: None for all, an int, ints or a bool mask.
            fields: one number, or one for each chosen world. Bodies: mass, inertia,
                linear_damping, angular_damping, gravity_scale, enabled, friction, restitution,
                density, half_extents (.., dim), radius, half_length, in 3D torsional_friction and
                rolling_friction (m), inertia (.., 3) about the principal axes. Joints: lower, upper
                (limits), length, frequency, damping_ratio, stiffness, damping, spring_effort,
                motor_effort, max_force, max_torque, enabled. Constraints: enabled, lower, upper, bias,
                softness. World: gravity (.., dim).

        A disabled body touches nothing and stands still; its joints hold on to it where it is. Its
        velocity, and what ``set_velocity`` sets meanwhile, is what it goes on with once enabled.

        A new size or density gives a new mass unless the mass was given; a new mass scales the
        inertia unless that is given too. A mass that was set here counts as derived: only one that the
        scene gave outlives a later change of size.

        Raises:
            ValueError: an unknown field, a NaN, or a value out of its range; nothing is changed.
        """
        chosen = check.worlds(worlds, len(self.worlds))
        if not fields:
            raise ValueError("parameters: there is no field to set.")
        if item is None:
            unknown = set(fields) - {"gravity"}
            if unknown:
                raise ValueError(f"parameters: {sorted(unknown)[0]!r} needs a body or a joint.")
            dim = self._model.dim
            self.worlds["gravity"][chosen] = check.values(fields["gravity"], (len(chosen), dim), "parameters: gravity")
        elif isinstance(item, Handle) and item.what == "joint":
            self._set_joint(item, chosen, fields)
        else:
            self._set_body(find(item, "body", self._model.body_names, "parameters"), chosen, fields)
        if self._on_change is not None:
            self._on_change(chosen)

    def _set_body(self, body: int, chosen: Array, fields: dict[str, Any]) -> None:
        where = f"parameters of body {self._model.body_names[body]!r}"
        checked = {}
        for name, value in fields.items():
            check.choice(name, self._body_fields, f"{where}: field")
            shape = self._field_shape(name, len(chosen))
            look = check.vectors if len(shape) > 1 else check.values
            checked[name] = _in_range(name, look(value, shape, f"{where}: {name}"), where)
        if self._model.dim == 3 and "inertia" in checked:
            for moments in checked["inertia"]:
                check.inertia(moments, f"{where}: inertia")
        model = self._model.bodies[body]
        shapes = range(model["shape_first"], model["shape_first"] + model["shape_count"])
        self._check_form(checked, shapes, where)
        if model["kind"] != BodyKind.DYNAMIC and {"mass", "inertia"} & set(checked):
            raise ValueError(f"{where}: only a dynamic body has a mass.")
        if model["kind"] == BodyKind.DYNAMIC and (checked.get("density", np.ones(1)) == 0.0).any():
            raise ValueError(f"{where}: density must be positive, got 0.0.")
        saved = self.bodies[chosen, body].copy(), self.shapes[chosen][:, shapes.start : shapes.stop].copy()
        old_mass = saved[0]["mass"]
        for name, values in checked.items():
            if name in BODY_FIELDS:
                self.bodies[name][chosen, body] = values
            elif name == "half_extents":
                self.shapes["size"][chosen, shapes.start] = values
            elif name == "half_length":
                axis = 0 if self._model.dim == 2 else 2
                self.shapes["size"][chosen, shapes.start, axis] = values
            else:
                for shape_index in shapes:
                    self.shapes[name][chosen, shape_index] = values
        with np.errstate(all="ignore"):
            self._derive(body, chosen, set(checked), old_mass)
        if model["kind"] == BodyKind.DYNAMIC and not self._sound(body, chosen):
            self.bodies[chosen, body] = saved[0]
            self.shapes[chosen[:, None], np.arange(shapes.start, shapes.stop)] = saved[1]
            raise ValueError(f"{where}: mass and inertia and their inverses must be finite and positive.")

    @property
    def _body_fields(self) -> tuple[str, ...]:
        return BODY_FIELDS + SHAPE_FIELDS + (SPATIAL_FIELDS if self._model.dim == 3 else ())

    def _field_shape(self, name: str, count: int) -> tuple[int, ...]:
        dim = self._model.dim
        wide = name == "half_extents" or (name == "inertia" and dim == 3)
        return (count, dim) if wide else (count,)

    def _sound(self, body: int, chosen: Array) -> bool:
        """Whether masses, inertias and their inverses are finite and positive."""
        record = self.bodies[chosen, body]
        with np.errstate(all="ignore"):
            numbers = [f(record[name]) for name in ("mass", "inertia") for f in (np.asarray, np.reciprocal)]
        return all(bool((np.isfinite(x) & (x > 0.0)).all()) for x in numbers)

    def set_shape(
        self,
        shape: str | int,
        worlds: Any = None,
        *,
        friction: Any = None,
        restitution: Any = None,
        enabled: Any = None,
        vertices: Any = None,
    ) -> None:
        """Set fields of one shape: by name ("body/0" unless it was given one) or index.

        Args:
            worlds: None for all, an int, ints or a bool mask.
            friction, restitution, enabled: one value, or one for each chosen world.
            vertices: m, (vertex, 2) or (chosen world, vertex, 2), new places of the vertices of a
                terrain, as many as it has.

        Raises:
            ValueError: an unknown shape, or a bad value; nothing is changed.
        """
        index = find(shape, "shape", self._model.shape_names, "parameters")
        where = f"parameters of shape {self._model.shape_names[index]!r}"
        chosen = check.worlds(worlds, len(self.worlds))
        given = {"friction": friction, "restitution": restitution, "enabled": enabled}
        checked = {
            name: _in_range(name, check.values(value, (len(chosen),), f"{where}: {name}"), where)
            for name, value in given.items()
            if value is not None
        }
        if vertices is not None:
            self._set_vertices(index, chosen, vertices, where)
        for name, value in checked.items():
            self.shapes[name][chosen, index] = value
        if self._on_change is not None:
            self._on_change(chosen)

    def _set_vertices(self, index: int, chosen: Array, vertices: Any, where: str) -> None:
        model = self._model.shapes[index]
        if self._model.dim != 2 or model["kind"] != TERRAIN:
            raise ValueError(f"{where}: only a terrain's vertices can be moved.")
        first, count = int(model["vertex_first"]), int(model["vertex_count"])
        places = check.values(vertices, (len(chosen), count, 2), f"{where}: vertices")
        nominal = self._model.nominal_vertices[first : first + count]
        closed = bool(nominal["next"][-1] >= 0)
        made = []
        for points in places:
            try:
                made.append(linked_vertices(chain_vertices(points, closed), closed, -1.0))
            except ValueError as error:
                raise ValueError(f"{where}: {error}") from None
        for w, one in zip(chosen, made, strict=True):
            self.vertices[w, first : first + count] = one

    def _check_form(self, checked: dict[str, Array], shapes: range, where: str) -> None:
        sized = {"half_extents", "radius", "half_length"} & set(checked)
        derived = sized | ({"density"} & set(checked))
        if derived and len(shapes) != 1:
            raise ValueError(f"{where}: {sorted(derived)[0]} needs a body with exactly one shape.")
        for name in sized:
            kind = int(self._model.shapes["kind"][shapes[0]])
            if name not in self._dimension.mass.SIZE_FIELDS.get(kind, ()):
                raise ValueError(f"{where}: its shape has no {name}.")

    def _derive(self, body: int, chosen: Array, names: AbstractSet[str], old_mass: Array) -> None:
        """What follows from sizes, densities, masses and flags."""
        resized = bool(names & {"half_extents", "radius", "half_length", "density"})
        model = self._model
        if resized:
            self._dimension.mass.derive_extent(model, self.shapes, self.bodies, body, chosen)
        if model.bodies["kind"][body] != BodyKind.DYNAMIC:
            return
        record = self.bodies[:, body]
        if resized:
            mass, inertia = self._dimension.mass.mass_of_body(model, self.shapes, body, chosen)
            if "mass" not in names and not model.mass_given[body]:
                record["mass"][chosen] = mass
            if "inertia" not in names and not model.inertia_given[body]:
                record["inertia"][chosen] = inertia * self._spread(record["mass"][chosen] / mass)
        elif "mass" in names and "inertia" not in names and not model.inertia_given[body]:
            record["inertia"][chosen] *= self._spread(record["mass"][chosen] / old_mass)
        enabled = record["enabled"][chosen] != 0
        record["inv_mass"][chosen] = np.where(enabled, 1.0 / record["mass"][chosen], 0.0)
        record["inv_inertia"][chosen] = np.where(self._spread(enabled), 1.0 / record["inertia"][chosen], 0.0)

    def _spread(self, values: Array) -> Array:
        """(world,) values to go with inertias."""
        return values if self._model.dim == 2 else values[:, None]

    def _set_joint(self, joint: Handle, chosen: Array, fields: dict[str, Any]) -> None:
        index = find(joint, "joint", self._model.joint_names, "parameters")
        where = f"parameters of joint {joint.name!r}"
        model = self._model.joints[index]
        rows = self._rows_of(model)
        kinds = self._dimension.joint_kinds
        kind = kinds(int(model["kind"])).name.lower()
        known = (*ROW_FIELDS, "enabled") if len(rows) else fields_of(kind)
        checked = {}
        for name, value in fields.items():
            check.choice(name, known, f"{where}: field")
            if len(rows) == 1 and name in ROW_FIELDS and np.ndim(value) == 1:
                value = np.reshape(value, (-1, 1))  # one for each world
            shape = (len(chosen), len(rows)) if len(rows) and name in ROW_FIELDS else (len(chosen),)
            look = check.bounds if name in UNBOUNDED else check.values
            checked[name] = _in_range(name, look(value, shape, f"{where}: {name}"), where)
        if model["kind"] == kinds["TARGET"] and (checked.get("frequency", np.ones(1)) == 0.0).any():
            raise ValueError(f"{where}: frequency must be positive, got 0.0.")
        self._check_spring(model, index, chosen, checked, where)
        record = self.rows[:, rows.start : rows.stop] if len(rows) else self.joints[:, index]
        if {"lower", "upper"} & set(checked):
            lower, upper = (checked.get(name, record[chosen][name]) for name in ("lower", "upper"))
            check.ordered_bounds(lower, upper, where)
        for name, values in checked.items():
            if len(rows) and name in ROW_FIELDS:
                record[name][chosen] = values
            else:
                self.joints[name][chosen, index] = values

    def _check_spring(self, model: Any, index: int, chosen: Array, checked: dict[str, Array], where: str) -> None:
        """Springs can be tuned, and a weld made soft; a joint does not become of another kind.

        As in a scene, a spring has a frequency or a stiffness and damping, and no distance is negative.
        """
        softer = [name for name in ("frequency", "stiffness", "damping") if (checked.get(name, 0.0) * np.ones(1)).any()]
        distance = model["kind"] == self._dimension.joint_kinds["DISTANCE"]
        if softer and distance and self._model.nominal_joints["rigid"][index]:
            raise ValueError(f"{where}: {softer[0]} needs a spring, and it is a rod.")
        record = self.joints[chosen, index]
        f, k, c = (checked.get(name, record[name]) for name in ("frequency", "stiffness", "damping"))
        if softer and ((f > 0.0) & ((k > 0.0) | (c > 0.0))).any():
            raise ValueError(f"{where}: its spring has a frequency or a stiffness and damping; set the other to 0.")
        if distance and (checked.get("upper", np.zeros(1)) < 0.0).any():
            raise ValueError(f"{where}: a distance can't be below {float(checked['upper'].min())!r}.")

    def checked_rows(self, joint: int, values: Any) -> tuple[range, dict[str, Array]]:
        """What an update function returned for a constraint's rows, as arrays (world, row, ...).

        Raises:
            ValueError: not a mapping, an unknown name, a NaN or a shape that does not fit.
        """
        where = f"update of constraint {self._model.joint_names[joint]!r}"
        if not isinstance(values, Mapping):
            raise ValueError(f"{where} must return a mapping of names to values, got {type(values).__name__}.")
        model = self._model.joints[joint]
        rows = self._rows_of(model)
        ndof = self.rows["jacobian_a"].shape[-1]
        width = ndof if model["body_a"] == model["body_b"] else 2 * ndof
        checked = {}
        for name, value in values.items():
            check.choice(name, ("jacobian", "error", *ROW_FIELDS), f"{where}: name")
            shape = (len(self.worlds), len(rows)) + ((width,) if name == "jacobian" else ())
            look = check.bounds if name in ("lower", "upper") else check.values
            checked[name] = look(value, shape, f"{where}: {name}")
        if (checked.get("softness", np.zeros(1)) < 0.0).any():
            raise ValueError(f"{where}: softness must not be negative.")
        old = self.rows[:, rows.start : rows.stop]
        check.ordered_bounds(checked.get("lower", old["lower"]), checked.get("upper", old["upper"]), where)
        return rows, checked

    def write_rows(self, rows: range, values: Mapping[str, Array]) -> None:
        """Checked values into the rows of a constraint, in all worlds."""
        chosen = self.rows[:, rows.start : rows.stop]
        ndof = chosen["jacobian_b"].shape[-1]
        for name, array in values.items():
            if name == "jacobian":
                chosen["jacobian_b"] = array[..., -ndof:]
                if array.shape[-1] > ndof:
                    chosen["jacobian_a"] = array[..., :ndof]
            else:
                chosen[name] = array

    def _rows_of(self, model: Any) -> range:
        first = int(model["row_first"])
        return range(first, first + int(model["row_count"])) if model["kind"] == 0 else range(0)

    def reset(self, chosen: Array) -> None:
        """The chosen worlds back to the nominal values."""
        model = self._model
        self.worlds[chosen] = model.nominal_world
        self.bodies[chosen] = model.nominal_bodies
        self.shapes[chosen] = model.nominal_shapes
        self.joints[chosen] = model.nominal_joints
        self.rows[chosen] = model.nominal_rows
        self.vertices[chosen] = model.nominal_vertices

    def arrays(self) -> dict[str, Array]:
        names = ("worlds", "bodies", "shapes", "joints", "rows", "vertices")
        return {name: getattr(self, name) for name in names}


def _in_range(name: str, values: Array, where: str) -> Array:
    positive = ("mass", "inertia", "half_extents", "radius", "half_length")
    free = ("gravity_scale", "enabled", "lower", "upper", "bias")
    if name in positive and (values <= 0.0).any():
        raise ValueError(f"{where}: {name} must be positive, got {float(values.min())!r}.")
    if name not in free and (values < 0.0).any():
        raise ValueError(f"{where}: {name} must not be negative, got {float(values.min())!r}.")
    if name == "restitution" and (values > 1.0).any():
        raise ValueError(f"{where}: restitution must not exceed 1, got {float(values.max())!r}.")
    return values != 0 if name == "enabled" else values


def _tiled(nominal: Array, count: int) -> Array:
    return np.broadcast_to(nominal, (count, *nominal.shape)).copy()


def _frozen(array: Array) -> Array:
    view = array.view()
    view.flags.writeable = False
    return view
