"""Running `python -m studies` in this process."""

import pytest

from omnimate.cli.main import run
from studies.__main__ import app
from tests.commands import runner


@pytest.fixture
def studies(capsys, monkeypatch):
    """Return a function that runs `python -m studies` with arguments and gives its exit code and output."""
    return runner("studies", lambda: run(app), capsys, monkeypatch)
