"""Environments in child processes of a parent that has stepped on several threads."""

from __future__ import annotations

import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]


@pytest.mark.parametrize("method", multiprocessing.get_all_start_methods())
@pytest.mark.parametrize("library", ["gymnasium", "sb3", "pool"])
def test_children_do_the_same(library: str, method: str) -> None:
    if library == "sb3":
        pytest.importorskip("stable_baselines3")  # of the extra "train"
    command = [sys.executable, "-m", "tests.envs.core.process_checks", library, method]
    result = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.strip() == "same"
    assert "Traceback" not in result.stderr
