"""The files of a training run: which a folder has, and checkpoints, whose files are replaced together."""

from __future__ import annotations

import errno
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gsenv.files import replacing_all
from gsenv.train.files import read_object, read_rows, write_rows

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm
    from stable_baselines3.common.vec_env import VecNormalize

NORMALIZE = "normalize.npz"  # in the folder of policy.zip
_LEARNT = ("policy.npz", "best.npz", "policy.zip", NORMALIZE, "progress.csv", "result.json")  # what a run leaves
_NEEDED = ("policy.zip", NORMALIZE)  # to continue it
_FREE = (  # settings that may differ where a run continues: how far it goes and what is written, not how it learns
    "seed",  # told apart by the folder's name
    "steps", "tests", "test_episodes", "watched_episodes", "log_every", "evaluate_every", "torch_threads",
)  # fmt: skip
AS_TRAINED = "as trained"  # in result.json: a test with the arguments of the training
COLUMNS = ("steps", "seconds", "return", "evaluated_return", "evaluated_success")  # of any progress.csv


def check_folder(folder: Path, settings: Mapping[str, Any], resume: bool) -> bool:
    """Return whether a run is to be continued from the files of its folder; changes nothing.

    Raises:
        ValueError: a new run would replace an old one, or the files are not those of a run with these settings.
    """
    found = [name for name in _LEARNT if (folder / name).exists()]
    if not found:
        return False
    if not resume:
        raise ValueError(
            f"{folder} already holds a run ({', '.join(found)}): continue it with --resume, take another --out, or "
            "delete the folder."
        )
    missing = [name for name in _NEEDED if not (folder / name).is_file()]
    if missing:
        raise ValueError(
            f"{folder} has {found[0]} but not {' and '.join(missing)}, from which --resume continues: take another "
            "--out, or delete the folder to begin anew."
        )
    _check_settings(folder / "settings.json", settings)
    if (folder / "progress.csv").is_file():
        read_rows(folder / "progress.csv", COLUMNS)
    return True


def _check_settings(path: Path, settings: Mapping[str, Any]) -> None:
    if not path.is_file():
        return
    for name, before, now in changed_settings(read_object(path), settings):
        raise ValueError(
            f"{path.parent} holds a run with {name} {before}, so --resume cannot continue it with {now}: take another "
            "--out."
        )


def changed_settings(before: Mapping[str, Any], settings: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Return name, old and new value of the settings of learning that are not those of a settings.json."""
    now = json.loads(json.dumps(dict(settings)))  # tuples as the lists of the file
    return [
        (name, before[name], now[name])
        for name in now
        if name not in _FREE and name in before and before[name] != now[name]
    ]


def write_checkpoint(
    folder: Path, model: BaseAlgorithm, normalize: VecNormalize, notes: dict[str, Any], rows: list[dict[str, Any]]
) -> None:
    """Replace the policy in all formats and the progress, once all of it is on the disk.

    A full disk leaves the old checkpoint whole: new statistics beside old weights would be another policy.
    """
    from gsenv.train.export import export, save_normalize, statistics_of

    names = ["policy.npz", NORMALIZE, "policy.zip", *(["progress.csv"] if rows else [])]
    with replacing_all([folder / name for name in names]) as partials:
        export(model, normalize, notes).save(partials[0])
        save_normalize(statistics_of(normalize, int(model.num_timesteps)), partials[1])
        try:
            model.save(partials[2])
        except RuntimeError as error:  # torch's, where it cannot write
            raise OSError(errno.EIO, "cannot be written; is the disk full?", str(folder / "policy.zip")) from error
        except OSError as error:
            if error.errno is None or error.filename is not None:
                raise
            raise OSError(error.errno, error.strerror, str(folder / "policy.zip")) from error
        if rows:
            write_rows(partials[3], rows)
