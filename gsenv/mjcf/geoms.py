"""Geoms, sites and cameras."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from ..solver.records.model import Array
from .attributes import Attributes
from .compiler import Compiler
from .frames import Pose, from_z
from .inertia import placed, unit_inertia
from .model import Camera, Geom, HeightGrid, Mesh, Site

SIZES = {"plane": 3, "sphere": 1, "capsule": 2, "cylinder": 2, "box": 3, "ellipsoid": 3, "mesh": 0, "hfield": 0}
SITE_KINDS = ("sphere", "capsule", "cylinder", "box", "ellipsoid", "mesh")
ALONG = ("capsule", "cylinder", "box", "ellipsoid")  # kinds that fromto may place
CAMERA_MODES = ("fixed", "track", "trackcom", "targetbody", "targetbodycom")


def read_geom(
    attributes: Attributes,
    body: int,
    frame: Pose,
    compiler: Compiler,
    meshes: Mapping[str, Mesh],
    grids: Mapping[str, HeightGrid],
) -> Geom:
    """Return a geom; ``frame`` is the frame element that it stands in, in the body's frame.

    Raises:
        MjcfError: an attribute out of its range, or an asset that does not exist.
    """
    kind = attributes.choice("type", tuple(SIZES), "sphere")
    asset = attributes.text("hfield") if kind == "hfield" else attributes.text("mesh")
    if kind not in ("mesh", "hfield") and asset:
        attributes.notes.add("a primitive fitted to a mesh is not supported, the mesh's hull is used", attributes.title)
        kind = "mesh"
    if kind in ("mesh", "hfield") and asset not in (meshes if kind == "mesh" else grids):
        raise attributes.error(f"there is no {kind} {asset!r}" if asset else f"{kind} is missing")
    pose, size = _placed_and_sized(attributes, kind, compiler)
    pose = frame.then(pose)
    mesh = meshes.get(asset) if kind == "mesh" else None
    try:
        volume, center, tensor = unit_inertia(kind, size, mesh)
    except OverflowError:
        raise attributes.error("its size is too large") from None
    except ValueError as error:
        raise attributes.error(str(error)) from None
    density = attributes.number("density", 1000.0)
    if density < 0.0:
        raise attributes.error(f"density must not be negative, got {density:g}")
    mass = attributes.number("mass", -1.0)
    if "mass" in attributes:
        if mass < 0.0:
            raise attributes.error(f"mass must not be negative, got {mass:g}")
        density = mass / volume if volume > 0.0 else 0.0
    friction = attributes.array("friction", (1.0, 0.005, 0.0001))
    if friction.min() < 0.0:
        raise attributes.error(f"friction must not be negative, got {attributes.text('friction')!r}")
    condim = attributes.whole("condim", 3)
    if condim not in (1, 3, 4, 6):
        raise attributes.error(f"condim must be 1, 3, 4 or 6, got {condim}")
    geom = Geom(
        name=attributes.text("name"),
        kind=kind,
        body=body,
        pose=pose,
        size=size,
        inertia=placed(volume, center, tensor, density, pose),
        group=attributes.whole("group", 0),
        contype=attributes.whole("contype", 1),
        conaffinity=attributes.whole("conaffinity", 1),
        condim=condim,
        friction=friction,
        rgba=attributes.array("rgba", (0.5, 0.5, 0.5, 1.0)),
        asset=asset,
        place=attributes.element.place,
    )
    attributes.finish()
    return geom


def _placed_and_sized(attributes: Attributes, kind: str, compiler: Compiler) -> tuple[Pose, Array]:
    """Return pose and size (3,) of a geom or site, from ``fromto`` where that is given."""
    size = attributes.array("size", (0.0, 0.0, 0.0))
    if "fromto" not in attributes or kind not in ALONG:
        attributes.text("fromto")
        _check_size(attributes, kind, size)
        return compiler.angles.pose(attributes), size
    ends = attributes.array("fromto", (0.0,) * 6)
    along = ends[:3] - ends[3:]
    length = float(np.linalg.norm(along))
    if length < 1e-14:
        raise attributes.error("fromto must be two different points")
    for name in ("pos", "quat", "axisangle", "euler", "xyaxes", "zaxis"):
        attributes.text(name)
    if kind in ("box", "ellipsoid"):
        size = np.array([size[0], size[0], 0.5 * length])
    else:
        size = np.array([size[0], 0.5 * length, 0.0])
    _check_size(attributes, kind, size)
    return Pose(0.5 * (ends[:3] + ends[3:]), from_z(along)), size


def _check_size(attributes: Attributes, kind: str, size: Array) -> None:
    if kind == "plane":
        return  # only drawn
    count = SIZES[kind]
    if count and not size[:count].min() > 0.0:
        words = {1: "a positive number", 2: "two positive numbers", 3: "three positive numbers"}[count]
        raise attributes.error(f"the size of a {kind} must be {words}, got {attributes.text('size')!r}")


def read_site(attributes: Attributes, body: int, frame: Pose, compiler: Compiler) -> Site:
    """Return a site; raises MjcfError for an attribute out of its range."""
    kind = attributes.choice("type", SITE_KINDS, "sphere")
    size = attributes.array("size", (0.005, 0.005, 0.005))
    pose = compiler.angles.pose(attributes)
    if "fromto" in attributes and kind in ALONG:
        pose, size = _placed_and_sized(attributes, kind, compiler)
    attributes.read.update(("fromto", "mesh"))
    attributes.finish()
    return Site(attributes.text("name"), body, frame.then(pose), size, kind, attributes.element.place)


def read_camera(attributes: Attributes, body: int, frame: Pose, compiler: Compiler) -> Camera:
    """Return a camera; raises MjcfError for an attribute out of its range."""
    mode = attributes.choice("mode", CAMERA_MODES, "fixed")
    target = attributes.text("target")
    fovy = attributes.number("fovy", 45.0)  # in degrees whatever the compiler says
    if not 0.0 < fovy < 180.0:
        raise attributes.error(f"fovy must lie between 0 and 180 degrees, got {fovy:g}")
    pose = frame.then(compiler.angles.pose(attributes))
    attributes.finish()
    return Camera(attributes.text("name"), body, pose, mode, target, math.radians(fovy), attributes.element.place)
