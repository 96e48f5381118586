"""Compilation ahead of time: what `gsenv warmup` and `gsenv pack` run, and how they share it among processes."""

from __future__ import annotations

import multiprocessing
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium
import numpy as np

from gsenv.envs import ENVS, PARALLEL_ENVS
from gsenv.solver.records.kernel_variants import OWN_KERNELS

ONLY_2D = ", solver newton"
WAYS: dict[str, dict[str, Any]] = {  # of solving: options that have kernels of their own
    "": {},
    ", joints by rows": {"articulated": False},
    ", solver soft": {"solver": "soft"},
    ONLY_2D: {"solver": "newton"},
}
READINGS, PROBLEMS = "sensors, rays and parameters", "Problem and solve"
LONGEST = ("GRagdoll", "GCar3D", "GStack3D", "GRagdoll2D")  # to compile; these come first, so that no core waits


def warmup_targets() -> dict[str, Callable[[], None]]:
    """Return functions that compile kernels, or load them from the cache, by what the kernels are for."""
    from gsenv.scenes import SCENES

    targets: dict[str, Callable[[], None]] = {}
    for entry in ENVS:
        targets[entry.id] = partial(_run_env, entry.id)
    targets = {name: targets[name] for name in sorted(targets, key=_by_length)}
    if find_spec("pettingzoo") is not None:
        targets |= {entry.name: partial(_run_parallel_env, entry.name) for entry in PARALLEL_ENVS}
    # one 3D scene only: kernels of the others take a minute each to compile and are compiled when first used
    targets |= {
        f"scene:{name}": partial(_run_scene, name)
        for name, spec in SCENES.items()
        if spec.dim == 2 or name == "cube_stack"
    }
    targets |= {
        f"any scene in {dim}D{way}": partial(_run_any_scene, dim, options)
        for dim in (3, 2)
        for way, options in WAYS.items()
        if dim == 2 or way != ONLY_2D
    }
    targets |= {f"{READINGS} in {dim}D": partial(_run_readings, dim) for dim in (3, 2)}
    targets["windows"] = _run_window
    targets[PROBLEMS] = _solve_problem
    targets["many bodies"] = _run_many_bodies
    targets["continuous collision"] = _run_continuous_collision
    targets["joints and terrain"] = _run_jointed_terrain
    return targets


def compile_targets(
    names: Sequence[str], processes: int, environment: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Run these targets in several processes; yields the name of each when it is done.

    ``environment``: variables of the processes that differ from those of this one.

    Raises:
        the error of a target that failed.
    """
    before = dict(os.environ)
    os.environ.update({OWN_KERNELS: "1", **(environment or {})})  # new processes inherit it
    try:
        if processes == 1 and environment is None:
            targets = warmup_targets()
            for name in names:
                targets[name]()
                yield name
            return
        with multiprocessing.get_context("spawn").Pool(min(processes, len(names))) as pool:
            yield from pool.imap_unordered(_run_target, names)
    finally:
        os.environ.clear()
        os.environ.update(before)


def core_count() -> int:
    """Return the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _by_length(name: str) -> int:
    family = name.partition("-")[0]
    return LONGEST.index(family) if family in LONGEST else len(LONGEST)


def _run_target(name: str) -> str:
    from gsenv.solver import jit

    jit.mute_compile_notice()
    warmup_targets()[name]()
    return name


def _run_env(env_id: str) -> None:
    env = gymnasium.make(env_id, render_mode="rgb_array", observation="state+pixels")
    env.reset(seed=0)
    env.step(np.zeros_like(env.action_space.sample()))
    env.render()
    env.close()
    envs = gymnasium.make_vec(env_id, num_envs=2)
    envs.reset(seed=0)
    envs.step(np.zeros_like(envs.action_space.sample()))
    envs.close()


def _run_parallel_env(name: str) -> None:
    env = import_module(f"gsenv.envs.{name}").parallel_env(render_mode="rgb_array", observation="state+pixels")
    env.reset(seed=0)
    env.step({agent: np.zeros_like(env.action_space(agent).sample()) for agent in env.agents})
    env.render()
    env.close()


def _solve_problem() -> None:
    from gsenv.solver import Problem, solve

    contact = Problem.from_delassus(np.eye(3), -np.ones(3), friction=[0.5])
    for method in ("pgs", "nncg", "apgd", "direct"):
        solve(contact, method=method)
    rows = Problem.from_delassus(np.eye(3), -np.ones(3), lower=0)
    for method in ("direct", "lemke"):
        solve(rows, method=method)


def _run_many_bodies() -> None:
    """Step enough shapes that the broadphase builds its tree."""
    from gsenv.scenes import stack
    from gsenv.solver import World

    World(stack(200)).step()


def _run_continuous_collision() -> None:
    from gsenv.solver import Scene, World
    from gsenv.solver.planar import Circle, HalfPlane

    scene = Scene()
    scene.add_body("ground", "static", [HalfPlane()])
    scene.add_body("ball", shapes=[Circle(radius=0.1)], position=(0.0, 1.0), continuous=True)
    World(scene).step()


def _run_jointed_terrain() -> None:
    from gsenv.solver import Scene, World
    from gsenv.solver.planar import Box, Terrain, Weld

    scene = Scene()
    scene.add_body("hills", "static", [Terrain(vertices=[(-1.0, 0.0), (1.0, 0.0)])])
    for k in range(2):
        scene.add_body(f"box_{k}", shapes=[Box(half_extents=(0.1, 0.1))], position=(0.2 * k, 0.1))
    scene.add_joint("weld", Weld("box_0", "box_1"))
    World(scene).step()


def _run_any_scene(dim: int, options: Mapping[str, Any]) -> None:
    """Compile a kernel that steps scenes without one of their own, and what reads worlds without and with joints."""
    from gsenv.solver import Options, Scene, World, planar, spatial
    from gsenv.solver.records.kernel_variants import ONE_KERNEL

    plain = Scene(dim=dim)
    jointed = Scene(dim=dim)
    for scene in (plain, jointed):
        for name in ("one", "other"):
            scene.add_body(name, shapes=[planar.Circle(radius=1.0) if dim == 2 else spatial.Sphere(radius=1.0)])
    jointed.add_joint("joint", (planar.Revolute if dim == 2 else spatial.Ball)("one", "other"))
    before = os.environ.get(ONE_KERNEL)
    os.environ[ONE_KERNEL] = str(dim)
    try:
        for scene in (plain, jointed):
            world = World(scene, options=Options(**options))
            world.step()
            world.diagnostics()
            world.contacts()
    finally:
        if before is None:
            del os.environ[ONE_KERNEL]
        else:
            os.environ[ONE_KERNEL] = before


def _run_readings(dim: int) -> None:
    """Read all sensors, cast rays at ground of each kind, and set what derives masses."""
    from gsenv.solver import Scene, World, planar, spatial

    if dim == 2:
        module: Any = planar
        ground: Any = planar.Terrain(vertices=[(-1.0, 0.0), (1.0, 0.0)])
    else:
        module, ground = spatial, spatial.Heightfield(heights=np.zeros((2, 2)), size=(1.0, 1.0))
    plain, uneven = Scene(dim=dim), Scene(dim=dim)
    uneven.add_body("ground", "static", [ground])
    for scene in (plain, uneven):
        for k in range(2):
            box = module.Box(half_extents=(0.1,) * dim)
            scene.add_body(f"box{k}", shapes=[box], position=(0.25 * k,) + (0.0,) * (dim - 2) + (0.1,))
        hinge = planar.Revolute("box0", "box1") if dim == 2 else spatial.Hinge("box0", "box1", axis=(0.0, 1.0, 0.0))
        scene.add_joint("hinge", hinge)
        for name in ("Pose", "Velocity", "Frame", "Acceleration", "Contact", "ContactForce"):
            scene.add_sensor(name, getattr(module, f"{name}Sensor")("box0"))
        scene.add_sensor("rays", module.RaySensor("box0", directions=[(1.0,) * dim], length=1.0))
        scene.add_sensor("joint", module.JointSensor("hinge"))
        world = World(scene, 2)
        world.step()
        world.sensors()
        world.cast_rays((0.0,) * dim, (0.0,) * (dim - 1) + (-1.0,), 1.0)
        world.parameters.set("box0", half_extents=(0.2,) * dim, friction=0.5)
        world.parameters.set("box1", mass=2.0)


def _run_window() -> None:
    """Compile what interactive windows need besides: rays of the mouse, marks on the picture; no window opens."""
    from gsenv.scenes import make_world
    from gsenv.view.events import KeyPressed
    from gsenv.view.session import Session
    from gsenv.view.simulation import SceneSimulation

    for name in ("stack", "cube_stack"):
        session = Session(SceneSimulation(make_world(name), name), (64, 48), paused=True)
        for key in (".", "c", "j"):
            session.handle(KeyPressed(key))
        session.screen.draw(session.shown, None, lambda: ("", "", ""))


def _run_scene(name: str) -> None:
    from gsenv.render import make_renderer
    from gsenv.scenes import make_world

    world = make_world(name)
    world.step()
    make_renderer(world, 64, 48).render()
