"""Running the `omnimate` command in this process."""

from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from docs.generate.conformance import BenchBus
from omnimate.cli.main import main
from tests.commands import runner


@pytest.fixture
def omnimate(capsys, monkeypatch):
    """Return a function that runs `omnimate` with arguments and gives its exit code and output."""
    return runner("omnimate", main, capsys, monkeypatch)


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
        for module in (
            "canopen.node_access",
            "canopen.sdo",
            "conformance.probe",
            "scan.scan",
            "bus.clock",
        ):
            monkeypatch.setattr(f"omnimate.driver.{module}.time", passed)  # it passes on the bench alone
        return bus

    return use
