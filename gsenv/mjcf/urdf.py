"""URDF files, read by yourdfpy, as an MjcfModel."""

from __future__ import annotations

import os
import warnings
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import numpy as np

from ..solver.records.model import Array
from ..solver.spatial.initial_state import rotation_from
from ..solver.specification.scene import Scene
from .build import build_scene
from .errors import MjcfError, MjcfWarning, Notes, Place
from .frames import Pose, from_z, identity
from .inertia import LEAST
from .mesh_files import read_mesh
from .model import (
    COORDINATES,
    NO_INERTIA,
    RATES,
    Actuator,
    Body,
    Equality,
    Geom,
    Inertia,
    Joint,
    Mesh,
    MjcfModel,
    Simulation,
)
from .reader import Element, read_document

KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")
FRICTION = (1.0, 0.005, 0.0001)  # MuJoCo's default: sliding, torsional, rolling
VELOCITY = "limits of joint velocities are ignored"


def load_urdf(source: str | os.PathLike[str]) -> Scene:
    """Return the scene that a URDF file describes; it needs yourdfpy: ``pip install gsenv[urdf]``.

    Links are bodies, and the root link is fixed to the world. Their collision geometry is that of the file: boxes,
    spheres, cylinders, and meshes (STL, OBJ) as hulls. A joint with a limit of effort gets a motor with its name, whose
    control is the torque in N m or the force in N. A joint that mimics another is geared to it.

    Args:
        source: a path, or XML text that starts with ``<``.

    Raises:
        MjcfError: a file that cannot be read, naming file, line and element.
        ImportError: yourdfpy is not installed.

    Warns:
        MjcfWarning: once for each topic that is not simulated, such as limits of velocity.
    """
    notes = Notes()
    model = parse_urdf(source, notes)
    scene, _ = build_scene(model, notes)
    for sentence in notes.sentences():
        warnings.warn(sentence, MjcfWarning, stacklevel=2)
    return scene


def parse_urdf(source: str | os.PathLike[str], notes: Notes | None = None) -> MjcfModel:
    """Return the model of a URDF file, for ``build_scene``; arguments and errors as for ``load_urdf``.

    Args:
        notes: takes what is not honoured.
    """
    document = read_document(source, "robot")
    _check(document.root)
    robot = _robot(document.root)
    return _Reader(robot, document.root, document.folder, Notes() if notes is None else notes).read()


def _load(data: bytes) -> Any:
    """Return yourdfpy's robot of URDF text."""
    try:
        import yourdfpy
    except ImportError:
        raise ImportError("load_urdf needs yourdfpy: pip install 'gsenv[urdf]'.") from None
    nothing = {"build_scene_graph": False, "load_meshes": False}
    with np.errstate(all="ignore"):  # numbers that are not finite are refused later
        return yourdfpy.URDF.load(BytesIO(data), **nothing).robot


def _robot(root: Element) -> Any:
    """Return yourdfpy's robot; raises MjcfError about the first link or joint that it cannot read."""
    try:
        return _load(_text(root).encode())
    except ImportError:
        raise
    except Exception as error:  # yourdfpy raises whatever float() or a missing attribute raises
        for child in root.children:
            if child.tag in ("link", "joint"):
                try:
                    _load(f'<robot name="x">{_text(child)}</robot>'.encode())
                except Exception as inner:
                    raise MjcfError(f"{child.title()}: {_reason(inner)}.") from None
        raise MjcfError(f"{root.title()}: {_reason(error)}.") from None


def _reason(error: Exception) -> str:
    return f"{error.args[0]} is missing" if isinstance(error, KeyError) else str(error).rstrip(".")


def _text(element: Element) -> str:
    """Return the XML text of an element, without what URDF does not have."""
    given = "".join(f" {name}={quoteattr(value)}" for name, value in element.attributes.items())
    inside = "".join(_text(child) for child in element.children if child.tag in READ)
    return f"<{element.tag}{given}>{inside}</{element.tag}>"


READ = frozenset(
    (
        "robot", "link", "joint", "inertial", "collision", "origin", "mass", "inertia", "geometry", "box", "sphere",
        "cylinder", "mesh", "parent", "child", "axis", "limit", "dynamics", "mimic",
    )
)  # fmt: skip


def _check(root: Element) -> None:
    """Raise MjcfError about the first link or joint that lacks what all of them have, or has it twice."""
    root.attributes.setdefault("name", "robot")
    seen: set[tuple[str, str]] = set()
    for element in root.children:
        if element.tag not in ("link", "joint"):
            continue
        name = element.attributes.get("name")
        if not name:
            raise MjcfError(f"{element.place}: {element.tag}: name is missing.")
        if (element.tag, name) in seen:
            raise MjcfError(f"{element.title()}: the name is given twice.")
        seen.add((element.tag, name))
        if element.tag == "joint":
            kind = element.attributes.get("type", "")
            if kind not in KINDS:
                raise MjcfError(f"{element.title()}: type must be one of {', '.join(KINDS)}, got {kind!r}.")
            for end in ("parent", "child"):
                link = next((one.attributes.get("link") for one in element.find_all(end)), None)
                if link is None or not any(o.tag == "link" and o.attributes.get("name") == link for o in root.children):
                    raise MjcfError(f"{element.title()}: {end} must name a link, got {link!r}.")
        for collision in element.find_all("collision"):
            shapes = [one.tag for geometry in collision.find_all("geometry") for one in geometry.children]
            if len(shapes) != 1 or shapes[0] not in ("box", "sphere", "cylinder", "mesh"):
                raise MjcfError(f"{collision.place}: collision of {name!r}: geometry must be one of box, sphere, "
                                f"cylinder and mesh, got {' and '.join(shapes) or 'none'}.")  # fmt: skip


class _Reader:
    def __init__(self, robot: Any, root: Element, folder: Path, notes: Notes) -> None:
        self.robot = robot
        self.folder = folder
        self.notes = notes
        self.elements = {(one.tag, one.attributes.get("name")): one for one in root.children}
        world = Body("world", -1, identity(), identity(), NO_INERTIA, 0.0, False, root.place)
        self.model = MjcfModel(robot.name, Simulation(), [world], [], [], [], [], {}, {})

    def read(self) -> MjcfModel:
        """Return the model, its bodies depth first."""
        for link, joint, parent in self._tree():
            element = self.elements["link", link.name]
            pose = identity() if joint is None else self._pose(joint.origin, self.elements["joint", joint.name])
            inertia = self._inertia(link, element)
            world_pose = self.model.bodies[parent].world_pose.then(pose)
            self.model.bodies.append(Body(link.name, parent, pose, world_pose, inertia, 0.0, False, element.place))
            index = len(self.model.bodies) - 1
            for k, collision in enumerate(link.collisions):
                place = list(element.find_all("collision"))[k].place
                self.model.geoms.append(self._geom(collision, index, link.name, place))
            if joint is not None and joint.type != "fixed":
                if inertia.mass < LEAST and not self._carries(link.name):
                    raise MjcfError(f"{element.title()}: it moves, and needs an inertial with a positive mass.")
                self._add_joints(joint, index)
        for joint in self.robot.joints:
            if joint.mimic is not None:
                self._add_mimic(joint)
        return self.model

    def _tree(self) -> Iterator[tuple[Any, Any, int]]:
        """Yield each link with its joint and the index of its parent body, depth first."""
        links = {link.name: link for link in self.robot.links}
        below: dict[str, list[Any]] = {name: [] for name in links}
        above: dict[str, str] = {}
        for joint in self.robot.joints:
            if joint.child in above:
                title = self.elements["joint", joint.name].title()
                raise MjcfError(f"{title}: link {joint.child!r} is the child of joint {above[joint.child]!r} already.")
            above[joint.child] = joint.name
            below[joint.parent].append(joint)
        roots = [name for name in links if name not in above]
        place = self.model.bodies[0].place
        if len(roots) != 1:
            raise MjcfError(f"{place}: the links must form one tree, got {len(roots)} links without a parent.")
        waiting: list[tuple[str, Any, int]] = [(roots[0], None, 0)]
        count = 0
        while waiting:
            name, joint, parent = waiting.pop()
            yield links[name], joint, parent
            index = len(self.model.bodies) - 1
            count += 1
            waiting += [(child.child, child, index) for child in reversed(below[name])]
        if count < len(links):
            raise MjcfError(f"{place}: the links must form one tree, but some of them form a loop.")

    def _carries(self, link: str) -> bool:
        """Whether links with a mass are fixed to a link."""
        fixed = [joint.child for joint in self.robot.joints if joint.parent == link and joint.type == "fixed"]
        masses = {one.name: one.inertial.mass or 0.0 for one in self.robot.links if one.inertial is not None}
        return any(masses.get(name, 0.0) > 0.0 or self._carries(name) for name in fixed)

    def _finite(self, values: Any, element: Element, what: str) -> Array:
        numbers = np.asarray(values, float)
        if not np.isfinite(numbers).all():
            raise MjcfError(f"{element.title()}: {what} must be finite.")
        return numbers

    def _pose(self, matrix: Any, element: Element) -> Pose:
        if matrix is None:
            return identity()
        given = self._finite(matrix, element, "origin")
        return Pose(given[:3, 3], rotation_from(given[:3, :3]))

    def _inertia(self, link: Any, element: Element) -> Inertia:
        if link.inertial is None or not link.inertial.mass:
            return NO_INERTIA
        if link.inertial.inertia is None or link.inertial.mass < 0.0:
            raise MjcfError(f"{element.title()}: its inertial needs a positive mass and an inertia.")
        pose = self._pose(link.inertial.origin, element)
        tensor = self._finite(link.inertial.inertia, element, "inertia")
        return Inertia(float(link.inertial.mass), pose.position, pose.axes @ tensor @ pose.axes.T)

    def _geom(self, collision: Any, body: int, link: str, place: Place) -> Geom:
        given = collision.geometry
        element = Element("collision", {"name": collision.name or link}, place)
        asset, kind, size = "", "box", np.zeros(3)
        if given.box is not None:
            size = 0.5 * np.asarray(given.box.size, float)
        elif given.sphere is not None:
            kind, size = "sphere", np.array([given.sphere.radius, 0.0, 0.0])
        elif given.cylinder is not None:
            kind, size = "cylinder", np.array([given.cylinder.radius, 0.5 * given.cylinder.length, 0.0])
        else:
            kind, asset = "mesh", self._mesh(given.mesh, element)
        used = {"box": 3, "sphere": 1, "cylinder": 2, "mesh": 0}[kind]
        if size.shape != (3,) or not (np.isfinite(size).all() and (size[:used] > 0.0).all()):
            raise MjcfError(f"{element.title()}: the sizes of its {kind} must be positive and finite.")
        return Geom(
            collision.name or "", kind, body, self._pose(collision.origin, element), size, NO_INERTIA, 0, 1, 1, 3,
            np.array(FRICTION), np.array([0.5, 0.5, 0.5, 1.0]), asset, place,
        )  # fmt: skip

    def _mesh(self, mesh: Any, element: Element) -> str:
        """Add the mesh of a file to the model; returns its name."""
        name = mesh.filename or ""
        inside = name.split("://", 1)[1].partition("/")[2] if name.startswith("package://") else name
        folders = [self.folder, *self.folder.absolute().parents] if inside != name else [self.folder]
        path = next((folder / inside for folder in folders if (folder / inside).is_file()), self.folder / inside)
        try:
            vertices, faces = read_mesh(path)
        except OSError as error:
            raise MjcfError(f"{element.title()}: the file {name!r} cannot be read: {error.strerror}.") from None
        except ValueError as error:
            found = f" ({path})" if inside != name else ""  # it may be another than the author meant
            raise MjcfError(f"{element.title()}: the file {name!r}{found} {error}.") from None
        scale = np.broadcast_to(1.0 if mesh.scale is None else np.asarray(mesh.scale, float), 3)
        key = f"{name} {len(self.model.meshes)}"
        self.model.meshes[key] = Mesh(key, vertices * scale, faces, "convex", element.place)
        return key

    def _add_joints(self, joint: Any, body: int) -> None:
        """Add the joint of a link, of a planar one three."""
        element = self.elements["joint", joint.name]
        axis = self._finite(joint.axis, element, "axis")
        length = float(np.linalg.norm(axis))
        if axis.shape != (3,) or not length > 0.0:
            raise MjcfError(f"{element.title()}: axis must be three numbers, not all 0.")
        axis = axis / length
        if joint.type == "floating":
            if self.model.bodies[body].parent > 1:
                raise MjcfError(f"{element.title()}: only a child of the root link can be floating.")
            self._add_joint(joint, "free", joint.name, body, axis)
        elif joint.type == "planar":
            frame = Pose(np.zeros(3), from_z(axis)).axes
            self._add_joint(joint, "slide", f"{joint.name} x", body, frame[:, 0])
            self._add_joint(joint, "slide", f"{joint.name} y", body, frame[:, 1])
            self._add_joint(joint, "hinge", f"{joint.name} turn", body, axis)
        else:
            self._add_joint(joint, "slide" if joint.type == "prismatic" else "hinge", joint.name, body, axis)

    def _add_joint(self, joint: Any, kind: str, name: str, body: int, axis: Array) -> None:
        element = self.elements["joint", joint.name]
        limit = joint.limit
        limits = None
        if joint.type in ("revolute", "prismatic"):
            if limit is None or (limit.lower is None and limit.upper is None):
                raise MjcfError(f"{element.title()}: a {joint.type} joint needs a limit with lower and upper.")
            lower, upper = self._finite([limit.lower or 0.0, limit.upper or 0.0], element, "its limits").tolist()
            if lower > upper:
                raise MjcfError(f"{element.title()}: its lower limit {lower:g} is above its upper one, {upper:g}.")
            limits = (lower, upper)
        effort = 0.0 if limit is None or limit.effort is None else float(limit.effort)
        if limit is not None and limit.velocity:
            self.notes.add(VELOCITY, element.title())
        damping, friction = (self._dynamics(joint, word, element) for word in ("damping", "friction"))
        last = self.model.joints[-1] if self.model.joints else None
        coordinate = 0 if last is None else last.coordinate + COORDINATES[last.kind]
        rate = 0 if last is None else last.rate + RATES[last.kind]
        self.model.joints.append(Joint(
            name, kind, body, np.zeros(3), axis, limits, 0.0, 0.0, 0.0, damping, 0.0, friction, None, coordinate, rate,
            element.place,
        ))  # fmt: skip
        if effort > 0.0 and joint.mimic is None and kind != "free":
            bounds = (-effort, effort) if np.isfinite(effort) else None
            self.model.actuators.append(Actuator(
                name, "motor", "joint", name, np.eye(6)[0], 1.0, np.zeros(3), True, bounds, bounds, element.place
            ))  # fmt: skip

    def _dynamics(self, joint: Any, word: str, element: Element) -> float:
        text = None if joint.dynamics is None else getattr(joint.dynamics, word)
        try:
            value = float(text or 0.0)
        except ValueError:
            value = np.nan
        if not (np.isfinite(value) and value >= 0.0):
            raise MjcfError(f"{element.title()}: {word} must be a number that is not negative, got {text!r}.")
        return value

    def _add_mimic(self, joint: Any) -> None:
        element = self.elements["joint", joint.name]
        mimic = joint.mimic
        if not any(one.name == mimic.joint for one in self.model.joints):
            raise MjcfError(f"{element.title()}: it mimics {mimic.joint!r}, which is no joint that moves.")
        polynomial = self._finite([mimic.offset, mimic.multiplier, 0.0, 0.0, 0.0], element, "mimic")
        self.model.equalities.append(Equality(
            f"{joint.name} mimics {mimic.joint}", "joint", joint.name, mimic.joint, False, np.zeros(3), None,
            polynomial, True, element.place,
        ))  # fmt: skip
