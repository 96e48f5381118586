"""Jointed bodies on rods and ropes: chains of them, loads, and rods that cannot hold."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from gsenv.solver import Scene, World, planar, spatial

from .test_nothing_tears import BOTH, ball, box, joints_of, place


def taut_chain(dim: int, count: int, length: float, short: float) -> Scene:
    """``count`` pairs of planks on a hinge in a straight line, tied by rods whose gaps are too short for them."""
    scene = Scene(dim=dim)
    plank = box(dim, 0.25, 0.05, 0.25)
    left, right = place(dim, -0.25, 0), place(dim, 0.25, 0)
    hinge: Any = planar.Revolute if dim == 2 else spatial.Hinge
    axis: dict[str, Any] = {} if dim == 2 else {"axis": (0, 1, 0)}
    gap = (1.0 - short) * length
    scene.add_body("start", "static", position=place(dim, -0.25 - gap, 0))
    last = "start"
    for k in range(count):
        x = k * (1.0 + gap)
        for half, at in (("a", x), ("b", x + 0.5)):
            scene.add_body(f"{half}{k}", shapes=[plank], mass=10.0, position=place(dim, at, 0))
        scene.add_joint(f"hinge{k}", hinge(f"a{k}", f"b{k}", anchor_a=right, anchor_b=left, **axis))
        from_start = place(dim, 0, 0) if k == 0 else right
        rod = joints_of(dim).Distance(last, f"a{k}", anchor_a=from_start, anchor_b=left, length=length)
        scene.add_joint(f"rod{k}", rod)
        last = f"b{k}"
    scene.add_body("end", "static", position=place(dim, count * (1.0 + gap) - 0.25, 0))
    rod = joints_of(dim).Distance(last, "end", anchor_a=right, anchor_b=place(dim, 0, 0), length=length)
    scene.add_joint(f"rod{count}", rod)
    return scene


@BOTH
@pytest.mark.parametrize("short", [1e-3, 0.025, 0.2])
@pytest.mark.parametrize(("count", "length"), [(1, 0.02), (1, 0.2), (2, 0.02), (2, 0.2), (15, 0.02), (15, 0.2)])
def test_jointed_planks_on_rods_buckle_where_these_are_too_long(
    dim: int, count: int, length: float, short: float
) -> None:
    """In the straight line the rods contradict each other: no small displacement makes room for them."""
    world = World(taut_chain(dim, count, length, short))
    worst = []
    for _ in range(120):
        world.step()
        worst.append(float(world.diagnostics().relative_joint_error[0]))
    assert max(worst) < 0.05
    assert max(worst[5:]) < 0.01
    assert abs(world.position).max() < count * (1.0 + length) + 1.0
    assert world.diagnostics().energy[0] < 0.0  # of its start; buckling makes none


def doll_on_chain(dim: int, links: int, rope: bool) -> Scene:
    """A torso with two jointed legs on a chain of beads of 0.1 kg, let go 30 degrees from the vertical."""
    scene = Scene(dim=dim)
    sine, cosine = math.sin(math.pi / 6), math.cos(math.pi / 6)
    length = 1.0 / (links + 1)
    middle = place(dim, 0, 0)
    given: dict[str, Any] = {"limits": (0.0, length)} if rope else {"length": length}
    hinge: Any = planar.Revolute if dim == 2 else spatial.Hinge
    axis: dict[str, Any] = {} if dim == 2 else {"axis": (0, 1, 0)}
    scene.add_body("top", "static", position=middle)
    last = "top"
    for k in range(links):
        at = (k + 1) * length
        scene.add_body(f"bead{k}", shapes=[ball(dim, 0.01)], mass=0.1, position=place(dim, at * sine, -at * cosine))
        tie = joints_of(dim).Distance(last, f"bead{k}", anchor_a=middle, anchor_b=middle, **given)
        scene.add_joint(f"tie{k}", tie)
        last = f"bead{k}"
    x, z = sine, -cosine - 0.3
    scene.add_body("torso", shapes=[box(dim, 0.2, 0.3, 0.1)], mass=20.0, position=place(dim, x, z))
    tie = joints_of(dim).Distance(last, "torso", anchor_a=middle, anchor_b=place(dim, 0, 0.3), **given)
    scene.add_joint("tie", tie)
    for side, at in (("left", -0.15), ("right", 0.15)):
        scene.add_body(side, shapes=[box(dim, 0.05, 0.3, 0.05)], mass=5.0, position=place(dim, x + at, z - 0.6))
        anchors = {"anchor_a": place(dim, at, -0.3), "anchor_b": place(dim, 0, 0.3)}
        scene.add_joint(f"hip {side}", hinge("torso", side, **anchors, **axis))
    return scene


@BOTH
@pytest.mark.parametrize("rope", [False, True])
@pytest.mark.parametrize("links", [0, 3, 20])
def test_doll_on_a_chain_keeps_the_lengths_and_swings(dim: int, links: int, rope: bool) -> None:
    world = World(doll_on_chain(dim, links, rope))
    energy = world.diagnostics().energy[0]
    worst = 0.0
    x = [float(world.position[0, -3, 0])]
    for _ in range(240):
        world.step()
        x.append(float(world.position[0, -3, 0]))
        worst = max(worst, float(world.diagnostics().relative_joint_error[0]))
    assert worst < 2e-3
    assert world.diagnostics().energy[0] < energy + 1e-3 * 30.0 * 9.81
    assert min(x) < -0.4  # of the 0.5 from which it starts: it is not braked


@BOTH
def test_rods_that_contradict_each_other_make_little_energy(dim: int) -> None:
    """A pair of planks of 0.5 m between fixed points 3 m apart, on two rods of 0.7 m: they do not reach."""
    scene = Scene(dim=dim)
    hinge: Any = planar.Revolute if dim == 2 else spatial.Hinge
    axis: dict[str, Any] = {} if dim == 2 else {"axis": (0, 1, 0)}
    left, right, middle = place(dim, -0.25, 0), place(dim, 0.25, 0), place(dim, 0, 0)
    scene.add_body("start", "static")
    scene.add_body("end", "static", position=place(dim, 3, 0))
    for k, mass in enumerate((1.0, 1.5)):
        scene.add_body(
            f"plank{k}", shapes=[box(dim, 0.25, 0.04, 0.04)], mass=mass, position=place(dim, 0.25 + 0.5 * k, 0)
        )
    scene.add_joint("hinge", hinge("plank0", "plank1", anchor_a=right, anchor_b=left, **axis))
    rod = joints_of(dim).Distance
    scene.add_joint("rod0", rod("start", "plank0", anchor_a=middle, anchor_b=left, length=0.7))
    scene.add_joint("rod1", rod("plank1", "end", anchor_a=right, anchor_b=middle, length=0.7))
    worlds = 24
    world = World(scene, world_count=worlds)
    rng = np.random.default_rng(0)
    for k in range(2):
        world.set_velocity(f"plank{k}", linear=1e-3 * rng.standard_normal((worlds, dim)))
    start = np.array(world.diagnostics().energy)
    gain = np.zeros(worlds)
    for _ in range(300):
        before = np.array(world.position)
        world.step()
        gain = np.maximum(gain, world.diagnostics().energy - start)
    assert np.max(gain) < 1.0
    assert abs(world.position - before).max() < 0.01  # they do not jump about


@pytest.mark.parametrize("slack", [None, "hub", "fixed"])
@pytest.mark.parametrize("ropes", [1, 2, 4])
def test_fast_rotors_over_a_load_on_ropes_keep_their_energy(ropes: int, slack: str | None) -> None:
    """Thin rotors at 50 rad/s on a hub that flies with a load, without gravity: rows would let them gain energy.

    ``slack``: what a rope that never becomes taut ties the load to.
    """
    scene = Scene(dim=3, gravity=(0.0, 0.0, 0.0))
    scene.add_body(
        "hub", shapes=[spatial.Box(half_extents=(0.3, 0.3, 0.03))], mass=2.0, linear_velocity=(-0.1, 0.0, 0.25)
    )
    for k, (x, y) in enumerate(((-0.3, -0.3), (0.3, -0.3), (-0.3, 0.3), (0.3, 0.3))):
        blade = spatial.Box(half_extents=(0.12, 0.02, 0.01))
        spin = (0.0, 0.0, 50.0 * (1, -1, -1, 1)[k])
        scene.add_body(f"rotor{k}", shapes=[blade], mass=0.1, position=(x, y, 0.06), angular_velocity=spin)
        scene.add_joint(f"axle{k}", spatial.Hinge("hub", f"rotor{k}", anchor=(x, y, 0.06), axis=(0, 0, 1)))
    load = spatial.Box(half_extents=(0.2, 0.2, 0.1))
    scene.add_body("load", shapes=[load], mass=1.0, position=(0, 0, -1), linear_velocity=(0.3, 0.2, -0.5))
    for k, (x, y) in enumerate(((-0.2, 0.2), (0.2, -0.2), (0.2, 0.2), (-0.2, -0.2))[:ropes]):
        rope = spatial.Distance("hub", "load", anchor_a=(x, y, 0.0), anchor_b=(x, y, 0.1), limits=(0.0, 0.9))
        scene.add_joint(f"rope{k}", rope)
    scene.add_body("fixed", "static")
    if slack:
        scene.add_joint("slack", spatial.Distance(slack, "load", limits=(0.0, 50.0)))
    world = World(scene)
    for _ in range(30):
        world.step()  # the ropes become taut and take energy
    energy = world.diagnostics().energy[0]
    for _ in range(270):
        world.step()
        assert world.diagnostics().energy[0] < 1.001 * energy
    assert world.diagnostics().energy[0] > 0.97 * energy
    assert world.diagnostics().relative_joint_error[0] < 1e-4
