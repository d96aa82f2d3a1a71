"""Running a command in this process."""

import math
import os
import sys
from typing import NamedTuple

from omnimate.cli import console

console.PROGRESS_PERIOD = math.inf  # on a slow machine more commands would say how far they are


class Result(NamedTuple):
    code: int
    out: str
    err: str


def runner(name, main, capsys, monkeypatch):
    """Return a function that runs a command with arguments and gives its exit code and output."""
    monkeypatch.setitem(os.environ, "COLUMNS", "200")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
        try:
            main()
            code = 0
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
        return Result(code, *capsys.readouterr())

    return run
