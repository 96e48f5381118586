"""Environments in child processes of a parent that has stepped on several threads."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[3]


USUAL = {"gymnasium": "fork", "sb3": "forkserver", "pool": "spawn"}  # the other pairs: nightly


def pairs() -> list[Any]:
    """Return each library with each way to start a process that this machine has."""
    methods = multiprocessing.get_all_start_methods()
    out = []
    for library, usual in USUAL.items():
        usual = usual if usual in methods else methods[0]
        out += [
            pytest.param(library, method, marks=() if method == usual else pytest.mark.slow, id=f"{library}-{method}")
            for method in methods
        ]
    return out


@pytest.mark.parametrize(("library", "method"), pairs())
def test_children_do_the_same(library: str, method: str) -> None:
    if library == "sb3":
        pytest.importorskip("stable_baselines3")  # of the extra "train"
    command = [sys.executable, "-m", "tests.envs.core.process_checks", library, method]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.strip() == "same"
    assert "Traceback" not in result.stderr
