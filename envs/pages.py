"""Writes the page of each environment, docs/envs/<id>.md, from its tables and its docstring.

A page begins with frames of the film of the trained policy, docs/training/<id>.mp4, which become docs/envs/<id>.jpg.
"""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import imageio.v3 as imageio
import numpy as np

from gsenv.envs import ENVS, PARALLEL_ENVS, EnvEntry, ParallelEntry
from gsenv.envs.core.policies import trained_actions
from gsenv.envs.core.spec_tables import Entry, box_of, table
from gsenv.files import write_bytes, write_text

FOLDER = Path("docs/envs")  # of a checkout, the working directory
FILMS = Path("docs/training")
MOMENTS = (0.1, 0.35, 0.65, 0.97)  # of a film: the frames that the page shows

_SCALING = """\
Entries are physical quantities in the units of the table, clipped to its bounds, and not normalised; a unit such as
"10 kg" means that 1 stands for 10 kg. `gsenv train` divides by running statistics (VecNormalize of Stable-Baselines3);
`gymnasium.wrappers.NormalizeObservation` does the same, and `RescaleObservation` maps the bounds to a range."""


def env_page(entry: EnvEntry) -> str:
    """Return the page of a registered environment."""
    module, _, name = entry.env.partition(":")
    env_class = getattr(import_module(f"gsenv.envs.{module}"), name)
    task = env_class.task_class
    rows = (
        ("Action space", _space(task.actions)),
        ("Observation space", _space(task.observations)),
        ("One world", f'`gymnasium.make("gsenv:{entry.id}")`'),
        ("N worlds in one batch", f'`gymnasium.make_vec("gsenv:{entry.id}", num_envs=N)`'),
        ("Steps until truncation", str(entry.max_episode_steps)),
        ("Reward threshold", f"{entry.reward_threshold:g}, the mean return at which the task counts as solved"),
    )
    return _page(entry.id, env_class, rows, _scaling(entry.id, task.observations))


def parallel_page(entry: ParallelEntry) -> str:
    """Return the page of an environment of several agents; needs PettingZoo."""
    module = import_module(f"gsenv.envs.{entry.name}")
    (env_class,) = (value for name in module.__all__ if hasattr(value := getattr(module, name), "task_class"))
    task = env_class.task_class
    rows = (
        ("Agents", ", ".join(f"`{agent}`" for agent in task.agents)),
        ("Action space of an agent", _space(task.actions)),
        ("Observation space of an agent", _space(task.observations)),
        ("Agents act at once", f"`gsenv.envs.{entry.name}.parallel_env()`"),
        ("Agents act in turn", f"`gsenv.envs.{entry.name}.env()`"),
        ("Steps until truncation", str(entry.max_cycles)),
    )
    return _page(entry.name, env_class, rows, _scaling(entry.name, task.observations))


def pages() -> dict[str, str]:
    """Return the text of all pages by file name."""
    texts = {f"{entry.id}.md": env_page(entry) for entry in ENVS}
    return texts | {f"{entry.name}.md": parallel_page(entry) for entry in PARALLEL_ENVS}


def _page(name: str, env_class: type[Any], rows: Sequence[tuple[str, str]], scaling: str) -> str:
    doc = inspect.cleandoc(env_class.__doc__ or "")
    before, rewards, after = doc.partition("## Rewards\n")
    assert rewards, f"the docstring of {env_class.__name__} has no section on rewards"
    summary, _, rest = before.partition("\n")
    return "\n".join(
        (
            f"<!-- `python -m gsenv.envs.pages` writes this page from the docstring of {env_class.__name__}. -->",
            f"# {name}\n",
            f"{summary}\n",
            f"{_film(name)}{table(('', ''), rows)}",
            f"{rest}## Observation Scaling\n{scaling}\n",
            f"{rewards}{after}\n",
        )
    )


def _film(name: str) -> str:
    """Return the link to the film of the trained policy, where there is one."""
    try:
        trained_actions(name)
    except LookupError:
        return ""
    return f"[![the trained policy at work]({name}.jpg)](../training/{name}.mp4)\n\n"


def write_frames(film: Path, picture: Path) -> None:
    """Write a picture of a few frames of a film, of half its size, side by side."""
    frames = imageio.imread(film)
    shown = [frames[int(moment * (len(frames) - 1)), ::2, ::2] for moment in MOMENTS]
    gap = np.full((shown[0].shape[0], 4, 3), 255, np.uint8)
    row = [part for frame in shown for part in (gap, frame)][1:]
    write_bytes(picture, imageio.imwrite("<bytes>", np.concatenate(row, 1), extension=".jpg", quality=85))


def _space(entries: Sequence[Entry]) -> str:
    space = box_of(entries)
    same = (space.low == space.low[0]).all() and (space.high == space.high[0]).all()
    bounds = f"{space.low[0]:g}, {space.high[0]:g}" if same else "low, high"
    return f"`Box({bounds}, {space.shape}, {space.dtype})`"


def _scaling(name: str, observations: Sequence[Entry]) -> str:
    """Return the text on scaling, with the mean and scale of the trained policy where there is one."""
    try:
        policy = trained_actions(name)
    except LookupError:
        return _SCALING
    rows = (
        (entry.name, f"{mean:.3g}", f"{scale:.3g}", entry.unit)
        for entry, mean, scale in zip(observations, policy.mean.tolist(), policy.scale.tolist(), strict=True)
    )
    return (
        f"{_SCALING}\n\nThe policy of `--policy trained` sees (observation - mean) / scale, "
        f"with the mean and the standard\ndeviation of its training:\n\n"
        f"{table(('Name', 'Mean', 'Scale', 'Unit'), rows)}"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Write all pages into a folder; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m gsenv.envs.pages", description=__doc__)
    parser.add_argument("folder", nargs="?", type=Path, default=FOLDER, help=f"default: {FOLDER}")
    folder: Path = parser.parse_args(arguments).folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        write_text(folder / name, text)
        print(folder / name)
        film = FILMS / name.replace(".md", ".mp4")
        if film.exists():
            write_frames(film, folder / name.replace(".md", ".jpg"))
    return 0


if __name__ == "__main__":
    sys.exit(main())
