"""Mass matrices and accelerations of trees against MuJoCo in 3D, and against a double pendulum's equations in 2D."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from gsenv.solver import Scene, World
from gsenv.solver.planar import Box as Plate
from gsenv.solver.planar import Prismatic, Revolute
from gsenv.solver.spatial import Ball, Box, Weld
from gsenv.solver.spatial.math import conjugate, multiply, normalised, turned
from tests.solver.core.articulation.opened import Opened, accelerate, articulated, opened, push

Array = np.ndarray[Any, Any]
G = 9.81


def inverse_mass(island: Opened) -> Array:
    """The changes of the rates by unit impulses on the degrees of freedom, (impulse, freedom)."""
    out = np.eye(len(island.start))
    push(island.world, out)
    return out


def accelerations(island: Opened) -> Array:
    out = np.zeros(len(island.start))
    accelerate(island.world, out)
    return out


# ---------------------------------------------------------------- 3D, MuJoCo


def random_rotation(rng: np.random.Generator) -> tuple[float, float, float, float]:
    w, x, y, z = rng.normal(size=4).tolist()
    return normalised((w, x, y, z))


def rotated(rotation: tuple[float, float, float, float], vector: Any) -> Array:
    x, y, z = np.asarray(vector, float).tolist()
    return np.array(turned(rotation, (x, y, z)))


class Tree:
    """A random tree of bodies on ball joints, as a world and as a MuJoCo model in the same state."""

    def __init__(self, seed: int, free: bool, count: int = 7) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.parents = [-1] + [int(rng.integers(0, k)) for k in range(1, count)]
        self.rotations = [random_rotation(rng) for _ in range(count)]
        self.masses = rng.uniform(0.5, 3.0, count)
        edges = rng.uniform(0.1, 0.5, (count, 3))
        self.inertias = self.masses[:, None] * np.stack(
            [edges[:, (k + 1) % 3] ** 2 + edges[:, (k + 2) % 3] ** 2 for k in range(3)], -1
        )
        self.outer, self.inner = rng.uniform(-0.5, 0.5, (2, count, 3))
        self.free = free
        self.positions: list[Array] = []
        for k, p in enumerate(self.parents):
            at = rng.normal(size=3) if p < 0 else self.positions[p] + rotated(self.rotations[p], self.outer[k])
            self.positions.append(np.array(at) - rotated(self.rotations[k], self.inner[k]))
        self.spins = rng.normal(size=(count, 3)) * 2.0
        self.speeds: list[Array] = []
        for k, p in enumerate(self.parents):
            arm = rotated(self.rotations[k], -self.inner[k])
            v = rng.normal(size=3) if free and p < 0 else np.cross(self.spins[k], arm)
            if p >= 0:
                reach = rotated(self.rotations[p], self.outer[k])
                v = self.speeds[p] + np.cross(self.spins[p], reach) + np.cross(self.spins[k], arm)
            self.speeds.append(v)

    def pin(self, k: int) -> Array:
        """m, the anchor of body k's joint in the world."""
        return self.positions[k] + rotated(self.rotations[k], self.inner[k])

    def world(self, flipped: bool) -> World:
        scene = Scene(dim=3, gravity=(0.0, 0.0, -G))
        scene.add_body("hook", "static")
        for k, p in enumerate(self.parents):
            scene.add_body(
                f"b{k}",
                shapes=[Box(half_extents=(0.1, 0.1, 0.1), mask=0)],
                position=self.positions[k],
                orientation=self.rotations[k],
                mass=self.masses[k],
                inertia=self.inertias[k],
                linear_velocity=self.speeds[k],
                angular_velocity=self.spins[k],
            )
            if p >= 0 or not self.free:
                pair = ("hook" if p < 0 else f"b{p}", f"b{k}")
                scene.add_joint(f"j{k}", Ball(*(pair[::-1] if flipped and k % 2 else pair), anchor=self.pin(k)))
        return articulated(scene)

    def mujoco(self) -> tuple[Any, Any]:
        mujoco = pytest.importorskip("mujoco")
        spec = mujoco.MjSpec()
        spec.option.gravity = (0.0, 0.0, -G)
        made: list[Any] = []
        for k, p in enumerate(self.parents):
            holder = spec.worldbody if p < 0 else made[p]
            at, turn = self.positions[k], self.rotations[k]
            if p >= 0:
                back = conjugate(self.rotations[p])
                at, turn = rotated(back, at - self.positions[p]), multiply(back, turn)
            body = holder.add_body(pos=at, quat=turn, mass=self.masses[k], inertia=self.inertias[k])
            body.ipos, body.iquat, body.explicitinertial = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), True
            if p < 0 and self.free:
                body.add_freejoint(name=f"j{k}")
            else:
                body.add_joint(name=f"j{k}", type=mujoco.mjtJoint.mjJNT_BALL, pos=self.inner[k])
            made.append(body)
        model = spec.compile()
        data = mujoco.MjData(model)
        for k, p in enumerate(self.parents):
            spin = rotated(conjugate(self.rotations[k]), self.spins[k] - (self.spins[p] if p >= 0 else 0.0))
            data.joint(f"j{k}").qvel[:] = [*self.speeds[k], *spin] if p < 0 and self.free else spin
        mujoco.mj_forward(model, data)
        return model, data

    def to_rates(self, island: Opened, model: Any) -> Array:
        """The matrix (rate, velocity) that takes MuJoCo's velocities, spins in the axes of the bodies, to rates."""
        out = np.zeros((model.nv, model.nv))
        first = {int(link["body"]) - 1: int(link["first"]) for link in island.links}
        for k, (p, turn) in enumerate(zip(self.parents, self.rotations, strict=True)):
            i, j = first[k], int(model.joint(f"j{k}").dofadr[0])
            if p < 0 and self.free:
                out[i : i + 3, j : j + 3] = np.eye(3)
                i, j = i + 3, j + 3
            out[i : i + 3, j : j + 3] = np.array([rotated(turn, axis) for axis in np.eye(3)]).T
        return out


@pytest.mark.parametrize("flipped", [False, True])
@pytest.mark.parametrize("free", [False, True])
@pytest.mark.parametrize("seed", range(5))
def test_trees_of_balls_accelerate_as_in_mujoco(seed: int, free: bool, flipped: bool) -> None:
    mujoco = pytest.importorskip("mujoco")
    tree = Tree(seed, free)
    island = opened(tree.world(flipped))
    model, data = tree.mujoco()
    turn = tree.to_rates(island, model)
    assert_allclose(island.start, turn @ data.qvel, atol=1e-12)
    theirs = np.zeros((model.nv, model.nv))
    mujoco.mj_solveM(model, data, theirs, np.eye(model.nv))
    assert_allclose(inverse_mass(island), turn @ theirs @ turn.T, rtol=1e-10, atol=1e-10)
    # MuJoCo's spins are in the axes of the rotating bodies
    expected = turn @ data.qacc
    for link in island.links:
        k = int(link["body"]) - 1
        p = tree.parents[k]
        last = int(link["first"] + link["count"])
        spin = tree.spins[k] - (tree.spins[p] if p >= 0 else 0.0)
        expected[last - 3 : last] += np.cross(tree.spins[k], spin)
    assert_allclose(accelerations(island), expected, rtol=1e-10, atol=1e-10 * abs(expected).max())


# ---------------------------------------------------------------- 2D, closed form


@pytest.mark.parametrize("flipped", [False, True])
def test_a_double_pendulum_accelerates_by_its_equations(flipped: bool) -> None:
    """Point masses on massless rods of unequal length, at random angles and rates."""
    rng = np.random.default_rng(3)
    for _ in range(5):
        (a, b), (u, w) = rng.uniform(-3.0, 3.0, 2), rng.normal(size=2) * 3.0
        (m, n), (k, j) = rng.uniform(0.5, 2.0, 2), rng.uniform(0.5, 2.0, 2)
        scene = Scene(gravity=(0.0, -G))
        scene.add_body("hook", "static")
        tiny = 1e-9
        first = np.array([k * np.sin(a), -k * np.cos(a)])
        second = first + np.array([j * np.sin(b), -j * np.cos(b)])
        v = u * k * np.array([np.cos(a), np.sin(a)])
        plate = Plate(half_extents=(0.1, 0.1), mask=0)
        scene.add_body("m", shapes=[plate], position=first, mass=m, inertia=tiny, linear_velocity=v, angular_velocity=u)
        v = v + w * j * np.array([np.cos(b), np.sin(b)])
        scene.add_body(
            "n", shapes=[plate], position=second, mass=n, inertia=tiny, linear_velocity=v, angular_velocity=w
        )
        scene.add_joint("one", Revolute("hook", "m", anchor=(0.0, 0.0)))
        scene.add_joint("two", Revolute(*(("n", "m") if flipped else ("m", "n")), anchor=first))
        island = opened(articulated(scene))
        d = a - b
        mass = np.array([[(m + n) * k * k, n * k * j * np.cos(d)], [n * k * j * np.cos(d), n * j * j]])
        force = np.array(
            [
                -n * k * j * w * w * np.sin(d) - (m + n) * G * k * np.sin(a),
                n * k * j * u * u * np.sin(d) - n * G * j * np.sin(b),
            ]
        )
        first_rate, both = np.linalg.solve(mass, force)
        sign = -1.0 if flipped else 1.0
        assert_allclose(accelerations(island), [first_rate, sign * (both - first_rate)], rtol=1e-6)


def test_a_pendulum_on_a_cart_accelerates_by_its_equations() -> None:
    """A point mass on a massless rod below a cart that slides on a level rail."""
    m, n, k, a, u = 2.0, 0.7, 0.9, 0.6, 1.3
    for flipped in (False, True):
        scene = Scene(gravity=(0.0, -G))
        scene.add_body("rail", "static")
        plate = Plate(half_extents=(0.1, 0.1), mask=0)
        scene.add_body("cart", shapes=[plate], position=(0.3, 0.0), mass=m, linear_velocity=(0.4, 0.0))
        place = np.array([0.3 + k * np.sin(a), -k * np.cos(a)])
        v = np.array([0.4 + u * k * np.cos(a), u * k * np.sin(a)])
        scene.add_body(
            "bob", shapes=[plate], position=place, mass=n, inertia=1e-9, linear_velocity=v, angular_velocity=u
        )
        pair = ("cart", "rail") if flipped else ("rail", "cart")
        scene.add_joint("slide", Prismatic(*pair, axis=(1.0, 0.0), anchor=(0.0, 0.0)))
        scene.add_joint("pin", Revolute("cart", "bob", anchor=(0.3, 0.0)))
        mass = np.array([[m + n, n * k * np.cos(a)], [n * k * np.cos(a), n * k * k]])
        expected = np.linalg.solve(mass, [n * k * u * u * np.sin(a), -n * G * k * np.sin(a)])
        expected[0] *= -1.0 if flipped else 1.0
        assert_allclose(accelerations(opened(articulated(scene))), expected, rtol=1e-6)


def test_welded_bodies_move_as_one() -> None:
    """Two welded boxes on a ball joint have the inverse mass of one body with the inertia of both."""
    scene = Scene(dim=3, gravity=(0.0, 0.0, -G))
    scene.add_body("hook", "static")
    for k, x in enumerate((0.5, 1.5)):
        box = Box(half_extents=(0.5, 0.1, 0.2), mask=0)
        scene.add_body(f"box_{k}", shapes=[box], position=(x, 0.0, 0.0), mass=1.0)
    scene.add_joint("pin", Ball("hook", "box_0", anchor=(0.0, 0.0, 0.0)))
    scene.add_joint("weld", Weld("box_1", "box_0", anchor=(1.0, 0.0, 0.0)))
    inertia = np.array([2 * (0.01 + 0.04) / 3.0, 2 * (0.25 + 0.04) / 3.0, 2 * (0.25 + 0.01) / 3.0])
    inertia[1:] += 0.5**2 + 1.5**2
    island = opened(articulated(scene))
    assert_allclose(inverse_mass(island), np.diag(1.0 / inertia), rtol=1e-12, atol=1e-14)
