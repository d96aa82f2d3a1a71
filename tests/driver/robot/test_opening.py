"""A driver that is configured, or no open bus."""

import pytest

from omnimate.driver.errors import BusError
from omnimate.driver.robot import opening


class FakeDriver:
    """Counts how often it is closed; refuses to be configured where it is told so."""

    closed = 0
    problem = None

    def __init__(self, vehicle, bus, *, recorder=None, descriptions=None):
        self.arguments = vehicle, bus, recorder

    def configure(self):
        if self.problem is not None:
            raise self.problem
        return "report"

    def close(self):
        type(self).closed += 1


@pytest.fixture
def driver(monkeypatch):
    class Driver(FakeDriver):
        """One class for each test."""

    monkeypatch.setattr(opening, "Driver", Driver)
    return Driver


def test_it_hands_on_what_configuring_showed_and_leaves_the_bus_open(driver):
    opened, report = opening.open_driver("vehicle", "virtual://x", "recorder")
    assert opened.arguments == ("vehicle", "virtual://x", "recorder")
    assert (report, driver.closed) == ("report", 0)


@pytest.mark.parametrize("problem", [BusError("virtual://x", "no answer"), KeyboardInterrupt()])
def test_whatever_ends_configuring_closes_the_bus(driver, problem):
    driver.problem = problem
    with pytest.raises(type(problem)):
        opening.open_driver("vehicle", "virtual://x")
    assert driver.closed == 1
