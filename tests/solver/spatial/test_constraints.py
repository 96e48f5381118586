"""User constraints in 3D, and a ball joint that was solved by hand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Handle, Options, Scene, World
from gsenv.solver.spatial import Ball, Box, Sphere
from tests.solver.spatial.one_kernel import full_world, space

G = 9.81
INF = math.inf

# ---------------------------------------------------------------- a ball joint solved by hand

R_A, R_B = np.array((0.5, 0.0, 0.0)), np.array((-0.5, 0.0, 0.0))
ERROR = np.array((0.0, 0.1, 0.0))  # of A's anchor over B's
BETA = 0.2
SPIN = (0.0, 0.0, 2.0)
ONE_STEP = Options(timestep=1.0, substeps=1, max_substeps=1, sleep=False, tolerance=0.0, position_sweeps=0)


def cross_matrix(v: np.ndarray) -> np.ndarray:
    x, y, z = v
    return np.array(((0.0, -z, y), (z, 0.0, -x), (-y, x, 0.0)))


BALL = np.hstack([np.eye(3), -cross_matrix(R_A), -np.eye(3), cross_matrix(R_B)])


def joint_after_a_step(rows: np.ndarray, bias: Any, pinned: bool = False) -> World:
    """Bodies of m = 1 and I = 1, A spinning, under rows of the joint's Jacobian; after one step of 1 s."""
    scene = space()
    scene.add_body("a", shapes=[Sphere(radius=0.1)], mass=1.0, inertia=(1, 1, 1), angular_velocity=SPIN)
    if pinned:
        scene.add_body("b", "static", position=(1, -0.1, 0))
    else:
        scene.add_body("b", shapes=[Sphere(radius=0.1)], mass=1.0, inertia=(1, 1, 1), position=(1, -0.1, 0))
    scene.add_constraint("joint", ["a", "b"], rows, bias=bias)
    world = full_world(scene, options=ONE_STEP)
    world.step()
    return world


def changes(world: World) -> np.ndarray:
    """(12,) velocities of A and B minus those before."""
    v = np.concatenate([world.linear_velocity[0, :2], world.angular_velocity[0, :2]], 1).ravel()
    v[3:6] -= SPIN
    return np.asarray(v)


def test_ball_joint_solved_by_hand() -> None:
    """A = diag(2, 2.5, 2.5), b = (0, 1.02, 0), lambda = -b / diag A = (0, -.408, 0)."""
    world = joint_after_a_step(BALL, BETA * ERROR)
    expected = [0, -0.408, 0, 0, 0, -0.204, 0, 0.408, 0, 0, 0, -0.204]
    assert_allclose(changes(world), expected, atol=1e-12)
    after = changes(world) + np.array([0, 0, 0, *SPIN, *[0] * 6])
    assert_allclose(BALL @ after, (0, -0.02, 0), atol=1e-12)  # a fifth of the error goes
    reaction = world.joint_reaction(Handle("joint", "joint", 0))[0]
    assert_allclose(reaction[:3], (0, 0.408, 0), atol=1e-12)  # N over 1 s, on B


def test_ball_joint_solved_by_hand_to_a_pinned_body() -> None:
    """B gives nothing: A = diag(1, 1.25, 1.25), lambda_y = -1.02 / 1.25 = -.816."""
    world = joint_after_a_step(BALL, BETA * ERROR, pinned=True)
    assert_allclose(changes(world), [0, -0.816, 0, 0, 0, -0.408, *[0] * 6], atol=1e-12)


@pytest.mark.parametrize(("axis", "impulse"), [(0, 0.0), (1, -0.408), (2, 0.0)])
def test_one_axis_of_the_ball_joint_solved_by_hand(axis: int, impulse: float) -> None:
    """A is diagonal, so each axis alone takes the same impulse as within the joint."""
    row = BALL[axis]
    world = joint_after_a_step(row[None], BETA * ERROR[axis])
    assert_allclose(changes(world), impulse * row, atol=1e-12)


def test_weld_solved_by_hand() -> None:
    """Three more rows w_A - w_B: A = diag(2, 2.5, 2.5, 2, 2, 2), the angular impulse is -(0, 0, 2) / 2."""
    zero, one = np.zeros((3, 3)), np.eye(3)
    rows = np.vstack([BALL, np.hstack([zero, one, zero, -one])])
    world = joint_after_a_step(rows, [*(BETA * ERROR), 0, 0, 0])
    expected = [0, -0.408, 0, 0, 0, 0.796 - 2.0, 0, 0.408, 0, 0, 0, 0.796]
    assert_allclose(changes(world), expected, atol=1e-9)


# ---------------------------------------------------------------- locks, limits, clutches


def ball(gravity: float = 0.0, linked: bool = False, worlds: int = 1, **rule: Any) -> World:
    """One ball of 1 kg under a rule; ``linked``: it drags a trailer, so the joints have a factor."""
    scene = space(gravity)
    scene.add_body("ball", shapes=[Sphere(radius=0.2)], mass=1.0)
    if linked:
        scene.add_body("trailer", shapes=[Sphere(radius=0.2)], mass=1.0, position=(-1, 0, 0))
        scene.add_joint("hitch", Ball("ball", "trailer"))
    scene.add_constraint("rule", ["ball"], **rule)
    return full_world(scene, worlds)


def row(**entries: float) -> list[float]:
    """One of a body's six numbers each, by name."""
    return [entries.get(name, 0.0) for name in ("vx", "vy", "vz", "wx", "wy", "wz")]


LINKED = pytest.mark.parametrize("linked", [False, True], ids=["alone", "among joints"])


@LINKED
def test_lock(linked: bool) -> None:
    world = ball(G, linked, jacobian=[row(vz=1), row(wx=1), row(wy=1), row(wz=1)])
    world.set_velocity("ball", linear=(1, 0.5, 0))
    world.step(60)
    assert world.position[0, 0, 2] == pytest.approx(0, abs=1e-6)
    assert_allclose(world.orientation[0, 0], (1, 0, 0, 0), atol=1e-6)
    assert world.position[0, 0, 0] > 0.3


def test_a_full_lock_of_six_rows_carries_the_weight() -> None:
    world = ball(G, jacobian=np.eye(6))
    world.apply_force("ball", force=(0, 0, 0))
    world.step(30)
    world.apply_force("ball", force=(1.0, 2.0, 0.0), torque=(0.1, 0.2, 0.3))
    world.step()
    reaction = world.joint_reaction(Handle("joint", "rule", 0))[0]
    assert_allclose(reaction, (-1, -2, G, -0.1, -0.2, -0.3), atol=1e-4)
    assert_allclose(world.position[0, 0], 0.0, atol=1e-9)


@LINKED
def test_driven_lock_moves_at_its_speed(linked: bool) -> None:
    world = ball(linked=linked, jacobian=row(vy=1), bias=-2.0)
    world.step(60)
    assert world.linear_velocity[0, 0, 1] == pytest.approx(2, rel=1e-9)
    assert world.position[0, 0, 1] == pytest.approx(2, abs=0.04)


@LINKED
def test_speed_limit(linked: bool) -> None:
    # |v| <= 3 along (.6, .8, 0) on each side, as two rows; 6 m/s^2 reach it after half a second
    way = np.array((0.6, 0.8, 0.0))
    rows = [[*way, 0, 0, 0], [*-way, 0, 0, 0]]
    world = ball(linked=linked, jacobian=rows, bias=[-3.0, -3.0], upper=0.0)
    mass = world.parameters.mass[0, : 1 + linked].sum()
    for sign in (1.0, -1.0):
        for _ in range(90):
            world.apply_force("ball", force=6.0 * sign * mass * way)
            world.step()
            assert abs(world.linear_velocity[0, 0] @ way) < 3.0 + 1e-6
        assert world.linear_velocity[0, 0] @ way == pytest.approx(3.0 * sign, rel=1e-6)


def two_discs(axis: np.ndarray, **clutch: Any) -> World:
    """Two discs on fixed axles along ``axis``; their inertia about it is .5 kg m^2."""
    scene = space()
    for k, name in enumerate("ab"):
        scene.add_body(name, shapes=[Sphere(radius=0.3)], mass=1.0, inertia=(0.5, 0.5, 0.5), position=(2.0 * k, 0, 0))
    turn = [*np.zeros(3), *-axis, *np.zeros(3), *axis]
    scene.add_constraint("clutch", ["a", "b"], turn, **clutch)
    return full_world(scene)


def test_relative_speed_limit() -> None:
    """v2 - v1 <= vmax: a pulls b along once it is faster by that."""
    scene = space()
    for k, name in enumerate("ab"):
        scene.add_body(name, shapes=[Sphere(radius=0.1)], mass=1.0, position=(0, 3.0 * k, 0))
    scene.add_constraint("limit", ["a", "b"], [*row(vx=-1), *row(vx=1)], bias=-1.5, upper=0.0)
    world = full_world(scene)
    for k in range(1, 121):
        world.apply_force("b", force=(3.0, 0, 0))
        world.step()
        t = k / 60.0
        expected = (0.0, 3.0 * t) if t <= 0.5 else (1.5 * (t - 0.5), 1.5 + 1.5 * (t - 0.5))
        assert_allclose(world.linear_velocity[0, :2, 0], expected, atol=0.03)
    assert world.linear_velocity[0, 1, 0] - world.linear_velocity[0, 0, 0] == pytest.approx(1.5, abs=1e-6)


@pytest.mark.parametrize("axis", [(0.0, 0.0, 1.0), (0.6, 0.0, -0.8)])
def test_one_way_clutch(axis: tuple[float, ...]) -> None:
    """a drives b forwards, b overruns when a slows down."""
    u = np.array(axis)
    world = two_discs(u, lower=0.0)
    for k in range(1, 61):
        world.apply_force("a", torque=3.0 * u)
        world.step()
        assert_allclose(world.angular_velocity[0, :2], np.tile(3.0 * k / 60.0 * u, (2, 1)), atol=1e-6)
    for _ in range(60):
        world.apply_force("a", torque=-3.0 * u)
        world.step()
    assert_allclose(world.angular_velocity[0, :2], [-3.0 * u, 3.0 * u], atol=1e-6)


def test_slipping_clutch_passes_its_torque() -> None:
    u = np.array((0.0, 1.0, 0.0))
    world = two_discs(u, lower=-0.2, upper=0.2)
    world.set_velocity("a", angular=5.0 * u)
    world.step(60)
    assert_allclose(world.angular_velocity[0, :2], [4.6 * u, 0.4 * u], atol=1e-9)  # .2 N m / .5 kg m^2 for 1 s
    world.step(600)
    assert_allclose(world.angular_velocity[0, :2], [2.5 * u, 2.5 * u], atol=1e-6)


# ---------------------------------------------------------------- frame, update


@pytest.mark.parametrize("spin", [(0.0, 0.0, 1.0), (0.0, 0.0, -4.0)])
def test_skate_runs_a_circle(spin: tuple[float, ...]) -> None:
    """A blade that does not slip sideways and turns at a steady rate."""
    scene = space()
    c, s = math.cos(0.2), math.sin(0.2)
    scene.add_body(
        "blade", shapes=[Box(half_extents=(0.5, 0.1, 0.1))], mass=1.0, orientation=(c, 0, 0, s), angular_velocity=spin,
        linear_velocity=(math.cos(0.4), math.sin(0.4), 0),
    )  # fmt: skip
    scene.add_constraint("edge", ["blade"], row(vy=1), frame="body")
    world = full_world(scene)
    w = spin[2]
    for k in range(1, 121):
        world.step()
        a = 0.4 + w * k / 60.0
        exact = np.array((math.sin(a) - math.sin(0.4), math.cos(0.4) - math.cos(a), 0.0)) / w
        assert_allclose(world.position[0, 0], exact, atol=1e-3 * abs(w))
        assert np.hypot.reduce(world.linear_velocity[0, 0]) == pytest.approx(1, rel=1e-4 * w**2)


def test_directions_turn_with_the_first_body() -> None:
    """Guides across the x axis of a turned body: the other is free to move along it only."""
    q = np.array((0.8, 0.1, -0.3, 0.5)) / math.sqrt(0.99)
    scene = space()
    scene.add_body("a", "kinematic", [Box(half_extents=(0.2, 0.2, 0.2))], orientation=q)
    scene.add_body("b", shapes=[Sphere(radius=0.1)], mass=1, position=(3, 0, 0), linear_velocity=(1, 0, 0))
    rows = [[*row(vy=1), *row(vy=-1)], [*row(vz=1), *row(vz=-1)]]
    scene.add_constraint("guide", ["a", "b"], rows, frame="body")
    world = full_world(scene)
    world.step(30)
    w, x, y, z = q
    along = np.array((1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)))
    assert_allclose(world.linear_velocity[0, 1], along[0] * along, atol=1e-6)


def sphere_wire(world: World) -> dict[str, Any]:
    """A row that keeps a bead at 1 m from the origin: its direction half a step ahead, and what it turns by."""
    x, v, dt = world.center_of_mass[:, 0], world.linear_velocity[:, 0], world.timestep
    ahead = x + 0.5 * dt * v
    size = np.hypot.reduce(ahead, axis=1)
    zero = np.zeros_like(x)
    return {
        "jacobian": np.concatenate([ahead / size[:, None], zero], 1)[:, None],
        "bias": 0.5 * dt * (v * v).sum(1, keepdims=True) / size[:, None],
        "error": np.hypot.reduce(x, axis=1)[:, None] - 1.0,
    }


def test_update_keeps_a_bead_on_a_sphere() -> None:
    scene: Scene = space(G)
    scene.add_body("bead", shapes=[Sphere(radius=0.05)], mass=1.0)
    scene.add_constraint("wire", ["bead"], row(vx=1), update=sphere_wire)
    world = full_world(scene, 3, Options(timestep=1.0 / 240.0, substeps=1, sleep=False))
    starts = np.array([(1.0, 0, 0), (0, 0.6, 0.8), (0, 0, -1.0)])
    world.set_pose("bead", position=starts)
    world.set_velocity("bead", linear=[(0, 2, 0), (1, 0, 0), (0, 1, 0)])
    start = world.diagnostics().energy
    for _ in range(480):
        world.step()
        assert_allclose(np.hypot.reduce(world.center_of_mass[:, 0], axis=1), 1.0, atol=1e-3)
        assert_allclose(world.diagnostics().energy, start, atol=5e-3 * G)


def test_rows_of_each_world_and_snapshots() -> None:
    world = ball(G, worlds=3, jacobian=row(vz=1), update=lambda world: {"bias": -np.arange(3.0)[:, None]})
    world.step(30)
    saved = world.save()
    world.step(30)
    assert_allclose(world.linear_velocity[:, 0, 2], (0, 1, 2), atol=1e-5)
    after = world.position
    world.restore(saved)
    world.step(30)
    np.testing.assert_array_equal(world.position, after)


@pytest.mark.parametrize(
    ("returned", "message"),
    [
        ({"jacobian": [1, 0, 0]}, r"jacobian must fit the shape \(1, 1, 6\), got an array of shape \(3,\)"),
        ({"jacobian": [math.nan, 0, 0, 0, 0, 0]}, "jacobian must be finite"),
        ({"error": np.zeros((3, 1))}, r"error must fit the shape \(1, 1\)"),
        ({"torque": 1.0}, "name 'torque' is unknown"),
    ],
)
def test_bad_updates_are_refused(returned: dict[str, Any], message: str) -> None:
    world = ball(jacobian=row(vz=1), update=lambda world: returned)
    before = world.state.bodies.copy()
    with pytest.raises(ValueError, match=f"^update of constraint 'rule'.*{message}"):
        world.step()
    assert (world.state.bodies == before).all()
