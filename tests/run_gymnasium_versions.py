"""Tests of the environments with several versions of gymnasium, each in a virtual environment of its own.

    python tests/run_gymnasium_versions.py [VERSION ...] [--keep FOLDER] [-- pytest arguments]

Versions are pip's ("1.1.*", "1.2.*", "newest"). Everything else is what constraints.txt says. Compiled kernels are
shared by all runs. Exit code 0 where all pass.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import venv
from collections.abc import Sequence
from pathlib import Path

ROOT = Path(__file__).parent.parent
VERSIONS = ("1.1.*", "1.2.*", "newest")
FOLDERS = ("tests/envs", "tests/adapters", "tests/test_imports.py")


def run(version: str, folder: Path, pytest_arguments: Sequence[str]) -> int:
    """The exit code of pytest under one version."""
    home = folder / f"gymnasium-{version.rstrip('.*')}"
    python = home / "bin" / "python"
    if not python.exists():
        venv.create(home, with_pip=True)
    pins = [line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.startswith("gymnasium==")]
    constraints = home / "constraints.txt"
    constraints.write_text("\n".join(pins))
    wanted = "gymnasium" if version == "newest" else f"gymnasium=={version}"
    pip: list[str | Path] = [python, "-m", "pip", "install", "--quiet", "--upgrade"]
    install: list[str | Path] = [*pip, "-c", constraints, wanted, "-e", f"{ROOT}[test]"]
    subprocess.run(install, check=True)
    shown: list[str | Path] = [python, "-c", "import gymnasium; print(gymnasium.__version__)"]
    found = subprocess.run(shown, check=True, capture_output=True, text=True).stdout.strip()
    print(f"\n== gymnasium {found} ==", flush=True)
    command: list[str | Path] = [python, "-m", "pytest", "-q", *(pytest_arguments or FOLDERS)]
    return subprocess.run(command, cwd=ROOT).returncode


def main() -> int:
    given = sys.argv[1:]
    ours, pytest_arguments = given, []
    if "--" in given:
        cut = given.index("--")
        ours, pytest_arguments = given[:cut], given[cut + 1 :]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("versions", nargs="*", default=VERSIONS, metavar="VERSION")
    parser.add_argument("--keep", type=Path, help="folder for the virtual environments, to use them again")
    arguments = parser.parse_args(ours)
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    with tempfile.TemporaryDirectory() as scratch:
        folder = (arguments.keep or Path(scratch)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        codes = {version: run(version, folder, pytest_arguments) for version in arguments.versions}
    for version, code in codes.items():
        print(f"gymnasium {version}: {'passed' if code == 0 else f'FAILED ({code})'}")
    return int(any(codes.values()))


if __name__ == "__main__":
    sys.exit(main())
