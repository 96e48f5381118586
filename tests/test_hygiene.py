"""Every test can fail: it asserts something itself, or calls a function of the tests that does."""

from __future__ import annotations

import ast
import functools
from pathlib import Path

TESTS = Path(__file__).parent
CHECKS = {"pytest.raises", "pytest.warns", "pytest.fail", "check_env"}  # check_env: of gymnasium and Stable-Baselines3
SUITES = ("zoo.", "checker.")  # modules of PettingZoo and Stable-Baselines3 that check an environment


@functools.cache
def calls(node: ast.AST) -> set[str]:
    """Return the functions that are called in a node, as ``name`` or ``module.name``."""
    return {ast.unparse(part.func) for part in ast.walk(node) if isinstance(part, ast.Call)}


def asserts(node: ast.AST, helpers: set[str]) -> bool:
    """Whether code has an assertion or calls one of the helpers, which have one."""
    names = calls(node)
    return (
        any(isinstance(part, ast.Assert) for part in ast.walk(node))
        or any(name.rpartition(".")[2].startswith("assert_") or name.startswith(SUITES) for name in names)
        or bool(names & (CHECKS | helpers))
    )


def test_every_test_asserts_something() -> None:
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for path in sorted(TESTS.rglob("*.py"))}
    functions = [node for tree in trees.values() for node in tree.body if isinstance(node, ast.FunctionDef)]
    helpers: set[str] = set()
    while more := {node.name for node in functions if asserts(node, helpers)} - helpers:
        helpers |= more
    tests = [
        (path, node)
        for path, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    ]
    assert len(tests) > 500
    empty = [f"{path.relative_to(TESTS)}: {node.name}" for path, node in tests if not asserts(node, helpers)]
    assert not empty
