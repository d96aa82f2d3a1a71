"""A simulated robot that drives by itself over its own plant."""

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


def test_it_drives_what_a_simulation_drives_reports_every_fix_and_stands_at_the_end():
    truth = Truth(uncalibrated(VEHICLE), floor=SMOOTH, seed=4)
    plant, fixes, steps = Plant(truth, VEHICLE), [], 0
    driver = SelfDriving(
        VEHICLE, plant, PROGRAM, lambda: steps * PERIOD, lambda journal: fixes.append(len(journal.poses.time))
    )
    while not driver.runner.done:
        plant.step(driver(), PERIOD)
        steps += 1
    recording = simulate(VEHICLE, truth, PROGRAM)
    assert steps == len(recording)
    assert driver.journal.run == recording.run
    assert driver.journal.poses.pose == pytest.approx(recording.poses.pose, abs=1e-9)
    assert fixes == list(range(1, len(driver.journal.poses.time) + 1))
    assert driver() == (0.0, 0.0)
