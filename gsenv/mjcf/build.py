"""From an MjcfModel to a Scene."""

from __future__ import annotations

import itertools
import math
import os
import warnings
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..solver.records.model import BodyKind
from ..solver.specification.axis_joints import Hinge, SixAxis, Slider
from ..solver.specification.joint_base import Axis
from ..solver.specification.joints import Ball, Gear, Weld
from ..solver.specification.scene import Scene
from .contact_bits import contact_bits, overruled
from .drives import Drive, Drives, drives_of
from .errors import MjcfError, MjcfWarning, Notes
from .frames import Pose
from .frictions import shape_frictions
from .inertia import rigid_inertias, rigid_roots
from .model import Body, Equality, Joint, MjcfModel
from .parse import parse_mjcf
from .scene_joints import LETTERS, Axes, Coordinate, axes_of, beside, orientation, servo
from .scene_sensors import Reading, add_sensors
from .scene_shapes import shape_of

BETWEEN = 1e-5  # mass of a body between joints, in that of the body itself
CHAINED = "its joints cross at an angle or apart, so bodies of 1/100,000 of its mass are put between them"
FREE_DAMPING = "damping, armature, stiffness and frictionloss of a free joint are ignored"
WELD_POSE = "a weld keeps the initial pose of its bodies, not another relpose"
GEARS = "the polynomial between these two joints is not supported"


@dataclass
class Names:
    """Where the parts of a model are in its scene.

    Attributes:
        bodies: of each body, the name of the scene's body, and its pose in that.
        joints: of each slide and hinge, by index, its coordinate in the scene.
        actuators: of each supported actuator, by index, its name in the scene.
        sensors: of each supported sensor, by index, where it is in the scene.
        holders: of each body on joints, by index, the scene's joints between it and its parent.
    """

    bodies: list[tuple[str, Pose]] = field(default_factory=list)
    joints: dict[int, Coordinate] = field(default_factory=dict)
    actuators: dict[int, str] = field(default_factory=dict)
    sensors: dict[int, Reading] = field(default_factory=dict)
    holders: dict[int, list[str]] = field(default_factory=dict)


def load_mjcf(source: str | os.PathLike[str]) -> Scene:
    """Return the scene that an MJCF file describes.

    Bodies, joints, actuators and sensors have the names of the file. A control means what it means in MuJoCo: a motor's
    torque is gear * control. The timestep of the file is ``parse_mjcf(source).simulation.timestep``.

    Args:
        source: a path, or XML text that starts with ``<``.

    Raises:
        MjcfError: a file that cannot be read, naming file, line and element.

    Warns:
        MjcfWarning: once for each topic that is not simulated as MuJoCo does, such as tendons.
    """
    model = parse_mjcf(source)
    notes = Notes()
    scene, _ = build_scene(model, notes)
    for sentence in (*model.warnings, *notes.sentences()):
        warnings.warn(sentence, MjcfWarning, stacklevel=2)
    return scene


def build_scene(model: MjcfModel, notes: Notes | None = None) -> tuple[Scene, Names]:
    """Return the scene of a model, and where the model's parts are in it.

    Args:
        notes: takes what is not honoured.

    Raises:
        MjcfError: a part that no scene can have, such as a plane on a moving body.
    """
    try:
        return _Builder(model, Notes() if notes is None else notes).build()
    except MjcfError:
        raise
    except OverflowError:
        raise MjcfError(f"{model.bodies[0].place}: a number of this model is too large to be simulated.") from None
    except ValueError as error:  # of the scene, which names body or joint
        raise MjcfError(str(error)) from None


class _Builder:
    def __init__(self, model: MjcfModel, notes: Notes) -> None:
        self.model = model
        self.notes = notes
        self.scene = Scene(3, gravity=model.simulation.gravity)
        self.names = Names()
        self.joints: dict[int, list[int]] = {}  # of each body that has joints
        for k, joint in enumerate(model.joints):
            self.joints.setdefault(joint.body, []).append(k)
        movers = [k for k, body in enumerate(model.bodies) if k in self.joints or body.mocap]
        self.roots = rigid_roots(model.bodies, movers)
        self.inertias = rigid_inertias(model.bodies, movers)
        self.drives = drives_of(model, notes)
        self.driven: dict[str, tuple[str, float, float, Drive]] = {}  # actuator: coordinate, sign, reference, drive

    def build(self) -> tuple[Scene, Names]:
        self._add_bodies()
        for body in sorted(self.joints):
            self._add_joints(body)
        self._add_actuators()
        for equality in self.model.equalities:
            self._add_equality(equality)
        self._exclude()
        add_sensors(self.scene, self.model, self.names, self.notes)
        return self.scene, self.names

    # ------------------------------------------------------------- bodies

    def _is_fixed(self, body: int) -> bool:
        return self.roots[body] == 0

    def _add_bodies(self) -> None:
        """Add a body of the scene for each that moves, with all that is attached to it, and for each fixed one."""
        model = self.model
        bits = contact_bits(model, self.notes)
        fixed = [self._is_fixed(geom.body) or model.bodies[self.roots[geom.body]].mocap for geom in model.geoms]
        frictions = shape_frictions(model, fixed, bits, self.notes)
        shapes: dict[int, list[Any]] = {}
        colors: dict[int, tuple[int, int, int]] = {}
        names: dict[int, str] = {}
        for index, body in enumerate(model.bodies):
            root = self.roots[index] or index
            names[index] = _unused(body.name or f"body {index}", names.values())
            pose = model.bodies[root].world_pose.inverse().then(body.world_pose)
            self.names.bodies.append((names[root], pose))
        for k, geom in enumerate(model.geoms):
            root = self.roots[geom.body] or geom.body
            if geom.kind in ("plane", "hfield") and not fixed[k]:
                moving = model.bodies[geom.body].name
                raise MjcfError(f"{geom.place}: a {geom.kind} belongs on a fixed or mocap body; {moving!r} moves.")
            material = {"friction": frictions[k], "category": bits[k][0], "mask": bits[k][1]}
            if geom.condim >= 4:
                material["torsional_friction"] = float(geom.friction[1])
            if geom.condim == 6:
                material["rolling_friction"] = float(geom.friction[2])
            place = self.names.bodies[geom.body][1].then(geom.pose)
            shapes.setdefault(root, []).append(shape_of(geom, model, place, material, self.notes))
            red, green, blue = (round(255 * min(max(float(c), 0.0), 1.0)) for c in geom.rgba[:3])
            colors.setdefault(root, (red, green, blue))
        for index, body in enumerate(model.bodies):
            if self.roots[index] in (0, index):
                self._add_body(names[index], index, body, shapes.get(index, []), colors.get(index))

    def _add_body(
        self, name: str, index: int, body: Body, shapes: list[Any], color: tuple[int, int, int] | None
    ) -> None:
        pose: dict[str, Any] = {"position": body.world_pose.position, "orientation": body.world_pose.orientation}
        if index not in self.joints:
            self.scene.add_body(name, "kinematic" if body.mocap else "static", shapes, color=color, **pose)
            return
        inertia = self.inertias[index]
        self.scene.add_body(
            name,
            "dynamic",
            shapes,
            mass=inertia.mass,
            inertia=0.5 * (inertia.tensor + inertia.tensor.T),
            center=inertia.center,
            gravity_scale=self._gravity_scale(index),
            color=color,
            **pose,
        )

    def _gravity_scale(self, root: int) -> float:
        """Return the share of its weight that a body bears, the mean over what is attached to it."""
        group = [body for body, other in zip(self.model.bodies, self.roots, strict=True) if other == root]
        total = sum(body.inertia.mass for body in group)
        return 1.0 - sum(body.inertia.mass * body.gravity_compensation for body in group) / total

    # ------------------------------------------------------------- joints

    def _add_joints(self, body: int) -> None:
        """Add the joints between a body and its parent."""
        numbers = self.joints[body]
        joints = [self.model.joints[k] for k in numbers]
        pose = self.model.bodies[body].world_pose
        first = joints[0]
        if first.kind == "free":
            if any((first.damping, first.armature, first.stiffness, first.friction_loss)):
                self.notes.add(FREE_DAMPING, _title(first))
            return
        axes = axes_of(joints, pose)
        parent, child = self._parent(body), self.names.bodies[body][0]
        pair = {"body_a": parent, "body_b": child, "collide": self._meets_parent(body)}
        if len(joints) == 1:
            holder = self._add_single(numbers[0], first, pair, pose)
        elif axes is not None:
            holder = self._add_six_axis(body, numbers, axes, pair)
        else:
            holder = self._add_chain(body, numbers, pair)
        self.names.holders[body] = [holder]
        for number, joint in zip(numbers, joints, strict=True):
            own = axes_of([joint], pose) if axes is None or len(joints) == 1 else axes
            for drive in self.drives.get(number, Drives()).beside:
                self._add_beside(drive, number, joint, own, numbers, pair)

    def _parent(self, body: int) -> str:
        return self.names.bodies[self.model.bodies[body].parent][0]

    def _meets_parent(self, body: int) -> bool:
        """Whether a body may touch its parent: in MuJoCo if the parent is fixed, or if a pair of geoms says so."""
        parent = self.model.bodies[body].parent
        if (min(parent, body), max(parent, body)) in overruled(self.model):
            return True
        return self._is_fixed(parent) or not self.model.simulation.parent_filter

    def _add_single(self, number: int, joint: Joint, pair: dict[str, Any], pose: Pose) -> str:
        """Add a joint with one coordinate, or a ball; returns its name."""
        name = self._joint_name(joint.name or f"joint {number}")
        arguments = {**pair, "anchor": pose.point(joint.position)}
        if joint.kind == "ball":
            spring: dict[str, Any] = {
                "stiffness": joint.stiffness,
                "damping": joint.damping,
                "friction_effort": joint.friction_loss,
            }
            if joint.limits is not None and self.model.simulation.limits and joint.limits[1] < math.pi:
                spring["angle"] = joint.limits[1]
            self.scene.add_joint(name, Ball(**arguments, **spring, armature=joint.armature))
            return name
        kind = Hinge if joint.kind == "hinge" else Slider
        options = servo(joint, 1.0, self.drives.get(number, Drives()), self.model.simulation.limits)
        self.scene.add_joint(name, kind(**arguments, axis=pose.axes @ joint.axis, **options))
        self._record(number, name, 1.0)
        return name

    def _add_six_axis(self, body: int, numbers: list[int], axes: Axes, pair: dict[str, Any]) -> str:
        """Add one joint with several coordinates; returns its name."""
        name = self._joint_name(self.names.bodies[body][0])
        options: dict[str, Any] = {}
        for number, (axis, sign) in zip(numbers, axes.places, strict=True):
            joint = self.model.joints[number]
            drives = self.drives.get(number, Drives())
            word = _word(joint, axis)
            options[word] = Axis(**servo(joint, sign, drives, self.model.simulation.limits))
            self._record(number, f"{name}/{word}", sign)
        self.scene.add_joint(name, SixAxis(**pair, **self._frame(body, numbers, axes), **options))
        return name

    def _frame(self, body: int, numbers: list[int], axes: Axes) -> dict[str, Any]:
        """Return anchor, orientation and order of a six-axis joint: the anchor is that of the hinges."""
        anchor = self.model.joints[numbers[-1]].position
        pose = self.model.bodies[body].world_pose
        return {"anchor": pose.point(anchor), "orientation": orientation(axes.frame), "order": axes.order}

    def _add_chain(self, body: int, numbers: list[int], pair: dict[str, Any]) -> str:
        """Add a joint for each, with small bodies between them; returns the name of the last."""
        model = self.model
        one = model.bodies[body]
        self.notes.add(CHAINED, f"{one.place}: body {one.name!r}")
        inertia = self.inertias[body]
        last, name = pair["body_a"], ""
        for number in numbers:
            joint = model.joints[number]
            target = pair["body_b"]
            if number != numbers[-1]:
                target = _unused(f"{pair['body_b']} {number - numbers[0] + 1}", self.scene.bodies)
                self.scene.add_body(
                    target,
                    mass=BETWEEN * inertia.mass,
                    inertia=np.full(3, BETWEEN * float(np.trace(inertia.tensor)) / 3.0),
                    position=one.world_pose.point(joint.position),
                    gravity_scale=0.0,
                )
            name = self._add_single(number, joint, {"body_a": last, "body_b": target}, one.world_pose)
            last = target
        if not pair["collide"]:
            self.scene.exclude(pair["body_a"], pair["body_b"])
        return name

    def _add_beside(
        self, drive: Drive, number: int, joint: Joint, axes: Axes | None, numbers: list[int], pair: dict[str, Any]
    ) -> None:
        """Add a drive as a joint of its own, which leaves all axes free and drives one."""
        if axes is None or len(axes.places) not in (1, len(numbers)):
            self.notes.add("further actuators of a joint that crosses others are ignored", _title(joint))
            return
        position = numbers.index(number) if len(axes.places) > 1 else 0
        axis, sign = axes.places[position]
        word = _word(joint, axis)
        free: dict[str, Any] = {letter: Axis() for letter in LETTERS} | {f"turn_{letter}": Axis() for letter in LETTERS}
        frame = self._frame(joint.body, numbers if len(axes.places) > 1 else [number], axes)
        name = self._joint_name(f"{drive.name} drive")
        self.scene.add_joint(name, SixAxis(**{**pair, "collide": True}, **frame, **(free | {word: beside(drive)})))
        self.driven[drive.name] = (f"{name}/{word}", sign, joint.reference, drive)
        self.names.holders[joint.body].append(name)

    def _joint_name(self, name: str) -> str:
        return _unused(name, self.scene.joints)

    def _record(self, number: int, name: str, sign: float) -> None:
        """Record where a coordinate and the drives on it are in the scene."""
        joint = self.model.joints[number]
        self.names.joints[number] = Coordinate(name, sign, joint.reference)
        drives = self.drives.get(number, Drives())
        for drive in (drives.motor, drives.spring):
            if drive is not None:
                self.driven[drive.name] = (name, sign, joint.reference, drive)

    # ------------------------------------------------------------- the rest

    def _add_actuators(self) -> None:
        for k, actuator in enumerate(self.model.actuators):
            name = actuator.name or f"actuator {k}"
            if name not in self.driven:
                continue
            coordinate, sign, reference, drive = self.driven[name]
            offset = drive.offset - (reference if drive.mode == "position" else 0.0)
            lower, upper = drive.limits
            self.scene.add_actuator(
                name,
                coordinate,
                mode=drive.mode,
                lower=lower,
                upper=upper,
                gain=sign * drive.gain,
                offset=sign * offset,
            )
            self.names.actuators[k] = name

    def _add_equality(self, equality: Equality) -> None:
        """Add a joint for an equality constraint."""
        title = f"{equality.place}: {equality.kind}" + (f" {equality.name!r}" if equality.name else "")
        name = self._joint_name(equality.name or f"{equality.kind} of {equality.first}")
        if equality.kind == "joint":
            self._add_gear(name, equality, title)
            return
        (a, at_a), (b, at_b) = self._end(equality.first, equality), self._end(equality.second, equality)
        if a == b or all(self.scene.bodies[one].kind != BodyKind.DYNAMIC for one in (a, b)):
            return
        common: dict[str, Any] = {"body_a": a, "body_b": b, "collide": True, "enabled": equality.active}
        if equality.kind == "connect":
            if not equality.of_sites:
                anchor = self._world_pose(equality.first).point(equality.anchor)
                self.scene.add_joint(name, Ball(**common, anchor=anchor))
            else:
                self.scene.add_joint(name, Ball(**common, anchor_a=at_a.position, anchor_b=at_b.position))
            return
        if equality.relative_pose is not None or equality.of_sites:
            self.notes.add(WELD_POSE, title)
        self.scene.add_joint(name, Weld(**common))

    def _end(self, name: str, equality: Equality) -> tuple[str, Pose]:
        """Return the scene's body of a body or site, and its pose in that."""
        model = self.model
        if equality.of_sites:
            site = next(site for site in model.sites if site.name == name)
            body, pose = self.names.bodies[site.body]
            return body, pose.then(site.pose)
        return self.names.bodies[self._number(name)]

    def _number(self, name: str) -> int:
        """Return the index of a body; an empty name is the world."""
        return next((k for k, body in enumerate(self.model.bodies) if body.name == name and name), 0)

    def _world_pose(self, name: str) -> Pose:
        return self.model.bodies[self._number(name)].world_pose

    def _add_gear(self, name: str, equality: Equality, title: str) -> None:
        numbers = {joint.name: k for k, joint in enumerate(self.model.joints) if joint.name}
        first, second = (self.names.joints.get(numbers.get(one, -1)) for one in (equality.first, equality.second))
        constant, slope, *others = equality.coefficients.tolist()
        alone = not equality.second or slope == 0.0  # the first joint is kept where it is
        if first is None or (not alone and second is None) or (equality.second and any(others)):
            self.notes.add(GEARS, title)
            return
        common: dict[str, Any] = {"offset": first.sign * constant, "collide": True, "enabled": equality.active}
        try:
            if alone or second is None:
                gear = Gear(first.joint, **common)
            else:
                gear = Gear(first.joint, second.joint, ratio=-slope * first.sign * second.sign, **common)
            self.scene.add_joint(name, gear)
        except ValueError as error:
            self.notes.add(f"the equality is ignored, {str(error).rstrip('.')}", title)

    def _exclude(self) -> None:
        for first, second in set(self.model.excludes) - overruled(self.model):
            a, b = self.names.bodies[first][0], self.names.bodies[second][0]
            if a != b:
                self.scene.exclude(a, b)


def _word(joint: Joint, axis: int) -> str:
    """Return the name of a coordinate of a six-axis joint."""
    return LETTERS[axis] if joint.kind == "slide" else f"turn_{LETTERS[axis]}"


def _title(joint: Joint) -> str:
    return f"{joint.place}: joint" + (f" {joint.name!r}" if joint.name else "")


def _unused(name: str, taken: Collection[str]) -> str:
    """Return a name, with a number where it is taken."""
    return next(
        one for one in itertools.chain([name], (f"{name} ({k})" for k in itertools.count(2))) if one not in taken
    )
