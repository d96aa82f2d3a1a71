"""NMT stopped, restarts heard and unheard, forged boot-ups: what a node's own objects and PDOs say counts."""

from __future__ import annotations

import can
import pytest

from omnimate.driver.robot import driver as module
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.recordings.folder import load_recording
from omnimate.vehicle.odometry import Odometer
from tests.driver.conftest import words
from tests.foreign.devices import OPERATIONAL, STOPPED
from tests.foreign.robots import cycles, devices, rolling, two_trucks

NODE = 1  # the encoder of a.left


@pytest.mark.usefixtures("family")
def test_a_node_in_nmt_stopped_is_brought_back_at_the_start(begun):
    driver, bus = begun()
    bus.nodes[NODE].state = STOPPED
    bus.nodes[17].state = STOPPED
    report = driver.configure()
    assert "set pre-operational" in report.nodes[0].woken
    assert any("did not answer SDO" in line for node in report.nodes for _, line in node.lines())
    driver.enable()
    assert all(cycles(driver, 0.1)[-1].present)
    assert bus.nodes[17].state == OPERATIONAL


@pytest.mark.usefixtures("family")
@pytest.mark.parametrize("has_heartbeat", [True, False])
def test_a_node_that_is_stopped_on_the_way_is_brought_back(begun, has_heartbeat):
    driver, bus = begun()
    if not has_heartbeat:
        bus.nodes[NODE].protect(0x1017)
    driver.configure()
    cycles(driver, 0.1)
    bus.nodes[NODE].state = STOPPED
    cycles(driver, 4.0)
    assert all(cycles(driver, 0.1)[-1].present)
    assert any(node == NODE and "set pre-operational" in what for node, what in words(driver))


def test_a_node_that_only_a_reset_of_its_communication_brings_back(begun):
    driver, bus = begun()
    node = bus.nodes[NODE]
    node.state = STOPPED
    listen = node._on_nmt
    node.network.unsubscribe(0, listen)
    node.network.subscribe(0, lambda *frame: listen(*frame) if frame[1][0] != 0x80 else None)
    report = driver.configure()
    assert "its communication reset" in report.nodes[0].woken


def lose_bus(bus, monkeypatch, away, happen):
    """Let the interface fail once, and be back after a time in which something happens."""
    receive, opened = bus.recv, []

    def fail(_timeout=None):
        bus.recv = receive
        happen()
        raise can.CanOperationError("no such device")

    def open_again(*_arguments):
        if not opened:
            opened.append(bus)
            bus.sleep(away)
        bus.forget()  # what was on the bus meanwhile was not heard
        return bus

    bus.recv = fail
    monkeypatch.setattr(module, "open_bus", open_again)


def drive_through_a_lost_bus(bench, driver_on, monkeypatch, tmp_path, happen):
    """Return the driver, its samples and its recording around a bus that is away for 3 s while all roll.

    The power came on with the driver: boot-ups are not read when it begins.
    """
    bus = bench(devices())
    for node in bus.nodes.values():
        node.reset()
    rolling(bus)
    monkeypatch.setattr(module, "open_bus", lambda *_arguments: bus)
    monkeypatch.setattr(bus, "shutdown", lambda: None)
    recorder = Recorder(tmp_path / "lap", two_trucks())
    driver = driver_on(two_trucks(), "virtual://robot", recorder=recorder)
    driver.configure()
    samples = cycles(driver, 1.0)
    lose_bus(bus, monkeypatch, 3.0, lambda: happen(bus))
    samples += cycles(driver, 3.0)
    recorder.close()
    return driver, samples, load_recording(tmp_path / "lap")


def travel(samples):
    odometer = Odometer(two_trucks(), "a")
    for sample in samples:
        x, _, heading = odometer.step(sample)
    return x, heading


@pytest.mark.usefixtures("family")
@pytest.mark.parametrize("restarted", [(), (1,), (1, 2)])
def test_counters_that_restarted_while_the_bus_was_away_are_rebaselined_and_told(
    bench, driver_on, monkeypatch, tmp_path, restarted
):
    def happen(bus):
        for node in restarted:
            bus.at(1.0, bus.nodes[node].reset)

    driver, samples, recording = drive_through_a_lost_bus(bench, driver_on, monkeypatch, tmp_path, happen)
    assert all(samples[-1].present)
    told = {node for node, what in words(driver) if what and "restarted unheard" in what}
    assert told == set(restarted)
    x, heading = travel(samples)
    passed = samples[-1].time - samples[0].time
    if len(restarted) == 2:  # nothing tells what both wheels rolled while the bus was away
        assert 0.3 * (passed - 4.5) < x < 0.3 * passed
    else:
        assert x == pytest.approx(0.3 * passed, abs=0.05)
    assert heading == pytest.approx(0.0, abs=0.02)
    assert recording.counts.tolist() == [list(sample.counts) for sample in samples]
    assert recording.present.tolist() == [list(sample.present) for sample in samples]


@pytest.mark.usefixtures("family")
@pytest.mark.parametrize("forged", [b"\x00", b"\x7f", b"\x04", b"\x05", b"\x00\x00"])
def test_forged_heartbeats_and_boot_ups_change_no_sample_and_no_baseline(begun, forged):
    def run(frames):
        driver, bus = begun()
        rolling(bus)
        driver.configure()
        for number in range(frames):
            bus.at(0.5 + 0.1003 * number, lambda: bus.inject(0x701, forged))
        samples = cycles(driver, 2.0)
        return driver, [(sample.counts, sample.present) for sample in samples]

    _, untouched = run(0)
    driver, samples = run(10)
    assert samples == untouched
    assert driver.report().gaps == ()
    if forged == b"\x00":
        assert any("not believed" in what for _, what in words(driver))


@pytest.mark.usefixtures("family")
def test_a_real_restart_is_believed_and_the_wheel_goes_on(begun):
    driver, bus = begun()
    rolling(bus)
    driver.configure()
    samples = cycles(driver, 1.0)
    bus.nodes[NODE].reset()
    samples += cycles(driver, 1.0)
    assert samples[-1].present[0]
    x, heading = travel(samples)
    assert x == pytest.approx(0.3 * 2.0, abs=0.02)
    assert heading == pytest.approx(0.0, abs=0.02)
    assert [(gap.channel, gap.reason) for gap in driver.report().gaps] == [("a.left", "reboot")]
