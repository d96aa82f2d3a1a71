"""Running the `omnimate` command in this process."""

import os
import sys
from contextlib import contextmanager
from types import SimpleNamespace
from typing import NamedTuple

import pytest

from docs.generate.conformance import BenchBus
from omnimate.cli.main import main


class Result(NamedTuple):
    code: int
    out: str
    err: str


@pytest.fixture
def omnimate(capsys, monkeypatch):
    """Return a function that runs the command with arguments and gives its exit code and output."""
    monkeypatch.setitem(os.environ, "COLUMNS", "200")

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["omnimate", *map(str, arguments)])
        try:
            main()
            code = 0
        except SystemExit as ended:
            code = ended.code if isinstance(ended.code, int) else 1
        return Result(code, *capsys.readouterr())

    return run


@pytest.fixture
def on_bench(monkeypatch):
    """Return a function by which the verbs open a bus with these devices, on which some frames wait."""

    def use(kind, frames=()):
        bus = BenchBus(kind)
        bus._waiting.extend(frames)

        @contextmanager
        def opened(_url):
            yield bus

        monkeypatch.setattr("omnimate.driver.bus.bus.open_bus", opened)
        monkeypatch.setattr("omnimate.driver.canopen.node_access.open_bus", opened)
        passed = SimpleNamespace(monotonic=lambda: bus.time, time=lambda: bus.time)
        for module in ("node_access", "sdo_client", "conformance.probe", "scan.scan", "clock"):
            monkeypatch.setattr(f"omnimate.driver.{module}.time", passed)  # it passes on the bench alone
        return bus

    return use
