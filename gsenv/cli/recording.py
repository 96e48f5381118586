"""`gsenv record`: videos of environments and scenes, and through replaying.py their states."""

import argparse
import importlib
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsenv.envs import ENVS, PARALLEL_ENVS

from .errors import FAILED, INTERRUPTED, OK, WRONG_USAGE, CliError
from .interrupts import delayed, say
from .names import SCENE_PREFIX, find_actor, suggestion
from .progress import make_progress
from .replaying import record_states

if TYPE_CHECKING:
    import gymnasium
    import numpy as np
    from numpy.typing import NDArray
    from rich.progress import Progress

    from gsenv.render.video import VideoWriter
    from gsenv.scenes import SceneSpec

    Frame = NDArray[np.uint8]
    Policy = Callable[[gymnasium.Env[Any, Any]], Any]

SCENE_FPS = 60.0  # largest frame rate of a recorded scene; with a shorter timestep, steps are skipped


def run_record(options: argparse.Namespace) -> int:
    if options.out.suffix.lower() == ".npz":
        return record_states(options)
    footage = _footage(options)
    video = _video_writer(options.out, footage.fps)
    try:
        with make_progress() as progress, video:
            interrupted = _film(footage, video, progress, options.target)
            _close(video, progress, interrupted=interrupted)
    except KeyboardInterrupt:
        interrupted = True
    except OSError as error:
        raise _unwritable(options.out, error) from error
    if interrupted:
        kept = f"{options.out} has the {video.frame_count} frames so far" if video.is_written else "nothing was written"
        print(f"gsenv: interrupted; {kept}", file=sys.stderr)
        return INTERRUPTED
    say(f"{options.out}: {video.frame_count} frames, {video.frame_count / footage.fps:.1f} s")
    return OK


def _film(footage: "_Footage", video: "VideoWriter", progress: "Progress", title: str) -> bool:
    """Write all frames; returns whether Ctrl-C has ended it early."""
    task = progress.add_task(title, total=footage.frame_count)
    try:
        for frame in footage.frames:
            _write(video, frame)
            progress.advance(task)
    except KeyboardInterrupt:
        return True
    finally:
        progress.update(task, total=video.frame_count)
    return False


def _close(video: "VideoWriter", progress: "Progress", *, interrupted: bool) -> None:
    """Complete the file, which takes a while for a GIF.

    The first Ctrl-C of a recording keeps what is recorded, here too; the second gives it up.
    """
    text = f"writing {video.path.name}"
    hint = f"{text}; Ctrl-C gives it up"
    task = progress.add_task(hint if interrupted else text, total=None)
    most = 0 if interrupted else 1
    with delayed(most, on_first=lambda: progress.update(task, description=hint)):
        video.close()


@dataclass
class _Footage:
    """A recording: `frame_count` frames, or fewer if an episode ends early."""

    fps: float
    frame_count: int
    frames: "Iterator[Frame]"


def _footage(options: argparse.Namespace) -> _Footage:
    if any(entry.id == options.target for entry in ENVS):
        return _env_footage(options)
    if any(entry.name == options.target for entry in PARALLEL_ENVS):
        return _parallel_footage(options)
    from gsenv.scenes import SCENES

    scenes = [f"{SCENE_PREFIX}{name}" for name in SCENES]
    if options.target in scenes:
        if options.policy is not None:
            raise CliError(f"{options.target} is a scene and takes no --policy", WRONG_USAGE)
        if options.set:
            raise CliError(f"{options.target} is a scene and takes no --set", WRONG_USAGE)
        return _scene_footage(options)
    names = [entry.id for entry in ENVS] + [entry.name for entry in PARALLEL_ENVS] + scenes
    raise CliError(
        f"no environment or scene is called {options.target!r}; {suggestion(options.target, names)}", WRONG_USAGE
    )


def _env_footage(options: argparse.Namespace) -> _Footage:
    import gymnasium

    from gsenv.envs.core.policies import named_task

    size = {} if options.size is None else dict(zip(("width", "height"), options.size, strict=True))
    env_id, arguments = named_task(options.target, dict(options.set))
    try:
        env = gymnasium.make(env_id, render_mode="rgb_array", **size, **arguments)
    except (TypeError, ValueError) as error:
        raise CliError(str(error), WRONG_USAGE) from None
    policy = _policy(env_id, options.policy or "random", arguments)
    assert env.spec is not None  # gymnasium.make sets it
    step_count = options.steps or env.spec.max_episode_steps or 1000
    frames = _env_frames(env, policy, options.seed, step_count, one_episode=options.steps is None)
    return _Footage(env.metadata["render_fps"], step_count + 1, _checked(frames))


def _parallel_footage(options: argparse.Namespace) -> _Footage:
    """Return the recording of an environment with several agents."""
    size = {} if options.size is None else dict(zip(("width", "height"), options.size, strict=True))
    try:
        module = importlib.import_module(f"gsenv.envs.{options.target}")
        env = module.parallel_env(render_mode="rgb_array", **size, **dict(options.set))
    except ImportError as error:
        raise CliError(f"{error}; {options.target} needs pip install 'gsenv[pettingzoo]'", FAILED) from error
    except (TypeError, ValueError) as error:
        raise CliError(str(error), WRONG_USAGE) from None
    kind = options.policy or "random"
    policy = None if kind == "random" else find_actor(kind, options.target, 0, dict(options.set))
    step_count = options.steps or max(env.max_cycles, 0) or 1000  # -1: no limit
    frames = env.film(policy, options.seed, step_count, one_episode=options.steps is None)
    return _Footage(env.metadata["render_fps"], step_count + 1, _checked(frames))


def _policy(env_id: str, kind: str, arguments: dict[str, Any]) -> "Policy":
    if kind == "random":
        return lambda env: env.action_space.sample()
    import gsenv.envs.core.policies as policies

    try:
        if kind in ("scripted", "trained"):
            return policies.scripted_policy(env_id) if kind == "scripted" else policies.trained_policy(env_id)
        actor = find_actor(kind, env_id, 0, arguments)
        return lambda env: actor(env.unwrapped.observation)  # type: ignore[attr-defined]
    except LookupError as error:
        raise CliError(str(error.args[0]), FAILED) from error


def _env_frames(
    env: "gymnasium.Env[Any, Any]", policy: "Policy", seed: int, step_count: int, *, one_episode: bool
) -> "Iterator[Frame]":
    env.action_space.seed(seed)
    env.reset(seed=seed)
    yield _frame(env)
    for step in range(step_count):
        _, _, terminated, truncated, _ = env.step(policy(env.unwrapped))
        yield _frame(env)
        if terminated or truncated:
            if one_episode or step + 1 == step_count:
                break
            env.reset()
    env.close()


def _checked(frames: "Iterator[Frame]") -> "Iterator[Frame]":
    """Yield the frames; what the first reset refuses, such as the seed, is a wrong command line."""
    try:
        first = next(frames)
    except ValueError as error:
        raise CliError(str(error), WRONG_USAGE) from error
    yield first
    yield from frames


def _frame(env: "gymnasium.Env[Any, Any]") -> "Frame":
    frame: Any = env.render()  # typed as a frame or a list of frames; "rgb_array" gives one frame
    return frame


def _scene_footage(options: argparse.Namespace) -> _Footage:
    from gsenv.render import make_renderer
    from gsenv.render.video import GIF_MAX_FPS
    from gsenv.scenes import SCENES, make_world

    name = options.target.removeprefix(SCENE_PREFIX)
    world = make_world(name)
    width, height = options.size or (640, 480)
    try:
        renderer = make_renderer(world, width, height)
    except ValueError as error:  # a bad size
        raise CliError(str(error), WRONG_USAGE) from None
    _aim(renderer, SCENES[name])
    fps_limit = min(SCENE_FPS, GIF_MAX_FPS) if options.out.suffix.lower() == ".gif" else SCENE_FPS
    steps_per_frame = ceil(1 / (fps_limit * world.timestep) - 1e-9)  # 1e-9: 1/60 s is one step at 60 fps
    step_count = options.steps or round(SCENES[name].duration / world.timestep)

    def frames() -> "Iterator[Frame]":
        yield renderer.render()
        for step in range(1, step_count + 1):
            world.step()
            if step % steps_per_frame == 0:
                yield renderer.render()

    return _Footage(1 / (steps_per_frame * world.timestep), 1 + step_count // steps_per_frame, frames())


def _aim(renderer: Any, spec: "SceneSpec") -> None:
    """Set the renderer's camera if the scene specifies one."""
    from gsenv.render.camera import Bounds, Camera, FollowCamera

    if spec.camera is not None:
        from gsenv.render.spatial import SpatialCamera

        renderer.camera = SpatialCamera(*spec.camera, width=renderer.width, height=renderer.height)
    elif spec.follow is not None:
        renderer.camera = FollowCamera([renderer.world.model.body_names.index(spec.follow)])
    elif spec.view is not None:
        renderer.camera = Camera.fit(Bounds(*spec.view), renderer.width, renderer.height, margin=0.0)


def _video_writer(path: Path, fps: float) -> "VideoWriter":
    from gsenv.render.video import VideoWriter

    try:
        return VideoWriter(path, fps)
    except ValueError as error:  # an unknown file name extension
        raise CliError(str(error), WRONG_USAGE) from error
    except OSError as error:
        raise _unwritable(path, error) from error


def _unwritable(path: Path, error: OSError) -> CliError:
    return CliError(f"cannot write {path}: {error.strerror or error}", FAILED)


def _write(video: "VideoWriter", frame: "Frame") -> None:
    try:
        with delayed():
            video.write(frame)
    except ValueError as error:  # a size that the format does not allow
        raise CliError(str(error), WRONG_USAGE) from error
