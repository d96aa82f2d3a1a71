"""A simulated robot that drives by itself over its own plant."""

import numpy as np
import pytest

from omnimate.motion.paths import squares
from omnimate.vcan_sim.floor import SMOOTH
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.self_driving import SelfDriving
from omnimate.vcan_sim.simulate import simulate
from omnimate.vcan_sim.truth import Truth, uncalibrated

VEHICLE = reference_single()
PERIOD = VEHICLE.bus.sync_period
PROGRAM = squares(["cw", "ccw"], 0.5)


@pytest.fixture(scope="module")
def truth():
    return Truth(uncalibrated(VEHICLE), floor=SMOOTH, seed=4)


@pytest.fixture(scope="module")
def driven(truth):
    """A robot that has driven the program and stood for a while; its driver, plant, and number of fixes."""
    plant, fixes, steps = Plant(truth, VEHICLE), [], 0
    driver = SelfDriving(
        VEHICLE, plant, PROGRAM, lambda: steps * PERIOD, lambda journal: fixes.append(len(journal.poses.time))
    )
    speeds = [()]
    while steps < 20_000 and not (steps > 100 and driver.runner.done):
        speeds.append(tuple(driver(None)))
        plant.step(speeds[-1], PERIOD)
        steps += 1
    return driver, plant, fixes


def test_it_drives_what_a_simulation_without_a_bus_drives(driven, truth):
    driver, _, _ = driven
    recording = simulate(VEHICLE, truth, PROGRAM)
    assert [lap.direction for lap in driver.journal.run.laps] == [lap.direction for lap in recording.run.laps]
    assert driver.journal.poses.pose == pytest.approx(recording.poses.pose, abs=1e-9)


def test_it_reports_every_fix_as_it_is_taken(driven):
    driver, _, fixes = driven
    assert fixes == list(range(1, len(driver.journal.poses.time) + 1))


def test_it_stands_after_the_program(driven):
    driver, plant, _ = driven
    before = plant.pose("a")
    for _ in range(5):
        plant.step(driver(None), PERIOD)
    assert np.array_equal(plant.pose("a"), before)
