"""What the driver hands on live is what its recording gives back, whatever the devices do."""

import time

import numpy as np
import pytest

from omnimate.cli.demo.drive import simulated_robot
from omnimate.cli.robots import truth_of
from omnimate.files.recordings.folder import load_recording
from omnimate.motion.drive import drive
from omnimate.motion.journal import Journal
from omnimate.motion.paths import umbmark
from omnimate.motion.runner import Runner
from omnimate.vcan_sim.faults import parse_fault
from omnimate.vcan_sim.reference import reference_vehicle

FAULTS = [
    "silence:node=2,at=3,duration=1",
    "reboot:node=1,at=4",
    "length:node=4,at=5,duration=0.5",
    "frozen:node=2,at=6,duration=0.4",
    "babbling:node=3,at=6,duration=0.5",
    "jitter:node=5,at=7,duration=1",
]


@pytest.mark.parametrize("faults", [[], *[[fault] for fault in FAULTS], FAULTS], ids=str)
def test_live_samples_equal_the_recording(tmp_path, faults):
    vehicle = reference_vehicle()
    program = umbmark(0.5, 1, speed=0.4, link_length=1.0)
    samples = []
    parsed = [parse_fault(text) for text in faults]
    truth = truth_of(vehicle, None, (), 1)
    with simulated_robot(vehicle, truth, tmp_path / "r", program, parsed) as (driver, _, _):
        driver.configure()
        driver.enable()
        runner = Runner(program, vehicle)
        for moment in drive(driver, runner, vehicle, Journal(program)):
            samples.append(moment.sample)
            if len(samples) == 700:
                break
    recording = load_recording(tmp_path / "r")
    assert len(recording) == 700
    assert np.array_equal([sample.present for sample in samples], recording.present)
    believed = recording.present
    live = np.array([sample.counts for sample in samples])
    assert np.array_equal(live[believed], recording.counts[believed])
    assert np.allclose([sample.time for sample in samples], recording.time, atol=2e-6)


@pytest.fixture
def busy_host(monkeypatch):
    """A host whose time jumps by up to 40 ms whenever somebody looks at it, as under a heavy load."""
    chance = np.random.default_rng(1)
    passed = [1000.0]

    def monotonic():
        passed[0] += 0.04 * float(chance.random()) ** 8
        return passed[0]

    monkeypatch.setattr(time, "monotonic", monotonic)
    monkeypatch.setattr(time, "sleep", lambda seconds: passed.__setitem__(0, passed[0] + seconds))


@pytest.mark.usefixtures("busy_host")
def test_a_busy_host_changes_neither(tmp_path):
    test_live_samples_equal_the_recording(tmp_path, FAULTS)
