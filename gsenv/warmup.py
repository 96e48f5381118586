"""What `gsenv warmup` runs to fill the kernel cache: all environments, all 2D scenes and one 3D scene."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from importlib.util import find_spec

import gymnasium
import numpy as np

from gsenv.envs import ENVS, PARALLEL_ENVS


def warmup_targets() -> list[tuple[str, Callable[[], None]]]:
    """Return pairs of a label and a function that compiles its kernels, or loads them from the cache."""
    from gsenv.scenes import SCENES

    targets: list[tuple[str, Callable[[], None]]] = []
    for entry in ENVS:
        targets.append((entry.id, partial(_run_env, entry.id)))
        targets.append((f"{entry.id} (vector)", partial(_run_vector_env, entry.id)))
    if find_spec("pettingzoo") is not None:
        targets += [(entry.name, partial(_run_parallel_env, entry.name)) for entry in PARALLEL_ENVS]
    targets.append(("Problem and solve", _solve_problem))
    targets.append(("many bodies", _run_many_bodies))
    targets.append(("continuous collision", _run_continuous_collision))
    targets.append(("joints and terrain", _run_jointed_terrain))
    # one 3D scene only: kernels of the others take a minute each to compile and are compiled when first used
    targets += [
        (f"scene:{name}", partial(_run_scene, name))
        for name, spec in SCENES.items()
        if spec.dim == 2 or name == "cube_stack"
    ]
    return targets


def _run_env(env_id: str) -> None:
    env = gymnasium.make(env_id, render_mode="rgb_array", observation="state+pixels")
    env.reset(seed=0)
    env.step(np.zeros_like(env.action_space.sample()))
    env.render()
    env.close()


def _run_vector_env(env_id: str) -> None:
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


def _run_scene(name: str) -> None:
    from gsenv.render import make_renderer
    from gsenv.scenes import make_world

    world = make_world(name)
    world.step()
    make_renderer(world, 64, 48).render()
