"""World: N worlds of one scene, side by side. The only stateful class of the solver."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from . import check, threads
from .check import ALL_BITS
from .diagnostics import Contacts, Diagnostics, contacts_of, diagnose
from .dimension import dimension
from .features import features_of
from .jit import entry
from .model import Array, Model
from .optional import as_records
from .options import Options
from .parameters import Parameters
from .scene import Handle, Scene, find
from .sensors import RayHits, cast_rays, read_sensors
from .state import Snapshot, State, Workspace, first_contact_capacity, take_snapshot

_Call = tuple[tuple[int, int], Callable[..., Any], tuple[Any, ...]]
OK, MORE_PAIRS, MORE_CONTACTS = 0, 1, 2  # what a step kernel says
_PRESENT = np.ones(1)  # as a kernel's argument: the scene has it; None: it lacks it


class World:
    """``world_count`` copies of a scene, stepped together.

    Args:
        scene: a Scene, or a Model that ``Scene.compile`` made.
        world_count: how many.
        threads: worlds are shared out over this many threads; the bits do not depend on it.
        options: how to step; or fidelity: "fast", "balanced" (the default) or "accurate".

    Attributes:
        control: float64 (world, actuator), read at each step; out-of-range values are clipped.
        parameters: what differs from world to world.
        state: structured arrays of all that changes.
        model: what is the same in all worlds.

    Raises:
        ValueError: bad arguments of any method, in one sentence; nothing is changed then.
    """

    def __init__(
        self,
        scene: Scene | Model,
        world_count: int = 1,
        threads: int = 1,
        options: Options | None = None,
        fidelity: str | None = None,
    ) -> None:
        if options is not None and fidelity is not None:
            raise ValueError("World: give options or a fidelity, not both; Options.preset has both.")
        self.world_count = check.whole(world_count, 1, "World: world_count")
        self.threads = min(check.whole(threads, 1, "World: threads"), self.world_count)
        if not isinstance(scene, (Scene, Model)):
            raise ValueError(f"World needs a Scene or a Model, got {scene!r}.")
        self.model = scene.compile() if isinstance(scene, Scene) else scene
        self._dimension = dimension(self.model.dim)
        self._features = features_of(self.model)
        self.parameters = Parameters(self.model, self.world_count, self._changed)
        capacity = first_contact_capacity(self.model)
        self.state = State(self.model, self.world_count, capacity)
        self.options = Options.preset(fidelity or "balanced") if options is None else options
        self._workspaces: list[Workspace] = []

    # ------------------------------------------------------------- stepping

    @property
    def options(self) -> Options:
        """May be replaced between steps."""
        return self._options

    @options.setter
    def options(self, options: Options) -> None:
        if not isinstance(options, Options):
            raise ValueError(f"World: options must be an Options, got {options!r}.")
        if options.solver == "newton" and self.model.dim == 3:
            raise ValueError("World: the newton solver is there in 2D only; 3D has pgs, nncg, subspace and soft.")
        self._options = options
        self._options_record = options.record()
        self._calls: list[_Call] = []
        self._entries: dict[tuple[bool, ...], Callable[..., Any]] = {}

    @property
    def control(self) -> Array:
        """float64 (world, actuator), writable; see the class."""
        return self.state.control

    @control.setter
    def control(self, values: Any) -> None:
        self.state.control[:] = check.values(values, self.state.control.shape, "World: control")

    @property
    def timestep(self) -> float:
        """s."""
        return self._options.timestep

    def step(self, count: int = 1) -> None:
        """Advance all worlds by ``count`` timesteps.

        Raises:
            ValueError: a control is NaN or infinite, or a bad count; nothing has moved.
            MemoryError: the contacts of a step don't fit into memory.
        """
        count = check.whole(count, 0, "step: count")
        if not np.isfinite(self.control).all():
            w, k = np.argwhere(~np.isfinite(self.control))[0]
            raise ValueError(
                f"control of actuator {self.model.actuator_names[k]!r} in world {w} must be "
                f"finite, got {self.control[w, k]!r}."
            )
        if not self.model.updates:
            self._advance(count)
            return
        for _ in range(count):
            self._update_constraints()
            self._advance(1)

    def _update_constraints(self) -> None:
        """Rows that functions of the user refresh before each step; nothing is changed if one is bad."""
        refreshed = [(j, update(self)) for j, update in self.model.updates]
        checked = [self.parameters.checked_rows(j, values) for j, values in refreshed]
        for rows, values in checked:
            self.parameters.write_rows(rows, values)

    def _advance(self, count: int) -> None:
        until = self.state.worlds["step"] + count
        calls = self._calls or self._prepare_calls()
        while True:
            if len(calls) == 1:
                (first, last), step, arguments = calls[0]
                results = [step(first, last, until, *arguments)]
            else:
                results = threads.run(
                    [partial(step, first, last, until, *arguments) for (first, last), step, arguments in calls]
                )
            if all(status == OK for status, _ in results):
                return
            self._grow(results)
            calls = self._prepare_calls()

    def _prepare_calls(self) -> list[_Call]:
        """Ranges of worlds, the kernel and its further arguments, one for each thread."""
        parts = threads.ranges(self.world_count, self.threads)
        while len(self._workspaces) < len(parts):
            self._workspaces.append(Workspace(self.model, self._features, self.state.contacts.shape[1]))
        model, parameters, state = self.model, self.parameters, self.state
        features = self._features
        jointed = features.joints
        shared = (
            self._options_record,
            model.bodies, model.shapes,
            model.joints if jointed else None,
            model.actuators if jointed else None,
            model.exclusions,
            parameters.worlds, parameters.bodies, parameters.shapes,
            parameters.joints if jointed else None,
            parameters.rows if jointed else None,
            parameters.vertices if features.vertices else None,
            state.worlds, state.bodies, state.contacts,
            state.joints if jointed else None,
            state.control,
        )  # fmt: skip
        bouncy = _PRESENT if features.all or parameters.shapes["restitution"].any() else None
        soft, newton = (_PRESENT if self._options.solver == name else None for name in ("soft", "newton"))
        until = state.worlds["step"] + 0
        self._calls = []
        for part, work in zip(parts, self._workspaces, strict=False):
            arguments = tuple(as_records(array) for array in (*shared, bouncy, soft, newton, *work.arrays()))
            lacks = tuple(array is None for array in arguments)  # decides all types
            if lacks not in self._entries:
                self._entries[lacks] = entry(self._dimension.step.step_worlds, *part, until, *arguments)
            self._calls.append((part, self._entries[lacks], arguments))
        return self._calls

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_calls": [], "_entries": {}}  # compiled code and views: made anew

    def _grow(self, results: list[tuple[int, int]]) -> None:
        """Larger buffers for the step that did not fit; it is then taken again."""
        for (status, needed), work in zip(results, self._workspaces, strict=False):
            if status == MORE_PAIRS:
                work.grow_pairs(2 * needed)
        contacts = max((n for s, n in results if s == MORE_CONTACTS), default=0)
        if contacts:
            self._grow_contacts(contacts + contacts // 2)

    def _grow_contacts(self, capacity: int) -> None:
        self.state.grow_contacts(capacity)
        for work in self._workspaces:
            work.grow_contacts(capacity)
        self._calls = []

    def reset(self, mask: Any = None, parameters: bool = True) -> None:
        """The chosen worlds back to the authored state.

        Args:
            mask: None for all, an int, ints or a bool mask.
            parameters: whether to put the parameters back to their nominal values as well.
        """
        chosen = check.worlds(mask, self.world_count, "reset: mask")
        if parameters:
            self.parameters.reset(chosen)
            self._calls = []
        self.state.reset(self.model, chosen)

    # ------------------------------------------------------------- reading

    @property
    def position(self) -> Array:
        """(world, body, dim) m, of the bodies' own frames; a copy, as all of these."""
        bodies = self.state.bodies
        turned = self._dimension.readings.rotated(bodies["rotation"], self.parameters.bodies["center"])
        return np.asarray(bodies["position"] - turned)

    @property
    def center_of_mass(self) -> Array:
        """(world, body, dim) m."""
        return self.state.bodies["position"].copy()

    @property
    def angle(self) -> Array:
        """(world, body) rad, not wrapped; in 2D."""
        if self.model.dim == 3:
            raise AttributeError("World: bodies in 3D have no angle; World.orientation has their quaternions.")
        return self.state.bodies["angle"].copy()

    @property
    def orientation(self) -> Array:
        """(world, body, 4) unit quaternions (w, x, y, z); in 3D."""
        if self.model.dim == 2:
            raise AttributeError("World: bodies in 2D have no orientation; World.angle has their angles.")
        return self.state.bodies["rotation"].copy()

    @property
    def linear_velocity(self) -> Array:
        """(world, body, dim) m/s, of the centres of mass."""
        return self.state.bodies["velocity"][..., : self.model.dim].copy()

    @property
    def angular_velocity(self) -> Array:
        """rad/s: (world, body), in 3D (world, body, 3) in the world's axes."""
        velocity = self.state.bodies["velocity"]
        return (velocity[..., 2] if self.model.dim == 2 else velocity[..., 3:]).copy()

    @property
    def asleep(self) -> Array:
        """(world, body) bool."""
        return self.state.bodies["asleep"] != 0

    @property
    def time(self) -> Array:
        """(world,) s since the last reset, at the present timestep."""
        return self.state.worlds["step"] * self._options.timestep

    def contacts(self, world: int = 0) -> Contacts:
        """Contacts of a world's last step; see Contacts."""
        index = check.worlds(check.whole(world, 0, "contacts: world"), self.world_count, "contacts: world")[0]
        return contacts_of(self.state, index)

    def diagnostics(self) -> Diagnostics:
        """How wrong the last step was, and the energies; see Diagnostics."""
        return diagnose(self.model, self.parameters, self.state)

    def sensor(self, sensor: Handle | str | int) -> Array:
        """(world, number) reading of a sensor; see Scene.add_sensor."""
        index = find(sensor, "sensor", self.model.sensor_names, "sensor")
        return read_sensors(self, index, index + 1)

    def sensors(self) -> Array:
        """(world, number) readings of all sensors side by side; Model.sensor_slices has the columns."""
        return read_sensors(self, 0, len(self.model.sensors))

    def cast_rays(
        self,
        origin: Any,
        direction: Any,
        length: Any,
        worlds: Any = None,
        mask: int = ALL_BITS,
        exclude: Handle | str | int | None = None,
    ) -> RayHits:
        """First hits of rays with the shapes as they are now; see RayHits.

        Disabled and sensor shapes are not seen. A ray that only touches a shape passes. A terrain is
        seen from its outside alone, but a start behind it by no more than the extent (smallest
        half-width) of body ``exclude`` is inside it.

        Args:
            origin: m, (2,), (ray, 2) or (chosen world, ray, 2).
            direction: likewise, of any length but 0.
            length: m, how far to look: one number, (ray,) or (chosen world, ray).
            worlds: None for all, an int, ints or a bool mask.
            mask: bits of the categories that are seen.
            exclude: a body that is not seen: the one that carries the rays.
        """
        if self.model.dim == 3:
            raise ValueError("cast_rays: rays are there in 2D only.")
        chosen = check.worlds(worlds, self.world_count, "cast_rays: worlds")
        carrier = -1 if exclude is None else find(exclude, "body", self.model.body_names, "cast_rays: exclude")
        return cast_rays(
            self.model, self.parameters, self.state, chosen, origin, direction, length, mask, carrier
        )

    def joint_coordinate(self, joint: Handle | str | int) -> Array:
        """(world,) rad since the authored pose (revolute), m along the axis (prismatic, wheel), m between
        the anchors (distance), or how far a gear is off.

        Raises:
            ValueError: an unknown joint, or one without a coordinate.
        """
        j = self._joint(joint, "joint_coordinate")
        return np.asarray(self._dimension.readings.coordinate(self.model, self.parameters, self.state, j))

    def joint_rate(self, joint: Handle | str | int) -> Array:
        """(world,) rad/s or m/s: how fast the coordinate changes."""
        j = self._joint(joint, "joint_rate")
        return np.asarray(self._dimension.readings.rate(self.model, self.parameters, self.state, j))

    def joint_reaction(self, joint: Handle | str | int) -> Array:
        """(world, ndof) mean force in N and torque in N m that the joint put on body_b at its anchor in the
        last step, motors, springs and limits included."""
        j = self._joint(joint, "joint_reaction")
        return np.asarray(self.state.joints["reaction"][:, j] / self._options.timestep)

    def _joint(self, joint: Handle | str | int, where: str) -> int:
        return find(joint, "joint", self.model.joint_names, where)

    # ------------------------------------------------------------- acting

    def apply_force(
        self,
        body: Handle | str | int,
        force: Any,
        point: Any = None,
        worlds: Any = None,
        torque: Any = None,
    ) -> None:
        """Add a force for the next step, held constant over it.

        Args:
            force: N, (dim,) or (chosen world, dim).
            point: m, world point it acts at; None is the centre of mass.
            torque: N m, on top; in 3D (3,) or (chosen world, 3).
        """
        b = find(body, "body", self.model.body_names, "apply_force")
        where = f"apply_force on body {self.model.body_names[b]!r}"
        chosen = check.worlds(worlds, self.world_count)
        n = len(chosen)
        dim = self.model.dim
        f = check.vectors(force, (n, dim), f"{where}: force")
        t = np.zeros((n, 2 * dim - 3))
        if torque is not None:
            t += self._spins(torque, n, f"{where}: torque").reshape(n, -1)
        with np.errstate(all="ignore"):
            if point is not None:
                arm = check.vectors(point, (n, dim), f"{where}: point") - self.state.bodies["position"][chosen, b]
                turn = arm[:, 0] * f[:, 1] - arm[:, 1] * f[:, 0] if dim == 2 else np.cross(arm, f)
                t += turn.reshape(n, -1)
            total = self.state.bodies["force"][chosen, b] + np.concatenate([f, t], 1)
        if not np.isfinite(total).all():
            raise ValueError(f"{where}: the sum of forces must be finite.")
        self.state.bodies["force"][chosen, b] = total
        self._wake(chosen, b)

    def set_pose(
        self,
        body: Handle | str | int,
        position: Any = None,
        angle: Any = None,
        worlds: Any = None,
        rotation: Any = None,
    ) -> None:
        """Put a body somewhere: position m (dim,) or (chosen world, dim), angle rad in 2D, in 3D rotation,
        a quaternion (w, x, y, z) or one for each chosen world."""
        b = find(body, "body", self.model.body_names, "set_pose")
        where = f"set_pose of body {self.model.body_names[b]!r}"
        chosen = check.worlds(worlds, self.world_count)
        shape = (len(chosen), self.model.dim)
        place = None if position is None else check.vectors(position, shape, f"{where}: position")
        turn = self._turn(angle, rotation, len(chosen), where)
        if place is None:
            place = np.array(self.position[chosen, b])
        record = self.state.bodies
        if turn is not None:
            if self.model.dim == 2:
                record["angle"][chosen, b] = turn
            record["rotation"][chosen, b] = [self._dimension.authored.rotation_of(one) for one in turn]
        center = self.parameters.bodies["center"][chosen, b]
        offset = self._dimension.readings.rotated(record["rotation"][chosen, b], center)
        record["position"][chosen, b] = place + offset
        self.state.forget_impulses(chosen, b)
        self._wake(chosen)

    def _spins(self, value: Any, count: int, what: str) -> Array:
        """Checked numbers (count,), or in 3D vectors (count, 3)."""
        return check.values(value, (count,), what) if self.model.dim == 2 else check.vectors(value, (count, 3), what)

    def _turn(self, angle: Any, rotation: Any, count: int, where: str) -> Array | None:
        """Checked angles (count,), or quaternions (count, 4)."""
        if self.model.dim == 2:
            if rotation is not None:
                raise ValueError(f"{where}: a body in 2D has an angle, not a rotation.")
            return None if angle is None else check.values(angle, (count,), f"{where}: angle")
        if angle is not None:
            raise ValueError(f"{where}: a body in 3D has a rotation (w, x, y, z), not an angle.")
        if rotation is None:
            return None
        turn = check.vectors(rotation, (count, 4), f"{where}: rotation")
        if not ((turn * turn).sum(-1) > 1e-24).all():
            raise ValueError(f"{where}: rotation must be a quaternion other than zero.")
        return turn

    def set_velocity(
        self, body: Handle | str | int, linear: Any = None, angular: Any = None, worlds: Any = None
    ) -> None:
        """Set velocities: linear m/s of the centre of mass, angular rad/s, in 3D (3,) in the world."""
        b = find(body, "body", self.model.body_names, "set_velocity")
        where = f"set_velocity of body {self.model.body_names[b]!r}"
        if self.model.bodies["kind"][b] == 0:
            raise ValueError(f"{where}: it is static.")
        chosen = check.worlds(worlds, self.world_count)
        n = len(chosen)
        dim = self.model.dim
        v = None if linear is None else check.vectors(linear, (n, dim), f"{where}: linear")
        w = None if angular is None else self._spins(angular, n, f"{where}: angular")
        if v is not None:
            self.state.bodies["velocity"][chosen, b, :dim] = v
        if w is not None:
            self.state.bodies["velocity"][chosen, b, dim:] = w.reshape(n, -1)
        self._wake(chosen, b)

    def set_motor(
        self, joint: Handle | str | int, speed: Any = None, rest: Any = None, worlds: Any = None
    ) -> None:
        """Set the speed of a joint's motor, rad/s or m/s, or where its spring is relaxed, rad or m."""
        j = self._joint(joint, "set_motor")
        where = f"set_motor of joint {self.model.joint_names[j]!r}"
        chosen = check.worlds(worlds, self.world_count)
        checked = {
            name: check.values(value, (len(chosen),), f"{where}: {word}")
            for name, word, value in (("motor_speed", "speed", speed), ("rest", "rest", rest))
            if value is not None
        }
        parameters = self.parameters.joints[:, j]
        if speed is not None and not (parameters["motor_effort"] > 0.0).any():
            raise ValueError(f"{where}: it has no motor.")
        if rest is not None and not ((parameters["frequency"] > 0.0) | (parameters["stiffness"] > 0.0)).any():
            raise ValueError(f"{where}: it has no spring.")
        for name, values in checked.items():
            self.state.joints[name][chosen, j] = values
        self._wake(chosen)

    def set_target(
        self,
        joint: Handle | str | int,
        position: Any = None,
        angle: Any = None,
        linear: Any = None,
        angular: Any = None,
        worlds: Any = None,
        rotation: Any = None,
    ) -> None:
        """Move a target joint's goal: position m, angle rad (in 3D rotation, a quaternion), and how fast it
        moves on by itself."""
        j = self._joint(joint, "set_target")
        where = f"set_target of joint {self.model.joint_names[j]!r}"
        if self.model.joints["kind"][j] != self._dimension.joint_kinds["TARGET"]:
            raise ValueError(f"{where}: it is not a target joint.")
        chosen = check.worlds(worlds, self.world_count)
        n, dim = len(chosen), self.model.dim
        place = None if position is None else check.vectors(position, (n, dim), f"{where}: position")
        turn = self._turn(angle, rotation, n, where)
        v = None if linear is None else check.vectors(linear, (n, dim), f"{where}: linear")
        w = None if angular is None else self._spins(angular, n, f"{where}: angular")
        record = self.state.joints
        if place is not None:
            record["target_position"][chosen, j] = place
        if turn is not None and dim == 2:
            record["target_angle"][chosen, j] = turn
        elif turn is not None:
            record["target_rotation"][chosen, j] = [self._dimension.authored.rotation_of(one) for one in turn]
        if v is not None:
            record["target_velocity"][chosen, j, :dim] = v
        if w is not None:
            record["target_velocity"][chosen, j, dim:] = w.reshape(n, -1)

    def _changed(self, chosen: Array) -> None:
        """Parameters are new: wake the worlds, and see anew what the scene has."""
        self._wake(chosen)
        self._calls = []

    def _wake(self, chosen: Array, body: int | None = None) -> None:
        """Wake a body, or all of the chosen worlds' bodies where what they rest on may change."""
        which = slice(None) if body is None else body
        for name in ("asleep", "sleep_time"):
            self.state.bodies[name][chosen, which] = 0

    # ------------------------------------------------------------- snapshots

    def save(self, worlds: Any = None) -> Snapshot:
        """A bit-exact copy of the chosen worlds' State and Parameters; picklable."""
        chosen = check.worlds(worlds, self.world_count)
        return take_snapshot(self.model, self.parameters, self.state, chosen)

    def restore(self, snapshot: Snapshot, worlds: Any = None) -> None:
        """Put saved worlds into the chosen ones; one saved world may fill many.

        Raises:
            ValueError: the snapshot is of another scene, or the counts don't match.
        """
        if not isinstance(snapshot, Snapshot):
            raise ValueError(f"restore needs a snapshot from save(), got {type(snapshot).__name__}.")
        chosen = check.worlds(worlds, self.world_count)
        snapshot.check(self.model, len(chosen))
        if snapshot.contact_capacity > self.state.contacts.shape[1]:
            self._grow_contacts(snapshot.contact_capacity)
        snapshot.write(self.parameters, self.state, chosen)
        self._calls = []

