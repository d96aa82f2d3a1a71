"""Encoders that send by themselves (transmission types 254 and 255), without SYNC: live as in a recording."""

from __future__ import annotations

import numpy as np
import pytest

from omnimate.driver.errors import NoSync
from omnimate.driver.robot.passive import PassiveReader
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.odometry import Odometer
from tests.foreign import robots
from tests.foreign.devices import OPERATIONAL
from tests.foreign.robots import devices, rolling, two_trucks

pytestmark = pytest.mark.usefixtures("family")


def free_running(bench, kind=254):
    """Return a bus on which encoders send at every change, and roll from 1.5 s on for three seconds."""
    nodes = [robots.FAMILY["encoder"](node.id, kind) if node.id <= 7 else node for node in devices()]
    for node in nodes:
        node.state = OPERATIONAL
    bus = bench(nodes)
    bus.at(1.5, lambda: rolling(bus))
    bus.at(4.5, lambda: rolling(bus, -0.3))  # stands: both speeds add up to nothing
    return bus


def samples_of(bus, folder):
    """Return the live samples of a bus and the report, after a comparison with those of the recording."""
    with Recorder(folder, two_trucks()) as recorder:
        reader = PassiveReader(two_trucks(), bus, recorder=recorder)
        samples = list(reader.samples(idle=1.0, patience=3.0))
    assert bus.sent == []
    recording = load_recording(folder)
    assert recording.counts.tolist() == [list(sample.counts) for sample in samples]
    assert recording.present.tolist() == [list(sample.present) for sample in samples]
    assert recording.time == pytest.approx([sample.time for sample in samples], abs=1e-5)
    return samples, reader.report()


@pytest.mark.parametrize("kind", [254, 255])
def test_encoders_without_sync_give_live_what_their_recording_gives(bench, tmp_path, kind):
    samples, _ = samples_of(free_running(bench, kind), tmp_path / "lap")
    odometer = Odometer(two_trucks(), "a")
    x, _, heading = [odometer.step(sample) for sample in samples][-1]
    assert x == pytest.approx(0.9, abs=0.01)
    assert heading == pytest.approx(0.0, abs=0.01)


def test_where_the_node_that_opens_samples_falls_silent_another_one_does_so_and_the_report_names_it(
    bench, tmp_path
):
    bus = free_running(bench)
    bus.at(3.0, lambda: setattr(bus.nodes[1], "is_powered", False))
    samples, report = samples_of(bus, tmp_path / "lap")
    what = "PDO 181h is silent, or ten times slower than PDO 182h: samples begin with PDO 182h"
    assert (1, what) in [(event.node, event.what) for event in report.events]
    assert report.node(1).missing > 100 > report.node(2).missing
    rolls = [sample.time for sample in samples if sample.present[1]][1:]
    assert rolls[-1] - rolls[0] == pytest.approx(3.0, abs=0.02)
    assert np.diff(rolls).max() < 0.2


def test_sync_that_comes_within_a_second_opens_the_samples(bench):
    bus = free_running(bench)
    for number in range(50):
        bus.at(0.9 + 0.015 * number, lambda: bus.inject(0x080, b""))
    samples = list(PassiveReader(two_trucks(), bus).samples(idle=1.0))
    assert len(samples) == 50


def test_record_listen_only_takes_such_a_bus(bench, record, tmp_path):
    bus = free_running(bench)
    result = record(bus, "--listen-only", "--seconds", "2")
    assert result.code == 0, result.err
    assert load_recording(tmp_path / "lap").counts[-1][0] > 0
    assert bus.sent == []


def test_heartbeats_alone_are_no_source(bench):
    bus = bench(devices())
    bus.nodes[1].put(0x1017, 0, 100)
    with pytest.raises(NoSync):
        list(PassiveReader(two_trucks(), bus).samples(idle=1.0, patience=2.0))
