"""Trees that swing and touch nothing: MuJoCo, closed forms, DOP853 on Lagrange's equations, energy, bits."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal, assert_array_less
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from gsenv.mjcf import build_scene, parse_mjcf, set_coordinates
from gsenv.scenes import chain
from gsenv.scenes.spatial import ball_chain
from gsenv.solver import Options, Scene, World
from gsenv.solver.spatial import Box, Hinge
from tests.solver.bits import everything
from tests.solver.core.articulation.opened import articulated
from tests.solver.core.articulation.test_step import rods, tip

Array = np.ndarray[Any, Any]
G = 9.81
BOX = '<geom type="box" size="0.05 0.08 0.2" pos="0.02 0.01 -0.2" contype="0" conaffinity="0"/>'
TREE = f"""
<mujoco><option gravity="0 0 -9.81" integrator="RK4" timestep="2e-4"/><worldbody>
  <body name="a" pos="0 0 1"><joint name="a" type="hinge" axis="0 1 0.3"/>{BOX}
    <body name="b" pos="0 0 -0.4"><joint name="b" type="ball"/>{BOX}
      <body name="c" pos="0 0 -0.4"><joint name="c" type="hinge" axis="1 0.2 0"/>{BOX}
        <body name="d" pos="0 0 -0.4"><joint name="d" type="ball"/>{BOX}</body>
      </body>
      <body name="e" pos="0.3 0 -0.2"><joint name="e" type="slide" axis="1 1 0"/>{BOX}
        <body name="f" pos="0.1 0 -0.3"><joint name="f" type="ball"/>{BOX}</body>
      </body>
    </body>
  </body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(("tolerance", "bound"), [(1e-4, 4e-3), (1e-8, 2e-6)])
def test_a_tree_of_hinges_balls_and_slides_moves_as_in_mujoco(tolerance: float, bound: float) -> None:
    theirs = mujoco.MjModel.from_xml_string(TREE)
    data = mujoco.MjData(theirs)
    data.qvel[:] = 2.0 * np.random.default_rng(3).normal(size=theirs.nv)
    ours = parse_mjcf(TREE)
    scene, names = build_scene(ours)
    world = articulated(scene, timestep=1.0 / 120, substeps=1, tolerance=tolerance, sleep=False)
    set_coordinates(world, ours, names, data.qpos, data.qvel)
    mujoco.mj_step(theirs, data, nstep=5000)
    world.step(120)
    assert world.diagnostics().rows[0] == 0
    assert world.diagnostics().joint_error[0] < 1e-13
    for name in "abcdef":
        index = list(scene.bodies).index(name)
        assert_allclose(world.position[0, index], data.body(name).xpos, atol=bound)
        assert_allclose(world.angular_velocity[0, index], data.body(name).cvel[:3], atol=30.0 * bound)


def double_pendulum(seconds: float, degrees: float, damping: float) -> Array:
    """Return where the end of two uniform rods of 1 m and 1 kg is that start straight and at rest.

    Both rods have the linear and angular damping in 1/s.
    """

    def rate(_: float, y: Array) -> Array:
        (a, b), (u, w) = y[:2], y[2:]
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[4.0 / 3.0, 0.5 * c], [0.5 * c, 1.0 / 3.0]])
        momenta = mass @ [u, w]  # damping is proportional to the momenta of each rod
        force = np.array([-0.5 * w * w * s - 1.5 * G * np.sin(a), 0.5 * u * u * s - 0.5 * G * np.sin(b)])
        return np.concatenate([y[2:], np.linalg.solve(mass, force - damping * momenta)])

    start = np.radians([degrees, degrees, 0.0, 0.0])
    y = solve_ivp(rate, (0.0, seconds), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return np.array([np.sin(y[0]) + np.sin(y[1]), -np.cos(y[0]) - np.cos(y[1])])


@pytest.mark.parametrize("damping", [0.0, 0.3])
def test_a_double_pendulum_follows_its_equations(damping: float) -> None:
    """Small tolerances show the control of the error."""
    exact = double_pendulum(2.0, 90.0, damping)
    scene = rods()
    for k in range(2):
        scene.bodies[f"rod_{k}"].linear_damping = scene.bodies[f"rod_{k}"].angular_damping = damping
    errors = []
    for tolerance in (1e-3, 1e-4, 1e-6, 1e-8):
        world = articulated(scene, timestep=1.0 / 60, substeps=1, tolerance=tolerance, sleep=False)
        world.step(120)
        assert world.diagnostics().unconverged[0] == 0
        assert world.diagnostics().joint_error[0] < 1e-14
        errors.append(np.linalg.norm(tip(world, 2) - exact))
    assert_array_less(errors, [2e-3, 1e-3, 1e-5, 1e-7])


@pytest.mark.parametrize("degrees", [60.0, 170.0])
def test_a_pendulum_has_the_period_of_elliptic_integrals(degrees: float) -> None:
    """A rod on a hinge in 2D, and a box on a hinge about a tilted axis in 3D."""
    whole = 4.0 * ellipk(np.sin(np.radians(0.5 * degrees)) ** 2)
    scene = Scene(dim=3)
    scene.add_body("hook", "static")
    place = (np.sin(np.radians(degrees)), 0.0, -np.cos(np.radians(degrees)))
    box = Box(half_extents=(0.05, 0.1, 0.15), mask=0)
    scene.add_body("box", shapes=[box], position=place, mass=1.0, inertia=(0.1, 1.0 / 12.0, 0.15))
    scene.add_joint("hinge", Hinge("hook", "box", axis=(0.0, 1.0, 0.0), anchor=(0.0, 0.0, 0.0)))
    for made, inertia, arm in ((rods(1, degrees), 1.0 / 3.0, 0.5), (scene, 1.0 + 1.0 / 12.0, 1.0)):
        period = whole * np.sqrt(inertia / (G * arm))
        world = articulated(made, timestep=0.5 * period / 100, substeps=1, tolerance=1e-7, sleep=False)
        start = world.position[0, 1].copy()
        world.step(100)
        assert_allclose(world.position[0, 1], [-start[0], *start[1:]], atol=1e-4)
        world.step(100)
        assert_allclose(world.position[0, 1], start, atol=1e-4)


def energies(scene: Scene, fidelity: str, rate: int) -> Array:
    """Energy at each second of a minute, over that between level and hanging; of a chain of 20 links, 5 m."""
    world = World(scene, options=Options.preset(fidelity, timestep=1.0 / rate, sleep=False, articulated=True))
    found = [float(world.diagnostics().energy[0])]
    for _ in range(60):
        world.step(rate)
        found.append(float(world.diagnostics().energy[0]))
    assert world.diagnostics().joint_error[0] < 1e-14
    return (np.array(found) - found[0]) / (20.0 * G * 2.5)


@pytest.mark.parametrize("rate", [60, 120, 240])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_free_chain_gains_nothing_and_loses_little(dim: int, rate: int) -> None:
    """MuJoCo's RK4 diverges at 240 Hz and loses 18 % at 480 Hz."""
    scene = chain(20, 0.25, 90.0, last_mass=1.0) if dim == 2 else ball_chain(20, 0.25, 90.0, last_mass=1.0)
    lost = {}
    for fidelity in ("balanced", "accurate") if dim == 2 or rate == 60 else ("balanced",):
        found = energies(scene, fidelity, rate)
        assert found.max() < 1e-12
        lost[fidelity] = -found[-1]
    assert lost["balanced"] < 0.12
    assert lost.get("accurate", 0.0) < 0.002


def test_forces_of_joints_are_those_of_a_swinging_rod() -> None:
    """Of uniform rods on a revolute joint; the force is the mean over a step, near the lowest place."""
    world = articulated(rods(1, 120.0), timestep=1e-3, substeps=1, sleep=False)
    while world.angle[0, 1] > -np.pi / 2:
        world.step()
    spin = world.angular_velocity[0, 1]
    force = world.joint_reaction("joint_0")[0]
    assert_allclose(spin**2, 3.0 * G * (1.0 - np.cos(np.radians(120.0))), rtol=1e-4)
    assert_allclose(force[1], G + 0.5 * spin**2, rtol=1e-4)
    assert_allclose(force[2], 0.0, atol=1e-4)


def test_batch_and_snapshots_do_not_matter() -> None:
    scene = ball_chain(6, 0.25, 90.0, last_mass=3.0)
    one = articulated(scene, sleep=False)
    batch = World(scene, 3, 2, options=Options(articulated=True, sleep=False))
    one.step(60)
    batch.step(60)
    for w in range(3):
        assert_array_equal(batch.state.bodies[w], one.state.bodies[0])
    saved = one.save()
    one.step(30)
    again = articulated(scene, sleep=False)
    again.restore(saved)
    again.step(30)
    assert everything(again) == everything(one)
