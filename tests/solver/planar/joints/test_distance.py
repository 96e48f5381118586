"""Distance joints: rods, ropes, and what happens where the anchors meet."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.special import ellipk

from gsenv.solver import Options, Scene, World
from gsenv.solver.planar import Circle, Distance
from tests.solver.planar.joints.rigs import AWAKE, FIDELITIES, INF, G, energy, held, joint, travel

every_fidelity = pytest.mark.parametrize("options", FIDELITIES.values(), ids=FIDELITIES)


def on_a_rod(angle: float, options: Options = AWAKE, solid: bool = True) -> World:
    """The bar on a rod of 1 m, ``angle`` rad from hanging down."""
    place = (math.sin(angle), -math.cos(angle))
    return held("distance", gravity=G, position=place, anchor_a=(0, 0), solid=solid, options=options)


@every_fidelity
@pytest.mark.parametrize("angle", [0.3, 0.8])
def test_period_of_a_rod_pendulum(angle: float, options: Options) -> None:
    world = on_a_rod(angle, options, solid=False)
    x = []
    for _ in range(600):
        world.step()
        assert world.diagnostics().joint_error[0] < 1e-5
        x.append(world.position[0, 1, 0])
    down = np.flatnonzero((np.array(x[:-1]) > 0) & (np.array(x[1:]) <= 0))
    crossings = [(k + 1 + x[k] / (x[k] - x[k + 1])) / 60.0 for k in down]
    period = 4.0 * math.sqrt(1.0 / G) * ellipk(math.sin(angle / 2) ** 2)
    assert np.diff(crossings).mean() == pytest.approx(period, rel=3e-4)


@pytest.mark.parametrize("solid", [True, False], ids=["solid", "without shapes"])
@pytest.mark.parametrize("angle", [0.3, 2.0])
def test_rod_pendulum_keeps_its_energy(angle: float, solid: bool) -> None:
    world = on_a_rod(angle, solid=solid)
    start = energy(world)
    for _ in range(300):
        world.step()
        assert energy(world) == pytest.approx(start, abs=4e-3 * 2 * G)


def test_order_of_a_rod_pendulum() -> None:
    def after(steps: int) -> np.ndarray:
        options = Options(timestep=1.0 / steps, substeps=1, max_substeps=1, sleep=False, tolerance=1e-9)
        world = on_a_rod(1.5, options, solid=False)
        world.step(steps)
        return world.position[0, 1]

    exact = after(7680)
    errors = [abs(after(steps) - exact).max() for steps in (120, 240)]
    assert errors[0] < 1e-3
    assert 3.5 < errors[0] / errors[1] < 5.0


@every_fidelity
@pytest.mark.parametrize("solid", [True, False], ids=["solid", "without shapes"])
def test_rope_is_slack_then_taut(options: Options, solid: bool) -> None:
    world = held(
        "distance", gravity=G, position=(0, -0.5), velocity=(0.5, 0), anchor_a=(0, 0), limits=(0, 1.0), solid=solid,
        options=options,
    )  # fmt: skip
    length, fallen = [], 0.0
    for k in range(1, 181):
        world.step()
        length.append(world.joint_coordinate("joint")[0])
        t = k / 60.0
        if length[-1] < 0.98:  # slack: a free fall, no force
            np.testing.assert_allclose(world.position[0, 1], (0.5 * t, -0.5 - 0.5 * G * t**2), rtol=1e-9)
            np.testing.assert_array_equal(world.joint_reaction("joint")[0], 0.0)
            fallen = t
    assert 0.2 < fallen < 0.35
    assert max(length) < 1.0 + 1e-4
    taut = int(np.argmax(np.array(length) > 1.0 - 1e-4))
    np.testing.assert_allclose(length[taut:], 1.0, atol=1e-4)  # no bounce


def test_rope_carries_a_load_at_rest() -> None:
    world = held("distance", gravity=G, position=(0, -1), anchor_a=(0, 0), limits=(0, 1.0))
    world.step(60)
    assert world.joint_coordinate("joint")[0] == pytest.approx(1, abs=1e-6)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, 0), rtol=1e-5, atol=1e-9)


def test_strut_keeps_apart_what_it_is_between() -> None:
    world = held("distance", gravity=G, position=(0, 1), anchor_a=(0, 0), limits=(0.6, INF))
    q = travel(world, 120)
    assert q.min() > 0.6 - 1e-6
    assert q[-1] == pytest.approx(0.6, abs=1e-6)
    np.testing.assert_allclose(world.joint_reaction("joint")[0], (0, 2 * G, 0), rtol=1e-4, atol=1e-6)


def test_winch() -> None:
    # a rope that is made shorter takes its load along; a longer one lets it fall
    world = held("distance", gravity=G, position=(0, -1), anchor_a=(0, 0), limits=(0, 1.0))
    for length in np.linspace(1.0, 0.5, 121):
        world.parameters.set(joint(world), upper=length)
        world.step()
    world.step(60)
    np.testing.assert_allclose(world.position[0, 1], (0, -0.5), atol=1e-3)
    world.parameters.set(joint(world), upper=0.9)
    world.step(60)
    np.testing.assert_allclose(world.position[0, 1], (0, -0.9), atol=1e-3)


def test_lengths_are_not_negative() -> None:
    world = held("distance", position=(0, -1), anchor_a=(0, 0), limits=(0, 1.0))
    with pytest.raises(ValueError, match=r"joint 'joint': a distance can't be below -1\.0"):
        world.parameters.set(joint(world), lower=-2.0, upper=-1.0)
    with pytest.raises(ValueError, match="length must not be negative"):
        world.parameters.set(joint(world), length=-1.0)
    np.testing.assert_array_equal(world.parameters.upper, 1.0)


@pytest.mark.parametrize("given", [{}, {"limits": (0, 0.0)}, {"frequency": 2.0}, {"limits": (0, 1.0)}])
def test_anchors_that_meet_are_calm(given: dict[str, Any]) -> None:
    length: dict[str, Any] = {} if "limits" in given else {"length": 0.0}
    world = held("distance", gravity=G, anchor=(0, 0), **length, **given)
    start = energy(world)
    for _ in range(300):
        world.step()
        assert energy(world) < start + 1e-2 * G
    assert np.isfinite(world.position).all()
    assert world.joint_coordinate("joint")[0] < 1.01


def test_spring_through_the_point_where_its_anchors_meet() -> None:
    # relaxed at length 0 it is a spring in the plane: x and y swing apart from each other
    world = held(
        "distance", position=(0.3, 0), velocity=(0, 0.9), anchor_a=(0, 0), length=0.0, frequency=0.5, damping_ratio=0.0
    )
    omega = math.pi
    for k in range(1, 241):
        world.step()
        t = k / 60.0
        exact = (0.3 * math.cos(omega * t), 0.9 / omega * math.sin(omega * t))
        np.testing.assert_allclose(world.position[0, 1], exact, atol=1e-3)


def test_rod_between_free_bodies() -> None:
    # two balls whirl about their centre of mass: T = m1 m2 / (m1 + m2) L w^2
    scene = Scene(gravity=(0, 0))
    scene.add_body("light", shapes=[Circle(radius=0.1)], mass=1.0, position=(-0.75, 0), linear_velocity=(0, -1.5))
    scene.add_body("heavy", shapes=[Circle(radius=0.1)], mass=3.0, position=(0.25, 0), linear_velocity=(0, 0.5))
    scene.add_joint("rod", Distance("light", "heavy", anchor_a=(0, 0), anchor_b=(0, 0)))
    world = World(scene, options=AWAKE)
    for _ in range(120):
        world.step()
        force = world.joint_reaction("rod")[0]
        assert np.hypot(*force[:2]) == pytest.approx(0.75 * 2.0**2, rel=2e-3)
        assert force[2] == pytest.approx(0, abs=1e-12)
    assert world.joint_coordinate("rod")[0] == pytest.approx(1, abs=1e-6)
    turned = math.atan2(*(world.position[0, 1] - world.position[0, 0])[::-1]) % (2 * math.pi)
    assert turned == pytest.approx(2.0 * 2.0, abs=1e-3)


def test_a_rod_has_no_limits() -> None:
    with pytest.raises(ValueError, match="give length for a rod or limits for a rope; only a spring has both"):
        held("distance", anchor=(0, 0), length=1.0, limits=(0.0, 2.0))
    held("distance", anchor=(0, 0), length=1.0, limits=(0.0, 2.0), stiffness=10.0)
