from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from gsenv import __version__
from gsenv.train import origin


def test_a_run_that_goes_on_elsewhere_names_both_origins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for commit, cpu in (("abc", "one"), ("abc", "two"), ("def", "one"), ("", "one")):
        monkeypatch.setattr(origin, "commit", lambda commit=commit: commit)
        monkeypatch.setattr(origin, "cpu", lambda cpu=cpu: cpu)
        origin.write_origin(tmp_path)
    written = json.loads((tmp_path / origin.FILE).read_text())
    assert written == {"gsenv": __version__, "commit": "abc, def", "cpu": "one, two"}


def test_the_commit_is_that_of_gsenv_or_unknown(tmp_path: Path) -> None:
    """A package that is installed below another repository has no commit of its own."""
    git = shutil.which("git")
    if git is None:
        pytest.skip("git is not installed")
    subprocess.run([git, "init", "-q", tmp_path], check=True)
    subprocess.run(
        [git, "-C", tmp_path, "-c", "user.name=a", "-c", "user.email=b", "commit", "-q", "--allow-empty", "-m", "c"],
        check=True,
    )
    copy = tmp_path / "copy.py"
    copy.write_text(Path(origin.__file__).read_text())
    code = f"import runpy; print(runpy.run_path({str(copy)!r})['commit']())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "\n"
    assert origin.cpu()
