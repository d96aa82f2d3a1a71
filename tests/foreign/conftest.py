"""A driver on a bench of foreign devices, of `canopen` or of CANopenNode."""

from __future__ import annotations

import time

import pytest

from omnimate.driver.robot.driver import Driver
from tests.foreign import robots
from tests.foreign.bench import Bench, BenchClock
from tests.foreign.canopennode import nodes

MISSING = nodes.what_is_missing()
FAMILIES = [
    "LocalNode",
    pytest.param("CANopenNode", marks=pytest.mark.skipif(bool(MISSING), reason=MISSING)),
]


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


@pytest.fixture(scope="session")
def canopennode(tmp_path_factory):
    """Return the compiled devices on CANopenNode."""
    return nodes.build(tmp_path_factory.mktemp("canopennode"))


@pytest.fixture(params=FAMILIES)
def family(request, monkeypatch):
    """Have `robots.devices` make devices of each family in turn; return its name."""
    if request.param == "CANopenNode":
        library = request.getfixturevalue("canopennode")
        monkeypatch.setattr(robots, "FAMILY", nodes.family(library))
    return request.param
