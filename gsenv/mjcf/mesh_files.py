"""Readers of mesh files: STL (binary and text), OBJ and MuJoCo's MSH."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..solver.records.model import Array

Triangles = tuple[Array, Array]  # vertices (n, 3), faces (m, 3)


def read_mesh(path: Path) -> Triangles:
    """Return vertices (n, 3) and faces (m, 3) of a file, which its suffix describes.

    Raises:
        ValueError: not such a file, or another suffix; the message continues "the file ... ".
        OSError: it cannot be read.
    """
    readers = {".stl": _stl, ".obj": _obj, ".msh": _msh}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise ValueError("is no STL, OBJ or MSH file")
    vertices, faces = reader(path.read_bytes())
    if not len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("has no vertices" if not len(vertices) else "has vertices that are not finite")
    if len(faces) and not (0 <= faces.min() and faces.max() < len(vertices)):
        raise ValueError("has a face whose vertices do not exist")
    return vertices, faces


def _welded(corners: Array) -> Triangles:
    """Return the distinct vertices and the faces of triangles given by their corners (m, 3, 3)."""
    vertices, index = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return vertices, index.reshape(-1, 3).astype(np.int64)


def _stl(data: bytes) -> Triangles:
    count = int.from_bytes(data[80:84], "little") if len(data) >= 84 else -1
    if len(data) == 84 + 50 * count:
        record = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("color", "<u2")])
        return _welded(np.frombuffer(data, record, count, 84)["corners"].astype(float))
    if not data.lstrip().startswith(b"solid"):
        raise ValueError("is not an STL file: its length does not match its number of triangles")
    words = data.decode("ascii", "replace").split()
    starts = [k + 1 for k, word in enumerate(words) if word == "vertex"]
    try:
        numbers = np.array([[float(x) for x in words[k : k + 3]] for k in starts])
    except ValueError:
        raise ValueError("is not an STL file: a vertex is not three numbers") from None
    if numbers.ndim != 2 or numbers.shape[1] != 3 or len(numbers) % 3:
        raise ValueError("is not an STL file: its vertices are not triples for triangles")
    return _welded(numbers.reshape(-1, 3, 3))


def _obj(data: bytes) -> Triangles:
    vertices: list[list[float]] = []
    faces: list[list[int]] = []
    for number, line in enumerate(data.decode("utf-8", "replace").splitlines(), 1):
        words = line.split()
        try:
            if words[:1] == ["v"]:
                vertices.append([float(words[k]) for k in (1, 2, 3)])
            elif words[:1] == ["f"]:
                corners = [int(word.split("/")[0]) for word in words[1:]]
                corners = [k - 1 if k > 0 else len(vertices) + k for k in corners]
                faces += [[corners[0], corners[k], corners[k + 1]] for k in range(1, len(corners) - 1)]
        except (ValueError, IndexError):
            raise ValueError(f"is not an OBJ file: its line {number} cannot be read") from None
    return np.array(vertices, float).reshape(-1, 3), np.array(faces, np.int64).reshape(-1, 3)


def _msh(data: bytes) -> Triangles:
    """MuJoCo's own format: four counts, then vertices, normals, texture coordinates and faces."""
    if len(data) < 16:
        raise ValueError("is no MSH file: it is too short")
    counts = np.frombuffer(data, "<i4", 4)
    vertex, normal, texture, face = (int(n) for n in counts)
    if min(vertex, normal, texture, face) < 0 or len(data) != 16 + 12 * (vertex + normal + face) + 8 * texture:
        raise ValueError("is no MSH file: its length does not match its counts")
    vertices = np.frombuffer(data, "<f4", 3 * vertex, 16).reshape(-1, 3).astype(float)
    faces = np.frombuffer(data, "<i4", 3 * face, len(data) - 12 * face).reshape(-1, 3).astype(np.int64)
    return vertices, faces
