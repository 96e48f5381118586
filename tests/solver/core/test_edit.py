"""Kernels that edit a world between two steps keep derived fields true and wake what they must."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import gsenv.solver.planar
import gsenv.solver.spatial
from gsenv.solver import Scene, World
from gsenv.solver.core.edit import (
    disable_body,
    disable_joint,
    enable_body,
    enable_joint,
    place_body,
    set_box,
    set_mass,
    set_mass_alone,
    sleep_body,
)
from gsenv.solver.jit import njit
from gsenv.solver.records.plain import as_records

DIMENSIONS = pytest.mark.parametrize("dim", [2, 3])
UP = {2: 1, 3: 2}
LEVEL: dict[int, Any] = {2: (1.0, 0.0, 0.0), 3: (1.0, 0.0, 0.0, 0.0)}
REST: dict[int, Any] = {2: (0.0, 0.0, 0.0), 3: (0.0,) * 6}


def box(dim: int, half: float = 0.5, **arguments: Any) -> Any:
    module: Any = gsenv.solver.planar if dim == 2 else gsenv.solver.spatial
    return module.Box(half_extents=(half,) * dim, **arguments)


def at(dim: int, height: float, aside: float = 0.0) -> tuple[float, ...]:
    return (aside, height) if dim == 2 else (aside, 0.0, height)


def tower(dim: int) -> Scene:
    """Two boxes on a static plank, and one that is disabled."""
    scene = Scene(dim=dim)
    scene.add_body("plank", "static", [box(dim)], position=at(dim, -0.5))
    scene.add_body("lower", shapes=[box(dim)], position=at(dim, 0.5))
    scene.add_body("upper", shapes=[box(dim)], position=at(dim, 1.5))
    scene.add_body("spare", shapes=[box(dim)], position=at(dim, 9.0, 5.0), enabled=False)
    return scene


PLANK, LOWER, UPPER, SPARE = range(4)


def asleep(dim: int) -> World:
    world = World(tower(dim))
    world.step(120)
    assert world.asleep[0, [LOWER, UPPER]].all()
    return world


def records(world: World) -> tuple[Any, Any, Any]:
    """(body states, body parameters, contacts) of world 0."""
    count = int(world.state.worlds["contact_count"][0])
    bodies, parameters = world.state.bodies[0], world.parameters.bodies[0]
    return as_records(bodies), as_records(parameters), as_records(world.state.contacts[0, :count])


def place(world: World, b: int, position: Any, turn: Any = None, velocity: Any = None) -> None:
    dim = world.model.dim
    bodies, parameters, contacts = records(world)
    place_body(b, bodies, parameters, contacts, tuple(position), turn or LEVEL[dim], velocity or REST[dim])


def height(world: World, b: int) -> float:
    return float(world.position[0, b, UP[world.model.dim]])


# ---------------------------------------------------------------- masses and sizes


@njit
def _set_mass(bodies: Any, b: Any, mass: Any, alone: Any) -> None:
    if alone:
        set_mass_alone(bodies[b], mass)
    else:
        set_mass(bodies[b], mass)


@DIMENSIONS
def test_inertia_scales_with_the_mass_unless_it_is_left_alone(dim: int) -> None:
    world = World(tower(dim))
    before = world.parameters.bodies[0].copy()
    _, parameters, _ = records(world)
    _set_mass(parameters, LOWER, 3.0 * before["mass"][LOWER], False)
    _set_mass(parameters, UPPER, 3.0 * before["mass"][UPPER], True)
    after = world.parameters.bodies[0]
    np.testing.assert_allclose(after["mass"][[LOWER, UPPER]], 3.0 * before["mass"][[LOWER, UPPER]])
    np.testing.assert_allclose(after["inertia"][LOWER], 3.0 * before["inertia"][LOWER])
    np.testing.assert_array_equal(after["inertia"][UPPER], before["inertia"][UPPER])
    for b in (LOWER, UPPER):
        assert after["inv_mass"][b] == 1.0 / after["mass"][b]
        np.testing.assert_array_equal(after["inv_inertia"][b], 1.0 / after["inertia"][b])


@DIMENSIONS
def test_a_disabled_body_takes_a_mass_and_keeps_its_zero_inverses(dim: int) -> None:
    world = World(tower(dim))
    _, parameters, _ = records(world)
    _set_mass(parameters, SPARE, 7.0, False)
    body = world.parameters.bodies[0, SPARE]
    assert body["mass"] == 7.0
    assert body["inv_mass"] == 0.0
    assert not np.any(body["inv_inertia"])


@njit
def _set_box(bodies: Any, shapes: Any, half: Any, mass: Any) -> None:
    set_box(bodies[0], shapes[0], half, mass)


@DIMENSIONS
def test_set_box_is_the_same_as_a_scene_with_that_box(dim: int) -> None:
    module: Any = gsenv.solver.planar if dim == 2 else gsenv.solver.spatial
    half, mass = np.array([0.3, 0.7, 0.2])[:dim], 4.0
    old, new = Scene(dim=dim), Scene(dim=dim)
    old.add_body("box", shapes=[box(dim, position=at(dim, 0.4))])
    shape = module.Box(half_extents=tuple(half), position=at(dim, 0.4), density=mass / np.prod(2.0 * half))
    new.add_body("box", shapes=[shape])
    world, wanted = World(old).parameters, World(new).parameters
    _set_box(as_records(world.bodies[0]), as_records(world.shapes[0]), tuple(half.tolist()), mass)
    for name in ("mass", "inertia", "inv_mass", "inv_inertia", "extent", "radius"):
        np.testing.assert_allclose(world.bodies[name], wanted.bodies[name], rtol=1e-14, err_msg=name)
    for name in ("size", "extent", "density"):
        np.testing.assert_allclose(world.shapes[name], wanted.shapes[name], rtol=1e-14, err_msg=name)


@DIMENSIONS
def test_parameters_set_and_the_kernel_agree(dim: int) -> None:
    half, mass = np.array([0.3, 0.7, 0.2])[:dim], 4.0
    scene = Scene(dim=dim)
    scene.add_body("box", shapes=[box(dim)])
    world, other = World(scene).parameters, World(scene).parameters
    _set_box(as_records(world.bodies[0]), as_records(world.shapes[0]), tuple(half.tolist()), mass)
    other.set("box", half_extents=half[None], density=mass / np.prod(2.0 * half))
    for name in ("mass", "inertia", "inv_mass", "inv_inertia", "extent", "radius"):
        np.testing.assert_allclose(world.bodies[name], other.bodies[name], rtol=1e-14, err_msg=name)


# ---------------------------------------------------------------- poses


@DIMENSIONS
def test_place_body_puts_the_bodys_frame_where_set_pose_does(dim: int) -> None:
    """Also where the centre of mass is not in the frame's origin."""
    scene = Scene(dim=dim)
    scene.add_body("box", shapes=[box(dim, position=at(dim, 0.4, 0.3))])
    world, other = World(scene), World(scene)
    angle = 0.6
    half = np.array([np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)])
    position = at(dim, 2.0, -1.0)
    velocity = tuple(0.1 * k for k in range(len(REST[dim])))
    if dim == 2:
        place(world, 0, position, (np.cos(angle), np.sin(angle), angle), velocity)
        other.set_pose("box", position=position, angle=angle)
    else:
        place(world, 0, position, tuple(half / np.sqrt((half**2).sum())), velocity)
        other.state.bodies["rotation"][0, 0] = half
        center = world.parameters.bodies["center"][0, 0]
        turned = [
            np.cos(angle) * center[0] - np.sin(angle) * center[1],
            np.sin(angle) * center[0] + np.cos(angle) * center[1],
            center[2],
        ]
        other.state.bodies["position"][0, 0] = np.array(position) + turned
    for name in ("position", "rotation", "angle"):
        np.testing.assert_allclose(world.state.bodies[name], other.state.bodies[name], atol=1e-15, err_msg=name)
    np.testing.assert_array_equal(world.state.bodies["velocity"][0, 0], velocity)


@DIMENSIONS
def test_what_rested_on_a_body_that_is_put_elsewhere_wakes_and_falls(dim: int) -> None:
    world = asleep(dim)
    place(world, LOWER, at(dim, 5.0, 4.0))
    assert not world.asleep[0, [LOWER, UPPER]].any()
    _, _, contacts = records(world)
    touched = (contacts["body_a"] == LOWER) | (contacts["body_b"] == LOWER)
    assert touched.any()
    assert not contacts["impulse"][touched].any()
    world.step(60)
    assert height(world, UPPER) == pytest.approx(0.5, abs=1e-2)


@DIMENSIONS
def test_a_body_that_is_put_on_a_sleeping_one_wakes_it(dim: int) -> None:
    world = asleep(dim)
    _, parameters, _ = records(world)
    place(world, SPARE, at(dim, 2.6))
    _enable(parameters, SPARE)
    assert world.asleep[0, UPPER]  # out of touch as yet
    world.step(20)
    assert not world.asleep[0, [LOWER, UPPER, SPARE]].any()
    world.step(100)
    assert height(world, SPARE) == pytest.approx(2.5, abs=1e-2)


@njit
def _enable(parameters: Any, b: Any) -> None:
    enable_body(parameters[b])


@njit
def _sleep(bodies: Any, b: Any) -> None:
    sleep_body(bodies[b])


@DIMENSIONS
def test_a_body_that_is_put_to_sleep_waits_until_it_is_touched(dim: int) -> None:
    world = asleep(dim)
    bodies, parameters, _ = records(world)
    place(world, SPARE, at(dim, 4.0))
    _enable(parameters, SPARE)
    _sleep(bodies, SPARE)
    world.step(60)
    assert height(world, SPARE) == 4.0  # in the air
    place(world, LOWER, at(dim, 5.2))  # falls onto it
    world.step(120)
    assert height(world, SPARE) < 3.0


# ---------------------------------------------------------------- enabled


@DIMENSIONS
def test_what_rested_on_a_body_that_is_disabled_wakes_and_falls(dim: int) -> None:
    world = asleep(dim)
    bodies, parameters, contacts = records(world)
    disable_body(LOWER, bodies, parameters, contacts)
    assert not world.asleep[0, UPPER]
    assert world.parameters.bodies["inv_mass"][0, LOWER] == 0.0
    lower = world.position[0, LOWER].copy()
    world.step(60)
    assert height(world, UPPER) == pytest.approx(0.5, abs=1e-2)
    np.testing.assert_array_equal(world.position[0, LOWER], lower)


@DIMENSIONS
def test_enabling_a_static_body_gives_it_no_mass(dim: int) -> None:
    scene = tower(dim)
    scene.add_body("shelf", "static", [box(dim)], position=at(dim, 0.0, 3.0), enabled=False)
    world = World(scene)
    _, parameters, _ = records(world)
    _enable(parameters, 4)
    shelf = world.parameters.bodies[0, 4]
    assert shelf["enabled"] == 1
    assert shelf["inv_mass"] == 0.0
    assert not np.any(shelf["inv_inertia"])


@njit
def _switch(joints: Any, j: Any, bodies: Any, on: Any) -> None:
    if on:
        enable_joint(joints[j], bodies[LOWER], bodies[UPPER])
    else:
        disable_joint(joints[j], bodies[LOWER], bodies[UPPER])


@DIMENSIONS
def test_joints_that_are_switched_wake_their_bodies(dim: int) -> None:
    scene = tower(dim)
    module: Any = gsenv.solver.planar if dim == 2 else gsenv.solver.spatial
    scene.add_joint("weld", module.Weld("lower", "upper", enabled=False))
    world = World(scene)
    for on in (True, False):
        world.step(120)
        assert world.asleep[0, [LOWER, UPPER]].all()
        bodies, _, _ = records(world)
        _switch(as_records(world.parameters.joints[0]), 0, bodies, on)
        assert world.parameters.joints["enabled"][0, 0] == on
        assert not world.asleep[0, [LOWER, UPPER]].any()
