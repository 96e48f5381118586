"""Parameters: the quantities that may differ from world to world, set by name from checked values.

Reading gives read-only arrays, ``world.parameters.friction`` (world, shape); writing goes through
``set``, which derives masses again and refuses bad values before it changes anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from ..core import edit
from ..dimension import dimension
from ..records.model import Array, BodyKind, JointKind, Model
from ..records.parameters import ParameterArrays
from ..records.plain import as_records
from ..specification import check
from ..specification.handles import Handle, Reference, find
from ..specification.joint_base import SERVO
from ..specification.joints import JOINT_TYPES
from ..specification.solids import size_fields, solids
from .one_thread import OneThread, one_thread

of_world = one_thread("World")

BODY_FIELDS = ("mass", "inertia", "linear_damping", "angular_damping", "gravity_scale", "enabled")
OF_RANGES = frozenset(("mass", "density", "half_extents", "radius", "half_length"))  # of masses and sizes
PLAIN_FIELDS = ("linear_damping", "angular_damping", "gravity_scale")  # of bodies: nothing follows from them
SHAPE_FIELDS = ("friction", "restitution", "density", "half_extents", "radius", "half_length")
SPATIAL_FIELDS = ("torsional_friction", "rolling_friction")
JOINT_FIELDS = (
    "lower", "upper", "limit_restitution", "limit_frequency", "limit_damping_ratio", "length", "frequency",
    "damping_ratio", "stiffness", "damping", "spring_effort", "motor_effort", "motor_gain", "friction_effort",
    "armature", "max_force", "max_torque", "enabled",
)  # fmt: skip
ROW_FIELDS = ("lower", "upper", "bias", "softness")
UNBOUNDED = (  # may be infinite
    "max_force", "max_torque", "spring_effort", "motor_effort", "motor_gain", "friction_effort", "lower", "upper",
)  # fmt: skip


class Parameters(ParameterArrays):
    """Masses, sizes, materials, gains, gravity and ``enabled`` flags of N worlds.

    The structured arrays ``bodies``, ``shapes``, ``joints``, ``rows``, ``vertices`` (world, item)
    and ``worlds`` (world,) are for kernels; users call ``set``.
    """

    def __init__(
        self,
        model: Model,
        world_count: int,
        on_change: Callable[[Array, Iterable[str]], None] | None = None,
        use: OneThread | None = None,
    ) -> None:
        super().__init__(model, world_count)
        self._use = use or OneThread()
        self._dimension = dimension(model.dim)
        self._on_change = on_change  # called with the worlds and the names of the fields

    def __getattr__(self, name: str) -> Array:
        """Return the values of a field, (world, body), (world, shape) or (world, joint), read-only."""
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

    @of_world
    def set(self, item: Reference | None = None, *, worlds: Any = None, **fields: Any) -> None:
        """Set fields of a body (with all its shapes), of a shape, of a joint or of the world, in chosen worlds.

        Args:
            item: a handle, or a name: of a body, a joint or constraint, or a shape ("body/0" unless it was given
                one); or a body's index. None for ``gravity``.
            worlds: None for all, an int, ints or a bool mask.
            fields: one value, or one for each chosen world. Bodies: mass kg, inertia kg m^2 (in 3D (.., 3) about
                the principal axes), linear_damping 1/s, angular_damping 1/s, gravity_scale, enabled, friction,
                restitution, density kg/m^dim, half_extents (.., dim) m, radius m, half_length m, in 3D
                torsional_friction m and rolling_friction m. Shapes: friction, restitution, enabled, in 3D the
                two frictions; of a terrain vertices, m, (vertex, 2) or (chosen world, vertex, 2), as many as
                it has. Joints: lower and upper (limits, rad or m), limit_restitution, limit_frequency Hz,
                limit_damping_ratio, length m, frequency Hz, damping_ratio, stiffness, damping, spring_effort,
                motor_effort, motor_gain, friction_effort, armature, max_force N, max_torque N m, enabled (with all
                coordinates of the joint).
                Constraints: enabled, lower, upper, bias, softness. World: gravity (.., dim) m/s^2.

        A disabled body has no contacts and does not move; for its joints it is fixed. Once enabled it
        continues with its velocity, or with what ``set_velocity`` has set meanwhile.

        A new size or density changes the mass unless the scene gave it; a new mass scales the inertia
        unless that is given too. A mass that was set here counts as derived: a later change of size
        replaces it.

        Raises:
            ValueError: an unknown item or field, a NaN, or a value out of its range; nothing is changed.
        """
        chosen = check.worlds(worlds, len(self.worlds), "parameters: worlds")
        if not fields:
            raise ValueError("parameters: set needs at least one field, such as friction=0.5.")
        if item is None:
            unknown = set(fields) - {"gravity"}
            if unknown:
                raise ValueError(f"parameters: {sorted(unknown)[0]!r} needs a body, a shape or a joint.")
            dim = self._model.dim
            self.worlds["gravity"][chosen] = check.vectors(fields["gravity"], (len(chosen), dim), "parameters: gravity")
        else:
            what, index = self._find(item)
            {"body": self._set_body, "joint": self._set_joint, "shape": self._set_shape}[what](index, chosen, fields)
        if self._on_change is not None:
            self._on_change(chosen, fields)

    def _find(self, item: Reference) -> tuple[str, int]:
        """Return the kind of an item, "body", "joint" or "shape", and its index."""
        model = self._model
        names = {"body": model.body_names, "joint": model.joint_names, "shape": model.shape_names}
        if isinstance(item, Handle) and item.what in names:
            return item.what, find(item, item.what, names[item.what], "parameters")
        if not isinstance(item, str):
            return "body", find(item, "body", model.body_names, "parameters")
        kinds = [what for what, known in names.items() for name in known if name == item]
        if not kinds:
            check.choice(item, [name for known in names.values() for name in known], "parameters: item")
        if len(kinds) > 1:
            second = f"a {kinds[1]}" if kinds[1] != kinds[0] else f"another {kinds[1]}"
            raise ValueError(f"parameters: {item!r} names a {kinds[0]} and {second}; give a handle or rename one.")
        return kinds[0], names[kinds[0]].index(item)

    def _set_body(self, body: int, chosen: Array, fields: dict[str, Any]) -> None:
        where = f"parameters of body {self._model.body_names[body]!r}"
        checked = {}
        for name, value in fields.items():
            check.choice(name, self._body_fields, f"{where}: field")
            shape = self._field_shape(name, len(chosen))
            checker = check.flags if name == "enabled" else check.vectors if len(shape) > 1 else check.values
            checked[name] = _in_range(name, checker(value, shape, f"{where}: {name}"), where)
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
        for name, values in checked.items():
            if name in PLAIN_FIELDS:
                self.bodies[name][chosen, body] = values
            elif name in BODY_FIELDS:
                continue  # below: other fields follow
            elif name == "half_extents":
                self.shapes["size"][chosen, shapes.start] = values
            elif name == "half_length":
                axis = 0 if self._model.dim == 2 else 2
                self.shapes["size"][chosen, shapes.start, axis] = values
            else:
                for shape_index in shapes:
                    self.shapes[name][chosen, shape_index] = values
        with np.errstate(all="ignore"):
            self._set_mass(body, chosen, checked)
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

    def _set_shape(self, index: int, chosen: Array, fields: dict[str, Any]) -> None:
        where = f"parameters of shape {self._model.shape_names[index]!r}"
        known = ("friction", "restitution", "enabled", *(SPATIAL_FIELDS if self._model.dim == 3 else ("vertices",)))
        checked = {}
        for name, value in fields.items():
            check.choice(name, known, f"{where}: field")
            if name != "vertices":
                checker = check.flags if name == "enabled" else check.values
                checked[name] = _in_range(name, checker(value, (len(chosen),), f"{where}: {name}"), where)
        if "vertices" in fields:
            self._set_vertices(index, chosen, fields["vertices"], where)
        for name, values in checked.items():
            self.shapes[name][chosen, index] = values

    def _set_vertices(self, index: int, chosen: Array, vertices: Any, where: str) -> None:
        model = self._model.shapes[index]
        if model["kind"] != self._dimension.kinds.ShapeKind["TERRAIN"]:
            raise ValueError(f"{where}: only a terrain's vertices can be moved.")
        first, count = int(model["vertex_first"]), int(model["vertex_count"])
        places = check.values(vertices, (len(chosen), count, 2), f"{where}: vertices")
        nominal = self._model.nominal_vertices[first : first + count]
        closed = bool(nominal["next"][-1] >= 0)
        made = []
        for points in places:
            try:
                made.append(self._dimension.shapes.terrain_vertices(points, closed))
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
            if name not in size_fields(self._model.dim, kind):
                raise ValueError(f"{where}: its shape has no {name}.")

    def _set_mass(self, body: int, chosen: Array, checked: Mapping[str, Array]) -> None:
        """Set masses, inertias and flags, and all fields that follow from them and from sizes that were written."""
        model = self._model
        bodies, shapes = as_records(self.bodies), as_records(self.shapes)
        checked = {name: np.ascontiguousarray(values) for name, values in checked.items()}  # kernels: one layout
        keep_inertia = "inertia" in checked or bool(model.inertia_given[body])
        resized = not {"half_extents", "radius", "half_length", "density"}.isdisjoint(checked)
        if "mass" in checked:
            edit.set_masses(chosen, bodies, body, checked["mass"], keep_inertia or resized)
        if resized:
            made = as_records(solids(model, self.shapes, body, chosen))
            keep_mass = "mass" in checked or bool(model.mass_given[body])
            shape = int(model.bodies["shape_first"][body])
            edit.fit_solids(chosen, bodies, shapes, body, shape, made, keep_mass, keep_inertia)
        if "inertia" in checked:
            edit.set_inertias(chosen, bodies, body, checked["inertia"])
        if "enabled" in checked:
            edit.set_enabled(chosen, bodies, body, checked["enabled"])

    def _set_joint(self, index: int, chosen: Array, fields: dict[str, Any]) -> None:
        where = f"parameters of joint {self._model.joint_names[index]!r}"
        model = self._model.joints[index]
        rows = self._rows_of(model)
        kinds = JointKind
        kind = kinds(int(model["kind"])).name.lower()
        known = ROW_FIELDS if len(rows) else SERVO if kind == "axis" else JOINT_TYPES[kind].tunable
        self._check_spin(model, where)
        checked = {}
        for name, value in fields.items():
            check.choice(name, (*known, "enabled"), f"{where}: field")
            if len(rows) == 1 and name in ROW_FIELDS and np.ndim(value) == 1:
                value = np.reshape(value, (-1, 1))  # one for each world
            shape = (len(chosen), len(rows)) if len(rows) and name in ROW_FIELDS else (len(chosen),)
            checker = check.flags if name == "enabled" else check.bounds if name in UNBOUNDED else check.values
            checked[name] = _in_range(name, checker(value, shape, f"{where}: {name}"), where)
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
        if "enabled" in checked:
            for part in self._model.parts_of(index):
                self.joints["enabled"][chosen, part] = checked["enabled"]

    def _check_spin(self, model: Any, where: str) -> None:
        """Refuse the rotation of a wheel, which has the motor of the wheel itself."""
        wheel = self._model.joints[model["joint_a"]]
        if model["kind"] == JointKind["AXIS"] and wheel["kind"] == JointKind["WHEEL"]:
            if model["coordinate"] == wheel["motor_coordinate"]:
                name = self._model.joint_names[int(model["joint_a"])]
                raise ValueError(f"{where}: the rotation of a wheel is set by the wheel's own name, {name!r}.")

    def _check_spring(self, model: Any, index: int, chosen: Array, checked: dict[str, Array], where: str) -> None:
        """Refuse values that would make a rod a spring; springs can be tuned, and a weld can become soft.

        As in a scene, a spring has a frequency or a stiffness and damping, and no distance is negative.
        """
        softer = [name for name in ("frequency", "stiffness", "damping") if (checked.get(name, 0.0) * np.ones(1)).any()]
        distance = model["kind"] == JointKind["DISTANCE"]
        if softer and distance and self._model.nominal_joints["rigid"][index]:
            raise ValueError(f"{where}: {softer[0]} needs a spring, and it is a rod.")
        record = self.joints[chosen, index]
        f, k, c = (checked.get(name, record[name]) for name in ("frequency", "stiffness", "damping"))
        if softer and ((f > 0.0) & ((k > 0.0) | (c > 0.0))).any():
            raise ValueError(f"{where}: its spring has a frequency or a stiffness and damping; set the other to 0.")
        if distance and (checked.get("upper", np.zeros(1)) < 0.0).any():
            raise ValueError(f"{where}: a distance can't be below {float(checked['upper'].min())!r}.")

    def checked_rows(self, joint: int, values: Any) -> tuple[range, dict[str, Array]]:
        """Return the values of an update function for a constraint's rows as arrays (world, row, ...).

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
            checker = check.bounds if name in ("lower", "upper") else check.values
            checked[name] = checker(value, shape, f"{where}: {name}")
        if (checked.get("softness", np.zeros(1)) < 0.0).any():
            raise ValueError(f"{where}: softness must not be negative.")
        old = self.rows[:, rows.start : rows.stop]
        check.ordered_bounds(checked.get("lower", old["lower"]), checked.get("upper", old["upper"]), where)
        return rows, checked

    def write_rows(self, rows: range, values: Mapping[str, Array]) -> None:
        """Write checked values to the rows of a constraint, in all worlds."""
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


def _in_range(name: str, values: Array, where: str) -> Array:
    positive = ("mass", "inertia", "half_extents", "radius", "half_length", "motor_gain")
    free = ("gravity_scale", "enabled", "lower", "upper", "bias")
    if name in positive and (values <= 0.0).any():
        raise ValueError(f"{where}: {name} must be positive, got {float(values.min())!r}.")
    if name in positive and (values < check.SMALLEST).any():
        raise ValueError(f"{where}: {name} must be at least {check.SMALLEST:g}, got {float(values.min())!r}.")
    if name not in free and (values < 0.0).any():
        raise ValueError(f"{where}: {name} must not be negative, got {float(values.min())!r}.")
    if name.endswith("restitution") and (values > 1.0).any():
        raise ValueError(f"{where}: {name} must not exceed 1, got {float(values.max())!r}.")
    return values != 0 if name == "enabled" else values


def _frozen(array: Array) -> Array:
    view = array.view()
    view.flags.writeable = False
    return view
