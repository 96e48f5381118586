"""Velocities that joints do not allow, and the energy of fast links: momenta and energies against numpy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import World
from gsenv.solver.planar import Revolute
from gsenv.solver.spatial import Ball
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_dynamics import Tree
from tests.solver.core.articulation.test_step import rods
from tests.solver.core.articulation.test_step3d import floating

Array = np.ndarray[Any, Any]


def bodies_of(world: World) -> tuple[Array, Array, Array]:
    """(positions (body, 3), velocities (body, 6), mass matrices (body, 6, 6)) of the moving bodies, as in 3D."""
    parameters = world.parameters.bodies[0]
    moving = np.flatnonzero((parameters["inv_mass"] > 0.0) & (parameters["enabled"] != 0))
    dim = world.model.dim
    positions = np.zeros((len(moving), 3))
    positions[:, :dim] = world.center_of_mass[0, moving]
    velocities = np.zeros((len(moving), 6))
    velocities[:, :dim] = world.linear_velocity[0, moving]
    masses = np.zeros((len(moving), 6, 6))
    for n, i in enumerate(moving):
        masses[n, range(3), range(3)] = parameters["mass"][i]
        if dim == 2:
            velocities[n, 5] = world.angular_velocity[0, i]
            masses[n, range(3, 6), range(3, 6)] = parameters["inertia"][i]
        else:
            velocities[n, 3:] = world.angular_velocity[0, i]
            matrix = rotation(world.orientation[0, i])
            masses[n, 3:, 3:] = matrix @ np.diag(parameters["inertia"][i]) @ matrix.T
    return positions, velocities, masses


def momentum(world: World) -> Array:
    """Linear momentum, and angular momentum about the origin."""
    x, v, m = bodies_of(world)
    p = np.einsum("nij,nj->ni", m, v)
    return np.concatenate([p[:, :3].sum(0), (np.cross(x, p[:, :3]) + p[:, 3:]).sum(0)])


def energy(world: World) -> float:
    _, v, m = bodies_of(world)
    return 0.5 * float(np.einsum("ni,nij,nj->", v, m, v))


def pins(world: World) -> Array:
    """Jacobian (3 joints, 6 bodies) of the relative velocities of the anchors of joints between moving bodies."""
    x, _, _ = bodies_of(world)
    bodies = world.parameters.bodies[0]
    moving = [int(i) for i in np.flatnonzero((bodies["inv_mass"] > 0.0) & (bodies["enabled"] != 0))]
    dim = world.model.dim
    rows = []
    for model, joint in zip(world.model.joints, world.parameters.joints[0], strict=True):
        a, b = int(model["body_a"]), int(model["body_b"])
        if a not in moving or b not in moving:
            continue
        at = np.zeros(3)
        at[:dim] = joint["anchor_a"]
        if dim == 2:
            c, s = np.cos(world.angle[0, a]), np.sin(world.angle[0, a])
            at = np.array([c * at[0] - s * at[1], s * at[0] + c * at[1], 0.0])
        else:
            at = rotation(world.orientation[0, a]) @ at
        at[:dim] += world.position[0, a]
        row = np.zeros((3, 6 * len(x)))
        for sign, body in ((-1.0, a), (1.0, b)):
            n = moving.index(body)
            p, q, r = at - x[n]
            row[:, 6 * n : 6 * n + 3] = sign * np.eye(3)
            row[:, 6 * n + 3 : 6 * n + 6] = sign * np.array([[0.0, r, -q], [-r, 0.0, p], [q, -p, 0.0]])
        rows.append(row)
    return np.concatenate(rows)


def rotation(quaternion: Array) -> Array:
    w, x, y, z = quaternion
    turn = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + 2.0 * (w * turn + turn @ turn))


@pytest.mark.parametrize("dim", [2, 3])
def test_velocities_that_joints_do_not_allow_end_as_by_an_inelastic_impact(dim: int) -> None:
    scene = rods(4, free=True) if dim == 2 else floating(3)
    world = articulated(scene, timestep=1e-8, substeps=1, sleep=False)
    rng = np.random.default_rng(0)
    velocity = world.state.bodies["velocity"][0]
    parameters = world.parameters.bodies[0]
    for i in np.flatnonzero((parameters["inv_mass"] > 0.0) & (parameters["enabled"] != 0)):
        if dim == 2:
            velocity[i] = [1.0, 2.0, 0.0]
        velocity[i] += 0.01 * rng.normal(size=velocity.shape[1])
    start, before = momentum(world), energy(world)
    x, v, m = bodies_of(world)
    jacobian = pins(world)
    inverse = np.zeros((6 * len(x), 6 * len(x)))
    for n in range(len(x)):
        inverse[6 * n : 6 * n + 6, 6 * n : 6 * n + 6] = np.linalg.inv(m[n])
    response = inverse @ jacobian.T
    wanted = v.ravel() - response @ np.linalg.lstsq(jacobian @ response, jacobian @ v.ravel(), rcond=1e-12)[0]
    assert abs(jacobian @ v.ravel()).max() > 1e-3
    world.step()
    assert world.diagnostics().rows[0] == 0
    _, now, _ = bodies_of(world)
    assert_allclose(now.ravel(), wanted, rtol=1e-5, atol=1e-6)
    assert_allclose(momentum(world), start, rtol=1e-7, atol=1e-7)
    assert energy(world) < before


@pytest.mark.parametrize("dim", [2, 3])
def test_a_free_tree_that_turns_fast_keeps_momentum_and_energy(dim: int) -> None:
    """0.1 to 0.4 rad in each substep: without scaling, energies are off by up to 1 % now and then."""
    if dim == 2:
        world = articulated(rods(5, free=True), substeps=2, sleep=False)
        velocity = world.state.bodies["velocity"][0]
        velocity[1:, 2] = [10.0, -12.0, 15.0, -9.0, 14.0]
        end = np.zeros(2)
        for k in range(5):
            arm = 0.5 * np.array([0.0, velocity[1 + k, 2]])  # of a rod along x
            velocity[1 + k, :2] = end + arm
            end = end + 2.0 * arm
    else:
        world = articulated(floating(1), substeps=2, sleep=False)
        world.state.bodies["velocity"][0] *= 4.0
    world.step()
    start, before = momentum(world), energy(world)
    for _ in range(300):
        world.step()
        assert world.diagnostics().rows[0] == 0
        assert energy(world) == pytest.approx(before, rel=1e-3)
    assert_allclose(momentum(world)[:3], start[:3], rtol=1e-6, atol=1e-6 * abs(start).max())


@pytest.mark.parametrize("rate", [0.0, 12.0])
def test_a_joint_that_is_there_twice_carries_nothing(rate: float) -> None:
    """It has no rows. They moved nothing, and their impulses looked like tension: rounding over compliance, at 12 rad/s
    the difference between the start of the step and its middle."""
    scene = rods(4, 60.0)
    for k in range(4):
        pair = ("hook" if k == 0 else f"rod_{k - 1}", f"rod_{k}")
        turn = np.radians(60.0)
        anchor = k * np.array([np.sin(turn), -np.cos(turn)])
        scene.add_joint(f"again_{k}", Revolute(*pair, anchor=anchor))
    world = articulated(scene, sleep=False)
    for k in range(4):
        x, y = world.position[0, 1 + k]
        world.set_velocity(f"rod_{k}", linear=(-rate * y, rate * x), angular=rate)
    for _ in range(120):
        world.step()
        assert world.diagnostics().rows[0] == 0  # in joint coordinates
        for k in range(4):
            assert_allclose(world.joint_reaction(f"again_{k}"), 0.0, atol=1e-9)
        assert abs(world.joint_reaction("joint_0")).max() < 500.0 + 8.0 * rate**2 * 4.0


def test_a_3d_joint_that_is_there_twice_carries_nothing() -> None:
    """Links turn by up to 0.5 rad in a step."""
    scene = floating(3)
    tree = Tree(3, True, 5)
    for k, p in enumerate(tree.parents):
        if p >= 0:
            scene.add_joint(f"again_{k}", Ball(f"b{p}", f"b{k}", anchor=tree.pin(k)))
    world = articulated(scene, timestep=1.0 / 20.0, sleep=False)
    again = [f"again_{k}" for k, p in enumerate(tree.parents) if p >= 0]
    turned = 0.0
    for _ in range(60):
        world.step()
        turned = max(turned, abs(world.angular_velocity).max() / 20.0)
        assert world.diagnostics().rows[0] == 0  # in joint coordinates
        for joint in again:
            assert_allclose(world.joint_reaction(joint), 0.0, atol=1e-9)
    assert turned > 0.2
