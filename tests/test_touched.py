"""CI runs the slow tests and the mutants of what a change touches: code, and not what explains it."""

import subprocess
import sys

import pytest

from tests.conftest import ROOT

sys.path.append(str(ROOT / ".ci"))
from touched import touched_files

BEFORE = '"""A module."""\n\n\ndef double(x):\n    """Return twice x."""\n    return 2 * x\n'
EXPLAINED = BEFORE.replace("Return twice x.", "Return the double.").replace("2 * x", "2 * x  # exactly")


@pytest.mark.parametrize(
    ("name", "after", "is_touched"),
    [
        pytest.param("a.py", EXPLAINED, False, id="docstrings and comments"),
        pytest.param("a.py", BEFORE.replace("2", "3"), True, id="code"),
        pytest.param("b.py", BEFORE, True, id="a new file"),
        pytest.param("page.md", "other words", True, id="a page"),
    ],
)
def test_a_file_is_touched_where_more_than_docstrings_and_comments_differ(tmp_path, name, after, is_touched):
    git = ["git", "-c", "user.name=x", "-c", "user.email=x@x", "-c", "init.defaultBranch=main"]
    (tmp_path / "a.py").write_text(BEFORE)
    (tmp_path / "page.md").write_text("words")
    for arguments in (["init"], ["add", "."], ["commit", "-m", "x"]):
        subprocess.run([*git, *arguments], cwd=tmp_path, check=True, capture_output=True)
    (tmp_path / name).write_text(after)
    subprocess.run(["git", "add", "."], cwd=tmp_path, check=True)
    assert touched_files(tmp_path, "HEAD") == ({name} if is_touched else set())
