"""The assets that geoms refer to: meshes and heightfields."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

import numpy as np

from ..solver.records.model import Array
from .attributes import Attributes
from .compiler import Compiler
from .defaults import Defaults
from .errors import MjcfError
from .frames import Pose
from .mesh_files import Triangles, read_mesh
from .model import HeightGrid, Mesh
from .reader import Document, Element

MOST_SAMPLES = 1_000_000  # of a heightfield
MESH_INERTIAS = ("convex", "exact", "legacy", "shell")


def read_assets(
    document: Document, compiler: Compiler, defaults: Defaults
) -> tuple[dict[str, Mesh], dict[str, HeightGrid]]:
    """Return the meshes and heightfields by name.

    Raises:
        MjcfError: a missing or malformed file, or two of one name.
    """
    meshes: dict[str, Mesh] = {}
    grids: dict[str, HeightGrid] = {}
    folder = document.folder / compiler.mesh_folder
    for section in document.root.find_all("asset"):
        for element in section.children:
            if element.tag == "mesh":
                mesh = _mesh(element, folder, defaults)
                _check_name(mesh.name, meshes, element)
                meshes[mesh.name] = mesh
            elif element.tag == "hfield":
                grid = _grid(element, folder, defaults)
                _check_name(grid.name, grids, element)
                grids[grid.name] = grid
            elif element.tag not in ("texture", "material", "skin"):
                defaults.notes.add(f"the asset {element.tag} is ignored", element.title())
    return meshes, grids


def _check_name(name: str, taken: Collection[str], element: Element) -> None:
    if name in taken:
        raise MjcfError(f"{element.title()}: the name {name!r} is given twice.")


def _file(attributes: Attributes, folder: Path) -> Path | None:
    name = attributes.text("file")
    return folder / name if name else None


def _unreadable(attributes: Attributes, path: Path, error: Exception) -> MjcfError:
    if isinstance(error, OSError):
        return attributes.error(f"the file {str(path)!r} cannot be read: {error.strerror or error}")
    return attributes.error(f"the file {str(path)!r} {error}")


def _mesh(element: Element, folder: Path, defaults: Defaults) -> Mesh:
    attributes = defaults.attributes(element)
    path = _file(attributes, folder)
    name = attributes.text("name") or (path.stem if path else "")
    if not name:
        raise attributes.error("a mesh needs a name or a file")
    vertices, faces = _triangles(attributes, path)
    place = Pose(attributes.array("refpos", (0.0, 0.0, 0.0)), _reference(attributes)).inverse()
    scale = attributes.array("scale", (1.0, 1.0, 1.0))
    if not scale.all():
        raise attributes.error(f"scale must not be zero, got {attributes.text('scale')!r}")
    vertices = place.point(vertices) * scale
    if np.prod(scale) < 0.0:
        faces = faces[:, ::-1]
    inertia = attributes.choice("inertia", MESH_INERTIAS, "legacy")
    attributes.finish()
    return Mesh(name, vertices, faces, inertia, element.place)


def _reference(attributes: Attributes) -> Array:
    quaternion = attributes.array("refquat", (1.0, 0.0, 0.0, 0.0))
    length = float(np.linalg.norm(quaternion))
    if length == 0.0:
        raise attributes.error("refquat must not be zero")
    return quaternion / length


def _triangles(attributes: Attributes, path: Path | None) -> Triangles:
    if path is not None:
        try:
            return read_mesh(path)
        except (OSError, ValueError) as error:
            raise _unreadable(attributes, path, error) from None
    if "vertex" not in attributes:
        if "builtin" in attributes:
            raise attributes.error("builtin meshes are not supported; write the mesh to a file")
        raise attributes.error("a mesh needs a file or vertices")
    numbers = np.array(attributes.numbers("vertex"))
    if not len(numbers) or len(numbers) % 3:
        raise attributes.error(f"vertex must be triples of numbers, got {len(numbers)} numbers")
    vertices = numbers.reshape(-1, 3)
    indices = np.array(attributes.numbers("face") if "face" in attributes else [])
    if len(indices) % 3 or (indices != np.floor(indices)).any():
        raise attributes.error(f"face must be triples of whole numbers, got {len(indices)} numbers")
    faces = indices.astype(np.int64).reshape(-1, 3)
    if len(faces) and not (0 <= faces.min() and faces.max() < len(vertices)):
        raise attributes.error(f"face must name vertices 0 to {len(vertices) - 1}, got {faces.max()}")
    return vertices, faces


def _grid(element: Element, folder: Path, defaults: Defaults) -> HeightGrid:
    attributes = defaults.attributes(element)
    path = _file(attributes, folder)
    name = attributes.text("name") or (path.stem if path else "")
    if not name:
        raise attributes.error("a hfield needs a name or a file")
    if "size" not in attributes:
        raise attributes.error("size is missing")
    half_x, half_y, height, base = attributes.vector("size", (0.0, 0.0, 0.0, 0.0))
    if not min(half_x, half_y, height, base) > 0.0:
        raise attributes.error(f"size must be four positive numbers, got {attributes.text('size')!r}")
    if path is not None:
        try:
            samples = _height_file(path)
        except (OSError, ValueError) as error:
            raise _unreadable(attributes, path, error) from None
        attributes.read.update(("nrow", "ncol"))
    else:
        rows, columns = attributes.whole("nrow", 0), attributes.whole("ncol", 0)
        if not 2 <= min(rows, columns):
            raise attributes.error(f"a hfield needs nrow and ncol of at least 2 each, got {rows} and {columns}")
        if rows * columns > MOST_SAMPLES:
            raise attributes.error(f"nrow times ncol must not exceed {MOST_SAMPLES:,}, got {rows} times {columns}")
        samples = np.zeros((rows, columns))
        if "elevation" in attributes:
            numbers = attributes.numbers("elevation")
            if len(numbers) != rows * columns:
                raise attributes.error(f"elevation must be {rows * columns} numbers, got {len(numbers)}")
            samples = np.array(numbers).reshape(rows, columns)[::-1]  # its first row is the farthest along y
    attributes.finish()
    samples = samples - samples.min()
    peak = float(samples.max())
    heights = samples * (height / peak) if peak > 0.0 else samples
    return HeightGrid(name, heights, np.array([2.0 * half_x, 2.0 * half_y]), element.place)


def _height_file(path: Path) -> Array:
    """Return the heights (rows, columns) of an image or of MuJoCo's own format.

    Raises:
        ValueError: neither of these; the message continues "the file ... ".
    """
    if path.suffix.lower() == ".png":
        import imageio.v3 as imageio  # only here: most models have no images

        try:
            image = np.asarray(imageio.imread(path), float)
        except (ValueError, SyntaxError) as error:
            raise ValueError(f"is not a PNG image: {error}") from None
        return image[::-1] if image.ndim == 2 else image[::-1, :, 0]
    data = path.read_bytes()
    if len(data) < 8:
        raise ValueError("is no heightfield: it is too short")
    rows, columns = (int(n) for n in np.frombuffer(data, "<i4", 2))
    if min(rows, columns) < 2 or len(data) != 8 + 4 * rows * columns:
        raise ValueError("is no heightfield: its length does not match its rows and columns")
    heights = np.frombuffer(data, "<f4", rows * columns, 8).reshape(rows, columns).astype(float)
    if not np.isfinite(heights).all():
        raise ValueError("has heights that are not finite")
    return heights
