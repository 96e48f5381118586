"""`gsenv view` and `gsenv play`: interactive windows."""

from __future__ import annotations

import argparse
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsenv.envs import ENVS, PARALLEL_ENVS

from .errors import FAILED, OK, WRONG_USAGE, CliError
from .names import SCENE_PREFIX, check_env, find_actor, suggestion

if TYPE_CHECKING:
    from gsenv.view.simulation import Simulation


MODEL_FILES = (".xml", ".urdf")  # of MuJoCo and of ROS


def run_view(options: argparse.Namespace) -> int:
    return _show(options, _find_simulation)


def run_play(options: argparse.Namespace) -> int:
    check_env(options.target)
    return _show(options, _make_game)


def _show(options: argparse.Namespace, make: Any) -> int:
    """Open a window and show a simulation in it until the user quits."""
    from gsenv.render.sizes import check_size
    from gsenv.view.loop import run
    from gsenv.view.window import WindowError, default_size

    try:
        size = default_size()  # fails at once where there is no display
        with _refusals(options):
            if options.size is not None:
                check_size(*options.size)
            simulation = make(options)
        run(simulation, options.size or size, paused=options.paused)
    except (ImportError, WindowError) as error:
        if isinstance(error, ImportError) and error.name != "pygame":
            raise
        raise CliError(str(error), FAILED) from error
    return OK


def _find_simulation(options: argparse.Namespace) -> Simulation:
    envs = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS]
    if options.target in envs:
        return _make_tasks(options)
    is_file = options.target.endswith(MODEL_FILES)
    from gsenv.scenes import SCENES

    scenes = [f"{SCENE_PREFIX}{name}" for name in SCENES]
    if options.target not in scenes and not is_file:
        raise CliError(
            f"no environment or scene is called {options.target!r}; {suggestion(options.target, envs + scenes)}",
            WRONG_USAGE,
        )
    for name, given in (("--policy", options.policy is not None), ("--set", bool(options.set))):
        if given:
            raise CliError(f"{options.target} is a scene and takes no {name}", WRONG_USAGE)
    return _make_model(options) if is_file else _make_scene(options)


def _make_model(options: argparse.Namespace) -> Simulation:
    """Return the simulation of a MuJoCo or URDF file."""
    from gsenv.mjcf import MjcfError, load_mjcf, load_urdf
    from gsenv.solver import World
    from gsenv.view.simulation import SceneSimulation

    path = Path(options.target)
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            scene = load_urdf(path) if path.suffix == ".urdf" else load_mjcf(path)
    except MjcfError as error:
        raise CliError(str(error), FAILED) from error
    except OSError as error:
        raise CliError(f"cannot read {path}: {error.strerror or error}", FAILED) from error
    except ImportError as error:
        raise CliError(f"{error.name} is missing; pip install 'gsenv[urdf]' brings it", FAILED) from error
    for warning in caught:
        print(f"gsenv: {warning.message}", file=sys.stderr)
    return SceneSimulation(World(scene, options.worlds), path.name)


def _make_scene(options: argparse.Namespace) -> Simulation:
    from gsenv.scenes import SCENES, make_world
    from gsenv.view.simulation import SceneSimulation

    name = options.target.removeprefix(SCENE_PREFIX)
    spec = SCENES[name]
    world = make_world(name, options.worlds)
    return SceneSimulation(world, options.target, view=spec.view, follow=spec.follow, camera=spec.camera)


def _make_tasks(options: argparse.Namespace) -> Simulation:
    """Return the simulation of an environment that a policy steers, or nothing."""
    from gsenv.envs.core.interactive import TaskSimulation

    policy = options.policy or "zero"
    actor = None if policy == "zero" else find_actor(policy, options.target, options.seed, dict(options.set))
    return TaskSimulation(_make_worlds(options, options.worlds), options.target, options.seed, actor)


def _make_game(options: argparse.Namespace) -> Simulation:
    """Return the simulation of an environment that keys steer; a policy acts for agents beyond the first."""
    from gsenv.envs.core.interactive import TaskSimulation, make_steering

    env = _make_worlds(options, 1)
    if options.policy is not None and not env.task.agents:
        raise CliError(f"{options.target} has one agent, so --policy has nobody to act for", WRONG_USAGE)
    actor = (
        None if options.policy is None else find_actor(options.policy, options.target, options.seed, dict(options.set))
    )
    steering = make_steering(env.task, len(env.task.agents) if actor is None else 1)
    return TaskSimulation(env, f"{options.target}: play", options.seed, actor, steering)


def _make_worlds(options: argparse.Namespace, count: int) -> Any:
    from gsenv.envs.core.policies import make_batch

    return make_batch(options.target, count, **dict(options.set))


@contextmanager
def _refusals(options: argparse.Namespace) -> Iterator[None]:
    """Turn what --set, --seed, --size and --worlds are refused for into errors of the command line."""
    try:
        yield
    except MemoryError as error:
        worlds = getattr(options, "worlds", 1)
        raise CliError(f"{worlds} worlds of {options.target} do not fit into memory", FAILED) from error
    except (TypeError, ValueError) as error:
        raise CliError(str(error), WRONG_USAGE) from error
