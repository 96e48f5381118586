"""What the layout of the solver promises: short argument lists, and each rule written once for 2D and 3D."""

from __future__ import annotations

import ast
from difflib import SequenceMatcher
from pathlib import Path

SOLVER = Path(__file__).parents[1] / "gsenv" / "solver"
MOST_ARGUMENTS = 12
MANY_ARGUMENTS = 8  # about so many are enough
KERNELS_WITH_MANY = 1  # at most so many kernels have more
MOST_DOUBLED = 0.10  # share of planar's statements that recur in spatial's file of the same name


def kernel_arguments() -> dict[str, int]:
    """How many arguments each kernel has, by file and name."""
    counts = {}
    for path in sorted(SOLVER.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef) and any("njit" in ast.unparse(d) for d in node.decorator_list):
                counts[f"{path.relative_to(SOLVER).as_posix()}: {node.name}"] = len(node.args.args)
    return counts


def code_lines(path: Path) -> list[str]:
    """Stripped lines of statements, without comments, docstrings, imports and blank lines.

    Decorators and signatures don't count: twins that `by_dimension` chooses between have the same.
    """
    text = path.read_text(encoding="utf-8")
    dropped: set[int] = set()
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            dropped.update(range(node.lineno, (node.end_lineno or node.lineno) + 1))
        if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
            start = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            dropped.update(range(start, node.body[0].lineno))
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node) is not None:
            first = node.body[0]
            dropped.update(range(first.lineno, (first.end_lineno or first.lineno) + 1))
    lines = enumerate((line.strip() for line in text.splitlines()), 1)
    return [line for number, line in lines if line and not line.startswith("#") and number not in dropped]


def doubled_lines() -> dict[str, tuple[int, int]]:
    """(statements that stand in spatial's file in the same order, all) of each of planar's files, in lines."""
    counts = {}
    for path in sorted((SOLVER / "planar").rglob("*.py")):
        name = path.relative_to(SOLVER / "planar")
        other = SOLVER / "spatial" / name
        lines = code_lines(path)
        same = 0
        if other.exists():
            blocks = SequenceMatcher(None, lines, code_lines(other), autojunk=False).get_matching_blocks()
            same = sum(block.size for block in blocks)
        counts[name.as_posix()] = (same, len(lines))
    return counts


def test_kernels_take_few_arguments() -> None:
    counts = kernel_arguments()
    assert len(counts) > 300
    too_many = {name: count for name, count in counts.items() if count > MOST_ARGUMENTS}
    assert not too_many
    many = {name: count for name, count in counts.items() if count > MANY_ARGUMENTS}
    assert len(many) <= KERNELS_WITH_MANY, many


def test_planar_and_spatial_share_what_knows_no_geometry() -> None:
    counts = doubled_lines()
    same = sum(doubled for doubled, _ in counts.values())
    total = sum(lines for _, lines in counts.values())
    print(f"{same} of {total} lines of statements of planar/ recur in spatial/: {same / total:.1%}")
    worst = sorted(counts.items(), key=lambda item: item[1][0], reverse=True)[:8]
    assert total > 1000
    assert same / total < MOST_DOUBLED, worst
