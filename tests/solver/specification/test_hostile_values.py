"""Values that no user means: each is one sentence that names what and where, and nothing has changed."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Options, Scene, World, planar, spatial
from tests.solver.bits import everything

NUMBERS: dict[str, Any] = {
    "nan": float("nan"), "inf": float("inf"), "huge": 1e308, "long": 10**400, "big": 10**30 * 10**30, "text": "1",
    "bytes": b"1", "flag": True, "none in a list": [None], "complex": 1j, "empty": [], "dict": {}, "object": object(),
    "ragged": [[1.0, 2.0], [3.0]], "digits": 10**5000, "many": [float("nan")] * 10_000,
}  # fmt: skip


def scene(dim: int) -> Scene:
    made = Scene(dim=dim)
    module: Any = planar if dim == 2 else spatial
    made.add_body("ground", "static", [planar.HalfPlane() if dim == 2 else spatial.Plane()])
    made.add_body("box", shapes=[module.Box(half_extents=(0.5,) * dim)], position=(0,) * (dim - 1) + (0.5,))
    made.add_joint("pull", module.Target("box"))
    made.add_actuator("x", "pull", "x")
    return made


USES: dict[str, Callable[[World, Any], Any]] = {
    "apply_force": lambda world, bad: world.apply_force("box", force=(bad,) * world.model.dim),
    "apply_force point": lambda world, bad: world.apply_force("box", force=(1,) * world.model.dim, point=bad),
    "set_pose": lambda world, bad: world.set_pose("box", position=(bad,) * world.model.dim),
    "set_velocity": lambda world, bad: world.set_velocity("box", linear=(bad,) * world.model.dim),
    "set_target": lambda world, bad: world.set_target("pull", position=(bad,) * world.model.dim),
    "mass": lambda world, bad: world.parameters.set("box", mass=bad),
    "friction": lambda world, bad: world.parameters.set("box", friction=bad),
    "gravity": lambda world, bad: world.parameters.set(gravity=(bad,) * world.model.dim),
    "cast_rays": lambda world, bad: world.cast_rays((0,) * world.model.dim, (1,) * world.model.dim, bad),
}


@pytest.mark.parametrize("value", NUMBERS)
@pytest.mark.parametrize("use", USES)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_world_refuses_bad_numbers(dim: int, use: str, value: str) -> None:
    world = World(scene(dim))
    before = everything(world)
    if (use, value) == ("cast_rays", "empty"):
        assert world.cast_rays((0,) * dim, (1,) * dim, []).distance.size == 0
        return
    with pytest.raises(ValueError, match=r"must (be|lie|fit|not)|of shape"):
        USES[use](world, NUMBERS[value])
    assert everything(world) == before


BODIES: dict[str, Callable[[Any, Any, int], dict[str, Any]]] = {
    "mass": lambda module, bad, dim: {"mass": bad},
    "position": lambda module, bad, dim: {"position": (bad,) * dim},
    "gravity_scale": lambda module, bad, dim: {"gravity_scale": bad},
    "linear_damping": lambda module, bad, dim: {"linear_damping": bad},
    "half_extents": lambda module, bad, dim: {"shapes": [module.Box(half_extents=(bad,) * dim)]},
    "density": lambda module, bad, dim: {"shapes": [module.Box(half_extents=(1,) * dim, density=bad)]},
    "shape position": lambda module, bad, dim: {"shapes": [module.Box(half_extents=(1,) * dim, position=(bad,) * dim)]},
}


@pytest.mark.parametrize("value", [name for name in NUMBERS if name != "none in a list"])
@pytest.mark.parametrize("what", BODIES)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_scene_refuses_bad_numbers(dim: int, what: str, value: str) -> None:
    made = scene(dim)
    given = {"shapes": [(planar if dim == 2 else spatial).Box(half_extents=(1,) * dim)]}
    with pytest.raises(ValueError, match=r"^body 'bad'"):
        made.add_body("bad", **given | BODIES[what](planar if dim == 2 else spatial, NUMBERS[value], dim))
    assert list(made.bodies) == ["ground", "box"]


@pytest.mark.parametrize("size", [1e-40, 1e-300])
def test_sizes_whose_powers_vanish_are_refused(size: float) -> None:
    for dim, shape in ((2, planar.Circle(radius=size)), (3, spatial.Sphere(radius=size))):
        with pytest.raises(ValueError, match="radius must be at least 1e-36"):
            scene(dim).add_body("bad", shapes=[shape], mass=1.0, inertia=1.0 if dim == 2 else (1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("substeps", 10**12), ("substeps", 10**400), ("max_substeps", 2**31), ("sweeps", 10**12), ("halvings", 17),
        ("position_sweeps", 10**9), ("substeps", 2.0), ("substeps", True), ("timestep", 1e-300), ("timestep", 1e300),
        ("timestep", "0.01"), ("timestep", True), ("timestep", None), ("slop", float("nan")), ("tolerance", 1e308),
        ("warm_start", "no"), ("sleep", 1), ("articulated", "no"),
    ],
)  # fmt: skip
def test_options_refuse_bad_values(option: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"^Options: {option} must "):
        Options(**{option: value})


@pytest.mark.parametrize(
    "color", [(0.9, 0.2, 0.1), (1.0, 0.0, 0.0), (0, 0, 256), (-1, 0, 0), (10.5, 0, 0), "red", (1, 2), (1, 2, 3, 4)]
)
def test_colors_are_whole_numbers(color: Any) -> None:
    with pytest.raises(ValueError, match=r"^body 'bad': color must be three whole numbers"):
        scene(2).add_body("bad", shapes=[planar.Circle(radius=1)], color=color)


@pytest.mark.parametrize("color", [(0, 0, 0), (255, 128, 1), (1, 0, 0), np.array([20.0, 30.0, 40.0]), [1, 1, 1]])
def test_right_colors_are_kept(color: Any) -> None:
    made = scene(2)
    made.add_body("right", shapes=[planar.Circle(radius=1)], color=color)
    assert made.bodies["right"].color == tuple(color)


@pytest.mark.parametrize("value", ["no", "false", 0, 1, None, []])
@pytest.mark.parametrize("flag", ["continuous", "enabled"])
def test_flags_are_true_or_false(flag: str, value: Any) -> None:
    with pytest.raises(ValueError, match=f"^body 'bad': {flag} must be True or False"):
        scene(2).add_body("bad", shapes=[planar.Circle(radius=1)], **{flag: value})


@pytest.mark.parametrize("count", [0, -1, 1.0, True, "2", None, 10**30, 2**40])
def test_bad_numbers_of_worlds(count: Any) -> None:
    with pytest.raises((ValueError, MemoryError), match=r"^World: "):
        World(scene(2), count)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_largest_numbers_that_are_taken_stay_finite(dim: int) -> None:
    world = World(scene(dim))
    world.apply_force("box", force=(1e36,) * dim)
    world.step(120)
    assert np.isfinite(world.position).all()
    assert np.isfinite(world.linear_velocity).all()


@pytest.mark.parametrize("dim", [2, 3])
def test_gravity_is_a_vector_and_reset_takes_a_flag(dim: int) -> None:
    world = World(scene(dim))
    before = everything(world)
    with pytest.raises(ValueError, match="gravity must be"):
        world.parameters.set(gravity=-9.81)
    wrong: list[Any] = ["no", None, 1, [True]]
    for bad in wrong:
        with pytest.raises(ValueError, match="reset: parameters must be True or False"):
            world.reset(parameters=bad)
    assert everything(world) == before


def test_sentences_show_values_in_short() -> None:
    with pytest.raises(ValueError, match="gravity") as caught:
        Scene(gravity=[float("nan")] * 10_000)
    assert len(str(caught.value)) < 200
    with pytest.raises(ValueError, match="mass must be a number, got a value of type int that cannot be shown"):
        scene(2).add_body("new", shapes=[planar.Circle(radius=1.0)], mass=10**5000)
