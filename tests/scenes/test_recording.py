"""Where `gsenv record` points its camera in a scene."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import imageio.v3 as iio
import numpy as np
import pytest

import gsenv.render
from gsenv import cli
from gsenv.render.camera import Camera, FollowCamera
from gsenv.scenes import SCENES


@pytest.fixture
def renderers(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The renderers that commands make, as they make them."""
    made: list[Any] = []
    original = gsenv.render.SceneRenderer

    def make(*args: Any, **kwargs: Any) -> Any:
        made.append(original(*args, **kwargs))
        return made[-1]

    monkeypatch.setattr(gsenv.render, "SceneRenderer", make)
    return made


def record(name: str, out: Path) -> None:
    assert cli.main(["record", f"scene:{name}", "--out", str(out), "--steps", "2", "--size", "64x48"]) == 0


def test_a_scene_with_a_view_is_shown_there(tmp_path: Path, renderers: list[Any]) -> None:
    out = tmp_path / "x.gif"
    record("jelly", out)
    left, bottom, right, top = SCENES["jelly"].view or (0.0, 0.0, 0.0, 0.0)
    camera = renderers[0].camera
    assert isinstance(camera, Camera)
    assert camera.center == pytest.approx((0.5 * (left + right), 0.5 * (bottom + top)))
    assert camera.height == pytest.approx(max(top - bottom, 0.75 * (right - left)))
    assert iio.imread(out).shape[-3:] == (48, 64, 3)


def test_a_scene_with_a_body_to_follow_is_shown_around_it(tmp_path: Path, renderers: list[Any]) -> None:
    record("car", tmp_path / "x.gif")
    camera = renderers[0].camera
    assert isinstance(camera, FollowCamera)
    assert [renderers[0].world.model.body_names[k] for k in camera.bodies] == ["chassis"]


def test_another_scene_is_shown_whole(tmp_path: Path, renderers: list[Any]) -> None:
    record("stack", tmp_path / "x.gif")
    pixels = renderers[0].camera.to_pixel(renderers[0].world.position[0, 1:], 64, 48)
    assert ((pixels > 0.0) & (pixels < np.array([64.0, 48.0]))).all()
