"""Bodies that the mouse picks and drags."""

from __future__ import annotations

import numpy as np
import pytest

from gsenv.render.camera import Camera
from gsenv.render.spatial import SpatialCamera
from gsenv.solver import Scene, World, planar, spatial
from gsenv.view.camera_control import OrbitControl, PlanarControl
from gsenv.view.dragging import STRONGEST, STRONGEST_LIFT, Picked, Picker, Spring, connected

SIZE = (640, 480)


def planar_control() -> PlanarControl:
    control = PlanarControl()
    control.aim(Camera((0.0, 1.0), 6.0), SIZE)
    return control


def spatial_control() -> OrbitControl:
    control = OrbitControl()
    control.aim(SpatialCamera((0.0, -6.0, 1.0), (0.0, 0.0, 1.0)), SIZE)
    return control


def boxes(dim: int) -> World:
    """A box at a height of 0.5 m that rests on the ground."""
    scene = Scene(dim=dim)
    if dim == 2:
        scene.add_body("ground", kind="static", shapes=[planar.HalfPlane(normal=(0, 1))])
        scene.add_body("box", position=(0.0, 0.5), shapes=[planar.Box(half_extents=(0.5, 0.5))])
    else:
        scene.add_body("ground", kind="static", shapes=[spatial.Plane()])
        scene.add_body("box", position=(0.0, 0.0, 0.5), shapes=[spatial.Box(half_extents=(0.5, 0.5, 0.5))])
    return World(scene, 2)


def up(dim: int) -> np.ndarray:
    return np.eye(dim)[-1]


def chain(dim: int, light: float = 0.01) -> World:
    """Ten links of 1 kg that hang from a fixed point, with a body of `light` kg at the end."""
    scene = Scene(dim=dim)
    anchor = scene.add_body("anchor", kind="static", position=3.0 * up(dim))
    for k in range(11):
        place = 3.0 * up(dim) - (0.2 * k + 0.1) * up(dim)
        shape = (
            planar.Box(half_extents=(0.03, 0.1), mask=0)
            if dim == 2
            else spatial.Box(half_extents=(0.03, 0.03, 0.1), mask=0)
        )
        body = scene.add_body(f"link_{k}", position=place, mass=light if k == 10 else 1.0, shapes=[shape])
        joint = planar.Revolute if dim == 2 else spatial.Ball
        scene.add_joint(f"pin_{k}", joint(anchor, body, anchor=place + 0.1 * up(dim)))
        anchor = body
    return World(scene)


def hold(world: World, name: str, offset: np.ndarray | None = None) -> Spring:
    """A spring at the middle of a body, or `offset` m beside it."""
    body = world.model.body_names.index(name)
    local = np.zeros(world.model.dim) if offset is None else offset
    place = world.state.bodies["position"][0, body] + local
    return Spring(world, 0, Picked(body, local, place))


@pytest.mark.parametrize("dim", [2, 3])
def test_the_body_under_the_mouse_is_picked_at_the_point_under_the_mouse(dim: int) -> None:
    world = boxes(dim)
    control = planar_control() if dim == 2 else spatial_control()
    picker = Picker(world)
    front = np.array([0.3, 0.7]) if dim == 2 else np.array([0.3, -0.5, 0.7])
    picked = picker.pick(control, tuple(control.project(front)), 0)
    assert picked is not None
    assert picked.body == 1
    np.testing.assert_allclose(picked.point, front, atol=1e-6)
    np.testing.assert_allclose(picked.local, front - world.state.bodies["position"][0, 1], atol=1e-6)
    sky = picker.pick(control, (320.0, 5.0), 0)
    assert sky is None
    ground = picker.pick(control, (20.0, 470.0), 0)
    assert ground is not None
    assert ground.body == 0
    assert not picker.movable[ground.body]


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_a_few_px_beside_the_mouse_is_picked(dim: int) -> None:
    world = boxes(dim)
    control = planar_control() if dim == 2 else spatial_control()
    edge = np.array([0.0, 1.0]) if dim == 2 else np.array([0.0, 0.5, 1.0])  # the upper one, before the sky
    x, y = (float(part) for part in control.project(edge))
    picker = Picker(world)
    near = picker.pick(control, (x, y - 4.0), 0)
    assert near is not None
    assert near.body == 1
    far = picker.pick(control, (x, y - 12.0), 0)
    assert far is None or far.body == 0


@pytest.mark.parametrize("dim", [2, 3])
def test_a_dragged_body_follows_the_mouse_and_comes_to_rest_there(dim: int) -> None:
    world = boxes(dim)
    spring = hold(world, "box")
    goal = spring.target + 1.5 * up(dim) + np.eye(dim)[0]
    spring.move(goal)
    farthest = 0.0
    for _ in range(120):
        spring.pull()
        world.step()
        farthest = max(farthest, float(spring.point[0] - goal[0]))
    np.testing.assert_allclose(spring.point, goal, atol=1e-3)  # it has learnt to carry the weight
    assert farthest < 0.05
    np.testing.assert_allclose(world.position[1, 1], world.model.nominal_bodies["center"][1] + 0.5 * up(dim), atol=1e-3)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_sleeping_body_is_woken(dim: int) -> None:
    world = boxes(dim)
    for _ in range(300):
        world.step()
    assert world.asleep[0, 1]
    spring = hold(world, "box")
    spring.move(spring.target + 2.0 * up(dim))
    for _ in range(60):
        spring.pull()
        world.step()
    assert not world.asleep[0, 1]
    assert world.asleep[1, 1]  # in the other world
    assert spring.point[-1] > 2.0


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("light", [0.001, 0.01, 1.0])
def test_a_light_body_at_the_end_of_a_heavy_chain_is_dragged_without_oscillation(dim: int, light: float) -> None:
    world = chain(dim, light)
    spring = hold(world, "link_10")
    goal = spring.target + 0.7 * np.eye(dim)[0] + 0.5 * up(dim)
    spring.move(goal)
    start = np.abs(spring.point - goal).max()
    speeds, points = [], []
    for _ in range(600):
        spring.pull()
        world.step()
        speeds.append(float(np.abs(world.linear_velocity).max()))
        points.append(spring.point)
    assert np.isfinite(world.state.bodies["position"]).all()
    assert max(speeds) < 12.0
    assert np.abs(np.diff(points[-60:], axis=0)).max() < 0.6 * world.timestep  # m: it hardly moves any more
    error = np.abs(spring.point - goal).max()
    assert error < (0.01 if light == 1.0 else start)
    assert world.diagnostics().joint_error[0] < 2e-3


@pytest.mark.parametrize("dim", [2, 3])
def test_no_mouse_can_make_nan(dim: int) -> None:
    world = chain(dim)
    spring = hold(world, "link_10", 0.08 * up(dim))
    masses = world.parameters.bodies["mass"][0]
    bound = STRONGEST * masses[-1] + STRONGEST_LIFT * masses.sum()
    generator = np.random.default_rng(0)
    for k in range(300):
        spring.move(generator.normal(size=dim) * 10.0 ** generator.integers(-2, 9))
        if k % 50 == 0:
            spring.move(np.full(dim, np.nan))
        force = spring.force()
        assert force is not None
        assert np.sqrt(force @ force) <= bound * (1.0 + 1e-9)
        spring.pull()
        world.step()
        assert np.isfinite(world.state.bodies["position"]).all()
    assert np.isfinite(world.linear_velocity).all()


def test_static_and_disabled_bodies_are_not_pulled() -> None:
    world = boxes(2)
    assert hold(world, "ground").force() is None
    world.parameters.set("box", enabled=False)
    spring = hold(world, "box")
    assert spring.force() is None
    spring.pull()
    world.step()
    assert np.isfinite(world.position).all()


def test_connected_bodies_are_those_that_joints_reach() -> None:
    world = chain(2)
    assert list(connected(world, 0, 5)) == list(range(1, 12))
    world.parameters.joints["enabled"][0, 3] = 0
    assert list(connected(world, 0, 5)) == list(range(4, 12))
    assert list(connected(boxes(2), 0, 1)) == [1]
