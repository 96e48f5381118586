"""Meshes, heightfields and included files, read as MuJoCo reads them."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import imageio.v3 as imageio
import mujoco
import numpy as np
import pytest

from gsenv.mjcf import MjcfError, parse_mjcf
from tests.mjcf.oracle import compare, same

# a prism over an L, which is not convex and has no symmetry
CORNERS = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2.5], [0, 2.5]], float)
CAP = [(0, 1, 2), (0, 2, 3), (0, 3, 4), (0, 4, 5)]


def prism() -> tuple[Any, Any]:
    vertices = np.vstack([np.c_[CORNERS, np.zeros(6)], np.c_[CORNERS, np.ones(6)]]) * 0.1
    faces = [(a, c, b) for a, b, c in CAP] + [(a + 6, b + 6, c + 6) for a, b, c in CAP]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, j, j + 6), (i, j + 6, i + 6)]
    return vertices, np.array(faces)


def words(numbers: Any) -> str:
    return " ".join(repr(float(x)) if isinstance(x, float) else str(x) for x in np.asarray(numbers).ravel().tolist())


def write_stl(path: Path) -> None:
    vertices, faces = prism()
    data = b" " * 80 + struct.pack("<I", len(faces))
    for face in faces:
        data += struct.pack("<12f", 0, 0, 0, *vertices[face].ravel()) + b"\0\0"
    path.write_bytes(data)


def write_obj(path: Path) -> None:
    vertices, faces = prism()
    lines = ["# a prism", *(f"v {words(v)}" for v in vertices), *(f"f {words(f + 1)}" for f in faces)]
    path.write_text("\n".join(lines))


def write_msh(path: Path) -> None:
    vertices, faces = prism()
    head = struct.pack("<4i", len(vertices), 0, 0, len(faces))
    path.write_bytes(head + vertices.astype("<f4").tobytes() + faces.astype("<i4").tobytes())


WRITERS = {"stl": write_stl, "obj": write_obj, "msh": write_msh}
MODEL = """
<mujoco><compiler meshdir="parts" boundmass="0"/>
  <default><default class="big"><mesh scale="2 2 3"/></default></default>
  <asset>%s</asset>
  <worldbody><body pos="0 0 1" euler="10 20 30"><freejoint/>
    <geom type="mesh" mesh="part" pos=".1 .2 .3" euler="0 30 0" density="700"/><geom size=".1" pos="1 0 0"/>
  </body></worldbody>
</mujoco>
"""


def both(path: Path, text: str, tolerance: float = 1e-9) -> Any:
    path.write_text(text)
    ours = parse_mjcf(path)
    theirs = mujoco.MjModel.from_xml_path(str(path))
    if tolerance == 1e-9:
        compare(ours, theirs)
    else:  # MuJoCo stores vertices as floats
        same(ours.bodies[1].inertia.mass, theirs.body_mass[1], "mass", tolerance)
        same(ours.bodies[1].inertia.center, theirs.body_ipos[1], "centre", tolerance)
        same(np.linalg.eigvalsh(ours.bodies[1].inertia.tensor), np.sort(theirs.body_inertia[1]), "inertia", tolerance)
    return ours


@pytest.mark.parametrize("suffix", list(WRITERS))
def test_mesh_file(suffix: str, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    WRITERS[suffix](tmp_path / "parts" / f"part.{suffix}")
    mesh = f'<mesh file="part.{suffix}" class="big" refpos=".1 0 0" refquat="1 0 0 1"/>'
    ours = both(tmp_path / "model.xml", MODEL % mesh, 1e-6)
    assert len(ours.meshes["part"].vertices) == 12


@pytest.mark.parametrize("rule", ["exact", "convex", "legacy", "shell"])
@pytest.mark.parametrize("scale", ["1 1 1", "1 -2 1"])
def test_inertia_of_a_mesh(rule: str, scale: str, tmp_path: Path) -> None:
    vertices, faces = prism()
    mesh = f'<mesh name="part" vertex="{words(vertices)}" face="{words(faces)}" inertia="{rule}" scale="{scale}"/>'
    both(tmp_path / "model.xml", MODEL % mesh, 1e-6)


def test_mesh_of_points_is_their_hull(tmp_path: Path) -> None:
    mesh = f'<mesh name="part" vertex="{words(prism()[0])}"/>'
    both(tmp_path / "model.xml", MODEL % mesh, 1e-6)


FIELD = """
<mujoco><asset><hfield name="h" size="3 2 1.5 .1" %s/></asset>
  <worldbody><geom type="hfield" hfield="h"/></worldbody></mujoco>
"""


@pytest.mark.parametrize("source", ["elevation", "binary", "png"])
def test_heights(source: str, tmp_path: Path) -> None:
    heights = np.array([[1, 2, 3], [4, 5, 7], [0, 9, 200], [7, 7, 7]])
    attributes = f'nrow="4" ncol="3" elevation="{words(heights)}"'
    if source == "binary":
        data = struct.pack("<2i", 4, 3) + heights.astype("<f4").tobytes()
        (tmp_path / "h.bin").write_bytes(data)
        attributes = 'file="h.bin"'
    if source == "png":
        imageio.imwrite(tmp_path / "h.png", heights.astype(np.uint8))
        attributes = 'file="h.png"'
    path = tmp_path / "model.xml"
    path.write_text(FIELD % attributes)
    ours, theirs = parse_mjcf(path).grids["h"], mujoco.MjModel.from_xml_path(str(path))
    same(ours.heights.ravel(), theirs.hfield_data * theirs.hfield_size[0, 2], "heights", 1e-6)
    same(ours.size, 2.0 * theirs.hfield_size[0, :2], "size")


def test_includes(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "model.xml").write_text(
        '<mujoco><include file="sub/defaults.xml"/><worldbody><body pos="0 0 1"><include file="sub/joints.xml"/>'
        "</body></worldbody></mujoco>"
    )
    (tmp_path / "sub" / "defaults.xml").write_text(
        '<mujocoinclude><default><geom size=".3"/></default><include file="sub/more.xml"/></mujocoinclude>'
    )
    (tmp_path / "sub" / "more.xml").write_text('<mujoco><option timestep="0.01"/></mujoco>')
    (tmp_path / "sub" / "joints.xml").write_text("<mujoco><joint/><geom/></mujoco>")
    path = tmp_path / "model.xml"
    ours = parse_mjcf(path)
    compare(ours, mujoco.MjModel.from_xml_path(str(path)))
    assert ours.simulation.timestep == 0.01


def test_include_of_itself(tmp_path: Path) -> None:
    (tmp_path / "a.xml").write_text('<mujoco><worldbody><include file="b.xml"/></worldbody></mujoco>')
    (tmp_path / "b.xml").write_text('<x><include file="a.xml"/></x>')
    with pytest.raises(MjcfError, match=r"b\.xml, line 1: the file .*a\.xml' includes itself"):
        parse_mjcf(tmp_path / "a.xml")


@pytest.mark.parametrize(
    ("suffix", "data", "message"),
    [
        ("stl", b"solid x\nvertex 1 2\n", "is not an STL file"),
        ("stl", b"\0" * 90, "is not an STL file: its length"),
        ("obj", b"v 1 2 three", "is not an OBJ file: its line 1"),
        ("obj", b"v 0 0 0\nf 1 2 3", "has a face whose vertices do not exist"),
        ("obj", b"", "has no vertices"),
        ("obj", b"v 1 nan 2", "has vertices that are not finite"),
        ("msh", b"1234", "is no MSH file: it is too short"),
        ("msh", b"\xff" * 40, "is no MSH file: its length"),
        ("dae", b"", "is no STL, OBJ or MSH file"),
    ],
)
def test_malformed_mesh_file(suffix: str, data: bytes, message: str, tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / f"part.{suffix}").write_bytes(data)
    path = tmp_path / "model.xml"
    path.write_text(MODEL % f'<mesh file="part.{suffix}"/>')
    with pytest.raises(MjcfError, match=message):
        parse_mjcf(path)


def test_missing_mesh(tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    path.write_text(MODEL % '<mesh file="part.stl"/>')
    with pytest.raises(
        MjcfError, match=r"model\.xml, line 4: mesh: the file .*part\.stl' cannot be read: No such file"
    ):
        parse_mjcf(path)
