"""A driver on a bench of foreign devices, of `canopen` or of CANopenNode."""

from __future__ import annotations

import time

import pytest

from omnimate.driver.robot import driver as driver_module
from omnimate.driver.robot import passive
from omnimate.driver.robot.driver import Driver
from omnimate.vehicle.file import save_vehicle
from tests.cli.conftest import omnimate
from tests.foreign import robots
from tests.foreign.bench import Bench, BenchClock
from tests.foreign.canopennode import nodes

__all__ = ["omnimate"]
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


@pytest.fixture
def begun(bench, driver_on):
    """Return what makes a driver of `two_trucks`, or of another robot, not configured yet, and its bus."""

    def make(nodes=None, robot=None, **options):
        bus = bench(robots.devices() if nodes is None else nodes)
        return driver_on(robot or robots.two_trucks(), bus, **options), bus

    return make


@pytest.fixture
def enabled(begun):
    """Return what makes such a driver, enabled, which has driven so long [s], and its bus."""

    def make(nodes=None, seconds=0.0):
        driver, bus = begun(nodes)
        driver.configure()
        driver.enable()
        robots.drive(driver, seconds)
        return driver, bus

    return make


@pytest.fixture
def record(omnimate, monkeypatch, tmp_path):
    """Return what runs `omnimate record` on a bench, which any URL names, into the folder `lap`."""
    save_vehicle(robots.two_trucks(), tmp_path / "vehicle.toml")

    def run(bus, *options):
        for module in (driver_module, passive):
            monkeypatch.setattr(module, "open_bus", lambda *_arguments: bus)
        monkeypatch.setattr(bus, "shutdown", lambda: None)  # the bench is looked at afterwards
        arguments = ("--bus", "virtual://robot", "--vehicle", tmp_path / "vehicle.toml", *options)
        return omnimate("record", tmp_path / "lap", *arguments)

    return run


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
