"""Which files differ from a commit in more than docstrings and comments, which no test can see."""

from __future__ import annotations

import ast
import subprocess
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path


def touched_files(root: Path, commit: str) -> set[str]:
    """Return the names of files of a checkout that differ from a commit, relative to its folder."""
    command = ["git", "diff", "--name-only", "--diff-filter=AM", "--find-renames", commit]
    changes = subprocess.run(command, cwd=root, check=True, capture_output=True, text=True)
    return {name for name in changes.stdout.splitlines() if not _does_the_same(root, commit, name)}


def _does_the_same(root: Path, commit: str, name: str) -> bool:
    if not name.endswith(".py"):
        return False
    before = subprocess.run(
        ["git", "show", f"{commit}:{name}"], cwd=root, check=False, capture_output=True, text=True
    )
    return before.returncode == 0 and _code(before.stdout) == _code((root / name).read_text("utf-8"))


def _code(text: str) -> str:
    """Return the syntax tree of a source without its docstrings, as text."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        is_documented = isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
        if is_documented and ast.get_docstring(node, clean=False) is not None:
            node.body = node.body[1:]
    return ast.dump(tree)
