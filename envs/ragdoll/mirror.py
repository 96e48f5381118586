"""The mirror image of an observation and of an action of GRagdoll: left and right swapped."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gsenv.envs.core.spec_tables import Entry
from gsenv.envs.ragdoll.env import RagdollTask

Mirror = tuple[NDArray[np.int64], NDArray[np.float32]]  # mirrored[..., k] = sign[k] * vector[..., index[k]]

_SIDEWAYS = ("down_y", "vy", "wx", "wz", "mass_y", "capture_y", "push_y", "rest_y")
_TRUNK = ("waist_turn", "waist_side")  # joints of legs and arms have mirrored axes


def mirror_of(entries: Sequence[Entry]) -> Mirror:
    """Return where the entries of the mirror image come from, and with which signs."""
    names = [entry.name for entry in entries]
    index = [names.index(_other_side(name)) for name in names]
    sign = [-1.0 if _changes_sign(name) else 1.0 for name in names]
    return np.array(index), np.array(sign, np.float32)


def _other_side(name: str) -> str:
    words = name.split("_")
    swapped = {"left": "right", "right": "left"}
    return "_".join(swapped.get(word, word) for word in words)


def _changes_sign(name: str) -> bool:
    limb = name.endswith(("foot_y", "hand_y"))
    trunk = any(name in (joint, f"{joint}_angle", f"{joint}_rate", f"last_{joint}") for joint in _TRUNK)
    return limb or trunk or name in _SIDEWAYS


OBSERVATION: Mirror = mirror_of(RagdollTask.observations)
PRIVILEGED: Mirror = mirror_of((*RagdollTask.observations, *RagdollTask.privileged))  # of a critic that sees both
ACTION: Mirror = mirror_of(RagdollTask.actions)
