"""The tree under ``worldbody``: bodies with their geoms, joints, sites and cameras."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator

import numpy as np

from .assets import read_assets
from .attributes import Attributes
from .compiler import Compiler
from .defaults import Defaults
from .errors import MjcfError, check_names
from .frames import Pose, identity, product
from .geoms import read_camera, read_geom, read_site
from .inertia import explicit_inertia, settle_inertias
from .joints import read_joint
from .model import COORDINATES, NO_INERTIA, RATES, Body, MjcfModel, Simulation
from .reader import Document, Element

IGNORED = ("light", "plugin")
PARTS = ("geom", "site", "camera", "joint", "freejoint", "inertial")
MAX_REPLICAS = 100_000


@dataclasses.dataclass(frozen=True)
class _Pending:
    """A body whose element is still to be read."""

    element: Element
    parent: int
    frame: Pose  # the frame elements that it stands in, in its parent
    class_name: str | None


class BodyTree:
    """Reads ``worldbody`` into lists of a model."""

    def __init__(self, document: Document, compiler: Compiler, defaults: Defaults, simulation: Simulation) -> None:
        self.compiler = compiler
        self.defaults = defaults
        meshes, grids = read_assets(document, compiler, defaults)
        name = document.root.attributes.get("model", "MuJoCo Model")
        self.model = MjcfModel(name, simulation, [], [], [], [], [], meshes, grids)
        self.jointed: set[int] = set()
        world = Body("world", -1, identity(), identity(), NO_INERTIA, 0.0, False, document.root.place)
        self.model.bodies.append(world)

    def read(self, document: Document) -> MjcfModel:
        """Return the model with its tree.

        Raises:
            MjcfError: an element in the wrong place, a bad attribute, or two elements of one kind and name.
        """
        pending: list[_Pending] = []
        for section in document.root.find_all("worldbody"):
            class_name = section.attributes.get("childclass")
            pending += self._contents(section, 0, identity(), class_name)
        waiting = pending[::-1]
        while waiting:
            waiting += self._body(waiting.pop())[::-1]
        model = self.model
        settle_inertias(model.bodies, model.geoms, self.jointed, self.compiler)
        self._number_coordinates()
        for things in (model.bodies, model.geoms, model.joints, model.sites, model.cameras):
            check_names(things)
        return model

    def _body(self, pending: _Pending) -> list[_Pending]:
        """Read one body; return those inside it."""
        element = pending.element
        attributes = Attributes(element, element.attributes, self.defaults.notes)
        class_name = attributes.text("childclass") or pending.class_name
        pose = pending.frame.then(self.compiler.angles.pose(attributes))
        parent = self.model.bodies[pending.parent]
        mocap = attributes.flag("mocap", False)
        if mocap and pending.parent != 0:
            raise attributes.error("only a child of the world may be a mocap body")
        compensation = attributes.number("gravcomp", 0.0)
        attributes.finish()
        index = len(self.model.bodies)
        body = Body(
            name=attributes.text("name"),
            parent=pending.parent,
            pose=pose,
            world_pose=parent.world_pose.then(pose),
            inertia=NO_INERTIA,
            gravity_compensation=compensation,
            mocap=mocap,
            place=element.place,
        )
        self.model.bodies.append(body)
        inside = self._contents(element, index, identity(), class_name)
        kinds = [joint.kind for joint in self.model.joints if joint.body == index]
        if "free" in kinds and (len(kinds) > 1 or pending.parent != 0):
            raise attributes.error("a free joint must be the only joint of its body, which is a child of the world")
        if mocap and kinds:
            raise attributes.error("a mocap body must not have joints")
        if kinds.count("ball") > 1 or ("ball" in kinds and "hinge" in kinds) or len(kinds) > 6:
            raise attributes.error("its joints have more than six degrees of freedom, or rotate beside a ball joint")
        return inside

    def _contents(self, element: Element, body: int, frame: Pose, class_name: str | None) -> list[_Pending]:
        """Read what stands in a body or frame; return the bodies inside."""
        bodies: list[_Pending] = []
        for child in element.children:
            if child.tag == "body":
                bodies.append(_Pending(child, body, frame, class_name))
            elif child.tag in PARTS:
                self._part(child, body, frame, class_name)
            elif child.tag == "frame":
                inner, inner_class = self._frame(child, frame, class_name)
                bodies += self._contents(child, body, inner, inner_class)
            elif child.tag == "replicate":
                for replica in self._replicas(child):
                    bodies += self._contents(replica[0], body, frame.then(replica[1]), class_name)
            elif child.tag not in IGNORED:
                if child.tag not in ("attach", "composite", "flexcomp"):
                    raise MjcfError(f"{child.place}: {child.tag} is no element of a body.")
                topic = f"{child.tag} is not supported, what it stands for is left out"
                self.defaults.notes.add(topic, child.title())
        return bodies

    def _frame(self, element: Element, frame: Pose, class_name: str | None) -> tuple[Pose, str | None]:
        attributes = Attributes(element, element.attributes, self.defaults.notes)
        pose = frame.then(self.compiler.angles.pose(attributes))
        attributes.finish()
        return pose, attributes.text("childclass") or class_name

    def _part(self, element: Element, body: int, frame: Pose, class_name: str | None) -> None:
        """Read a geom, site, camera, joint or inertial of a body."""
        model, compiler = self.model, self.compiler
        if element.tag in ("joint", "freejoint", "inertial") and body == 0:
            raise MjcfError(f"{element.place}: the world must not have a {element.tag}.")
        if element.tag in ("inertial", "freejoint"):
            attributes = Attributes(element, element.attributes, self.defaults.notes)
        else:
            attributes = self.defaults.attributes(element, class_name)
        if element.tag == "geom":
            model.geoms.append(read_geom(attributes, body, frame, compiler, model.meshes, model.grids))
        elif element.tag == "site":
            model.sites.append(read_site(attributes, body, frame, compiler))
        elif element.tag == "camera":
            model.cameras.append(read_camera(attributes, body, frame, compiler))
        elif element.tag == "inertial":
            model.bodies[body].explicit_inertia = explicit_inertia(attributes, compiler.angles)
        else:
            model.joints.append(read_joint(attributes, body, frame, compiler))
            self.jointed.add(body)

    def _replicas(self, element: Element) -> Iterator[tuple[Element, Pose]]:
        """Yield the contents of a replicate, renamed, with the pose of each copy."""
        attributes = Attributes(element, element.attributes, self.defaults.notes)
        count = attributes.whole("count", 0)
        if not 1 <= count <= MAX_REPLICAS:
            raise attributes.error(f"count must lie between 1 and {MAX_REPLICAS}, got {count}")
        step = Pose(attributes.array("offset", (0.0, 0.0, 0.0)), np.array([1.0, 0.0, 0.0, 0.0]))
        turn = self.compiler.angles.orientation(attributes)
        separator = attributes.text("sep")
        attributes.finish()
        pose = identity()
        width = len(str(count - 1)) if count > 1 else 1
        for k in range(count):
            yield _renamed(element, f"{separator}{k:0{width}d}"), pose
            pose = Pose(pose.then(step).position, product(pose.orientation, turn))

    def _number_coordinates(self) -> None:
        """Give the joints their indices of qpos and qvel."""
        coordinate = rate = 0
        model = self.model
        model.joints.sort(key=lambda joint: joint.body)  # frames may interleave
        for things in (model.geoms, model.sites, model.cameras):
            things.sort(key=lambda thing: thing.body)
        for k, joint in enumerate(model.joints):
            model.joints[k] = dataclasses.replace(joint, coordinate=coordinate, rate=rate)
            coordinate += COORDINATES[joint.kind]
            rate += RATES[joint.kind]


def _renamed(element: Element, suffix: str) -> Element:
    """Return a copy of an element whose descendants have a suffix at their names."""
    attributes = dict(element.attributes)
    if "name" in attributes:
        attributes["name"] += suffix
    return Element(element.tag, attributes, element.place, [_renamed(child, suffix) for child in element.children])
