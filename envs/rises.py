"""Makes assets/rises.npz: reference motions for the scripts of GRagdoll2D-get-up-v0 and GRagdoll-get-up-v0.

    python -m gsenv.envs.rises

The trained policies get up from many starts. Each of these motions is followed from other starts, and of those from the
back and of those from the front the one is kept that brings most figures to the stand; then further ones, if they help.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.mlp import write_arrays
from gsenv.envs.core.policies import make_batch, trained_actions
from gsenv.envs.core.vector import TaskVectorEnv
from gsenv.envs.ragdoll import mirror
from gsenv.envs.ragdoll import policy as spatial
from gsenv.envs.ragdoll2d import policy as planar
from gsenv.envs.ragdoll2d.motion import FILE, Motion

STARTS = 160  # of the trained policy
SLOWEST = 150  # steps to the stand, of a motion that is tried
STANDING = 45  # steps after that, which a motion keeps
STANDS = -0.5  # of the observation `height`: the crown at 0.9 of that in the stand
ROUNDS = ((99, 32), (10, 128))  # how many motions from each side are tried at most, from how many starts
MOTIONS = 3  # from each side, at most
GAIN = 0.02  # of the share that gets up, for which a further motion is taken
FIRST_SEED = 2_000_000  # of the starts from which motions are tried
TOGETHER = 1024  # worlds

Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class Figure:
    """What differs between the figures: the script, its features, on which side one lies, and mirror images."""

    id: str
    script: Callable[[Any, Motion], NDArray[np.float32]]
    features: Callable[[Any], NDArray[np.float64]]
    lies_on_back: Callable[[Any], Flags]  # of observations (..., entry)
    mirrored: bool


FIGURES = (
    Figure(
        "GRagdoll2D-get-up-v0",
        planar.get_up,
        planar.features,
        lambda seen: seen[..., planar._INDEX["chest_sine"]] > 0.0,
        False,
    ),
    Figure(
        "GRagdoll-get-up-v0",
        spatial.get_up,
        spatial.features,
        lambda seen: seen[..., spatial._INDEX["down_x"]] < 0.0,
        True,
    ),
)


def record(figure: Figure, starts: int) -> tuple[list[Motion], list[Motion]]:
    """Return motions of the trained policy that got up, from the back and from the front; quick ones first."""
    batch, policy = make_batch(figure.id, starts), trained_actions(figure.id)
    seen, _ = batch.reset(seed=list(range(starts)))
    back = figure.lies_on_back(seen)
    frames, actions = [], []
    for _ in range(_steps(batch)):
        frames.append(seen.copy())
        actions.append(policy(seen))
        seen, _, _, _, infos = batch.step(actions[-1])
    stands = np.array(frames)[:, :, 0] > STANDS
    first = np.where(infos["is_success"], stands.argmax(0), SLOWEST + 1)
    motions: tuple[list[Motion], list[Motion]] = ([], [])
    for k in np.argsort(first, kind="stable"):
        if first[k] <= SLOWEST:
            end = first[k] + STANDING
            kept = np.array(frames)[:end, k], np.array(actions)[:end, k]
            motions[0 if back[k] else 1].append(_motion(figure, *kept))
    return motions


def _motion(figure: Figure, seen: NDArray[Any], actions: NDArray[Any]) -> Motion:
    """Return a motion, and its mirror image where the figure has one, with the precision of the file."""
    if figure.mirrored:
        (index, sign), (action_index, action_sign) = mirror.OBSERVATION, mirror.ACTION
        seen = np.concatenate([seen, seen[:, index] * sign])
        actions = np.concatenate([actions, actions[:, action_index] * action_sign])
    rounded = (part.astype(np.float16).astype(np.float64) for part in (figure.features(seen), actions))
    return Motion(*rounded)


def _joined(motions: Sequence[Motion]) -> Motion:
    return Motion(*(np.concatenate(parts) for parts in zip(*motions, strict=True)))


def try_out(figure: Figure, motions: Sequence[Motion], starts: int) -> NDArray[np.float64]:
    """Return the share of figures that each motion brings to the stand, (motion, 2): from the back, from the front."""
    shares = []
    together = min(max(TOGETHER // starts, 1), len(motions))
    batch = make_batch(figure.id, together * starts)
    for begin in range(0, len(motions), together):
        tried = list(motions[begin : begin + together])
        tried += tried[:1] * (together - len(tried))  # the batch is full always
        seen, _ = batch.reset(seed=[*range(FIRST_SEED, FIRST_SEED + starts)] * together)
        back = figure.lies_on_back(seen[:starts])
        for _ in range(_steps(batch)):
            parts = np.split(seen, together)
            actions = [figure.script(part, motion) for part, motion in zip(parts, tried, strict=True)]
            seen, _, _, _, infos = batch.step(np.concatenate(actions))
        up = infos["is_success"].reshape(together, starts)
        shares += [(row[back].mean(), row[~back].mean()) for row in up]
    return np.array(shares[: len(motions)])


def select(figure: Figure, motions: tuple[list[Motion], list[Motion]]) -> Motion:
    """Return the joined motions that bring most figures to the stand."""
    kept: list[Motion] = []
    best = np.zeros(2)
    for turn in range(MOTIONS):
        sides = motions
        for most, starts in ROUNDS:
            pairs = min(most, *map(len, sides))
            tried = [_joined([*kept, sides[0][k], sides[1][k]]) for k in range(pairs)]
            shares = try_out(figure, tried, starts)
            backs, fronts = np.argsort(-shares, axis=0, kind="stable").T
            sides = [sides[0][k] for k in backs], [sides[1][k] for k in fronts]
        reached = shares.max(0)
        taken = [side[0] for side, gains in zip(sides, reached >= best + GAIN, strict=True) if gains]
        print(
            f"{figure.id}, turn {turn + 1}: {reached[0]:.0%} from the back, {reached[1]:.0%} from the front", flush=True
        )
        if not taken:
            break
        kept, best = [*kept, *taken], np.maximum(best, reached)
    return _joined(kept)


def _steps(batch: TaskVectorEnv) -> int:
    assert batch.max_episode_steps is not None
    return batch.max_episode_steps


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m gsenv.envs.rises", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--out", type=Path, default=Path("assets") / FILE, help="(default: %(default)s)")
    parser.add_argument("--starts", type=int, default=STARTS, help="of the trained policies (default: %(default)s)")
    given = parser.parse_args(arguments)
    arrays = {}
    for figure in FIGURES:
        motion = select(figure, record(figure, given.starts))
        arrays[f"{figure.id} seen"] = motion.seen.astype(np.float16)
        arrays[f"{figure.id} actions"] = motion.actions.astype(np.float16)
    write_arrays(given.out, arrays)
    return 0


if __name__ == "__main__":
    sys.exit(main())
