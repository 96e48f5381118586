"""The parsed model is that which MuJoCo compiles from the same file."""

from __future__ import annotations

import mujoco
import pytest

from gsenv.mjcf import parse_mjcf
from tests.mjcf import examples
from tests.mjcf.oracle import FILES, GYMNASIUM, compare


def test_all_of_gymnasiums_files_are_found() -> None:
    assert {"humanoid.xml", "ant.xml", "half_cheetah.xml", "hopper.xml", "walker2d.xml", "pusher.xml"} <= set(FILES)


@pytest.mark.parametrize("name", FILES)
def test_file_of_gymnasium(name: str) -> None:
    path = GYMNASIUM / name
    compare(parse_mjcf(path), mujoco.MjModel.from_xml_path(str(path)))


@pytest.mark.parametrize("name", ["FRAMES", "DEFAULTS"])
def test_example(name: str) -> None:
    text = getattr(examples, name)
    compare(parse_mjcf(text), mujoco.MjModel.from_xml_string(text))
