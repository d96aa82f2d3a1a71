"""The command itself: help is there at once."""

import subprocess
import sys

import pytest

SLOW = ("numba", "scipy", "matplotlib", "canopen", "can", "cantools", "mujoco")


def test_help_imports_nothing_that_takes_time():
    """What a verb needs is imported when it runs."""
    code = f"import sys, cli.main; print(*[name for name in {SLOW} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


@pytest.mark.parametrize("verb", ["umbmark", "calibrate", "drift", "profile", "record", "track"])
def test_every_verb_has_a_line_of_help(omnimate, verb):
    listed = omnimate("--help")
    assert listed.code == 0
    line = next(line for line in listed.out.splitlines() if f" {verb} " in line)
    assert len(line.split()) > 5
