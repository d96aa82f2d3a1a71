"""Late answers, alone and in bursts, of devices on a bus: none enters a sample as current."""

from __future__ import annotations

import numpy as np
import pytest

from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.odometry import Odometer, dead_reckon
from tests.foreign.robots import cycles, rolling, two_trucks


def hold_back(bus, node, syncs, release):
    """Have a node's next answers come in one burst, `release` seconds after the last of their SYNCs."""
    device, held = bus.nodes[node], []
    send = device.send

    def hold(can_id, data):
        if can_id == 0x180 + node and len(held) < syncs:
            held.append(data)
            if len(held) == syncs:
                bus.at(release, burst)
        elif held and can_id == 0x180 + node:
            held.append(data)
        else:
            send(can_id, data)

    def burst():
        device.send = send
        for data in held:
            send(0x180 + node, data)

    device.send = hold


@pytest.mark.usefixtures("family")
@pytest.mark.parametrize("release", [0.0, 0.001, 0.004, 0.008, 0.013, 0.0149, 0.016, 0.02])
@pytest.mark.parametrize("syncs", [1, 2, 21])
def test_late_answers_in_a_burst_turn_no_heading(begun, tmp_path, syncs, release):
    recorder = Recorder(tmp_path / "lap", two_trucks())
    driver, bus = begun(recorder=recorder)
    rolling(bus)
    driver.configure()
    samples = cycles(driver, 0.3)
    hold_back(bus, 1, syncs, release)
    samples += cycles(driver, 1.0)
    recorder.close()
    odometer = Odometer(two_trucks(), "a")
    headings = [odometer.step(sample)[2] for sample in samples]
    step = 0.3 * 0.015 / 0.34  # [rad], where one wheel is one SYNC behind
    assert max(map(abs, headings)) < 0.3 * step
    assert all(samples[-1].present)
    assert driver.report().node(1).late + driver.report().node(1).missing >= syncs - 1

    recording = load_recording(tmp_path / "lap")
    for row, sample in enumerate(samples):  # a sample that was closed before the burst has less than the log
        both = recording.present[row] & sample.present
        assert (recording.counts[row][both] == np.array(sample.counts)[both]).all()
    travel = dead_reckon(recording, "a")
    assert np.abs(travel[:, 2]).max() < 0.3 * step


@pytest.mark.usefixtures("family")
def test_no_answer_is_late_after_a_silence_of_all_nodes_and_the_recording_gives_the_same(begun, tmp_path):
    """As where the cable to all encoders has a loose contact for 0.2 s."""
    recorder = Recorder(tmp_path / "lap", two_trucks())
    driver, bus = begun(recorder=recorder)
    rolling(bus)
    driver.configure()
    samples = cycles(driver, 0.3)
    encoders = [bus.nodes[node] for node in range(1, 8)]
    sends = [encoder.send for encoder in encoders]
    for encoder in encoders:
        encoder.send = lambda _can_id, _data: None
    samples += cycles(driver, 0.2)
    for encoder, send in zip(encoders, sends, strict=True):
        encoder.send = send
    samples += cycles(driver, 0.3)
    recorder.close()
    assert [node.late for node in driver.report().nodes] == [0] * len(driver.report().nodes)
    recording = load_recording(tmp_path / "lap")
    assert recording.present.tolist() == [list(sample.present) for sample in samples]
    assert recording.counts.tolist() == [list(sample.counts) for sample in samples]
