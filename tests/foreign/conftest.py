"""A driver on a bench of foreign devices."""

from __future__ import annotations

import time

import pytest

from omnimate.driver.driver import Driver
from tests.foreign.bench import Bench, BenchClock


@pytest.fixture
def bench(monkeypatch):
    """Return what puts devices on a bench, whose time the driver then has."""
    made = []

    def make(nodes):
        made.append(Bench(nodes))
        monkeypatch.setattr(time, "monotonic", made[-1].monotonic)
        monkeypatch.setattr(time, "sleep", made[-1].sleep)
        return made[-1]

    yield make
    for one in made:
        one.shutdown()


@pytest.fixture
def driver_on():
    """Return what makes a driver on a bench."""

    def make(vehicle, bus, **options):
        return Driver(vehicle, bus, clock=BenchClock(vehicle.bus.sync_period), **options)

    return make
