"""Arguments of the wrong kind are refused in one sentence, with nothing added: flags, axes, names, references."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, planar, spatial

BOTH = pytest.mark.parametrize("dim", [2, 3])


def plain(dim: int) -> Scene:
    scene = Scene(dim=dim)
    scene.add_body("base", "static")
    scene.add_body("it", mass=1.0, inertia=0.1 if dim == 2 else (0.1, 0.1, 0.1))
    return scene


def refused(scene: Scene, act: Callable[[Scene], object], match: str) -> None:
    before = (*scene.bodies, *scene.joints, *sorted(scene.excluded))
    with pytest.raises(ValueError, match=match) as caught:
        act(scene)
    assert str(caught.value).endswith(".")
    assert (*scene.bodies, *scene.joints, *sorted(scene.excluded)) == before


@BOTH
@pytest.mark.parametrize("bad", ["no", "false", 1, 0.0, None, [], np.zeros(3)])
def test_flags_are_true_or_false(dim: int, bad: Any) -> None:
    """Texts such as "no" and "false" counted as True."""
    module: Any = planar if dim == 2 else spatial
    ball = planar.Circle(radius=0.1, sensor=bad) if dim == 2 else spatial.Sphere(radius=0.1, sensor=bad)
    row = [1.0] + [0.0] * (2 if dim == 2 else 5)
    acts: dict[str, Callable[[Scene], object]] = {
        "enabled": lambda scene: scene.add_joint("weld", module.Weld("base", "it", enabled=bad)),
        "collide": lambda scene: scene.add_joint("weld", module.Weld("base", "it", collide=bad)),
        "joint 'hand': enabled": lambda scene: scene.add_joint("hand", module.Target("it", enabled=bad)),
        "constraint 'c': enabled": lambda scene: scene.add_constraint("c", "it", row, enabled=bad),
        "continuous": lambda scene: scene.add_body("new", "static", continuous=bad),
        "body 'new': enabled": lambda scene: scene.add_body("new", "static", enabled=bad),
        "sensor": lambda scene: scene.add_body("new", shapes=[ball]),
        "subtract_gravity": lambda scene: scene.add_sensor(
            "new", module.AccelerationSensor("it", subtract_gravity=bad)
        ),
        "warm_start": lambda scene: Options(warm_start=bad),
    }
    for word, act in acts.items():
        refused(plain(dim), act, f"{word} must be True or False")


@pytest.mark.parametrize("turns", [{"turn_x"}, {"turn_x", "turn_y", "turn_z"}])
@pytest.mark.parametrize("bad", [(-1.0, 1.0), 1.0, "free", True])
def test_axes_of_a_six_axis_joint(turns: set[str], bad: Any) -> None:
    """Limits in place of an Axis, beside two other rotations, raised an AttributeError."""
    given: Any = dict.fromkeys(turns, spatial.Axis()) | {"turn_x": bad}
    refused(
        plain(3),
        lambda scene: scene.add_joint("hip", spatial.SixAxis("base", "it", **given)),
        r"joint 'hip/turn_x' must be an Axis such as Axis\(limits=\(-1, 1\)\), got",
    )


@pytest.mark.parametrize("bad", ["x", [], {}, (None, None), (1.0, 2.0, 3.0), (1.0, -1.0)])
def test_limits_of_one_of_three_rotations(bad: Any) -> None:
    axes: Any = {"turn_x": spatial.Axis(limits=bad), "turn_y": spatial.Axis(), "turn_z": spatial.Axis()}
    hip = spatial.SixAxis("base", "it", **axes)
    refused(plain(3), lambda scene: scene.add_joint("hip", hip), "joint 'hip/turn_x'.*limit")


@pytest.mark.parametrize("word", ["frequency", "stiffness", "motor_effort", "armature"])
def test_numbers_of_a_ball(word: str) -> None:
    given: Any = {word: np.zeros(3)}
    ball = spatial.Ball("base", "it", **given)
    refused(plain(3), lambda scene: scene.add_joint("ball", ball), f"{word} must be a number")


@BOTH
def test_names_and_references(dim: int) -> None:
    module: Any = planar if dim == 2 else spatial
    ball = planar.Circle(radius=0.1, name=[1]) if dim == 2 else spatial.Sphere(radius=0.1, name=[1])  # type: ignore[arg-type]
    refused(plain(dim), lambda scene: scene.add_body("new", shapes=[ball]), "name must be text")
    refused(plain(dim), lambda scene: scene.add_joint("weld", module.Weld("base", True)), "body True is unknown")
    refused(plain(dim), lambda scene: scene.add_constraint("c", 1.5, [0.0]), "body 1.5 is unknown")  # type: ignore[arg-type]


@BOTH
@pytest.mark.parametrize("bad", [[], {}, np.zeros(3)])
def test_choices(dim: int, bad: Any) -> None:
    refused(plain(dim), lambda scene: Options(solver=bad), "unknown solver")
    refused(plain(dim), lambda scene: scene.add_body("new", bad), "kind .* is unknown")
