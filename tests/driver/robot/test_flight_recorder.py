"""The flight recorder: after a fault, a recording folder holds the minute before and some seconds after."""

import errno
import json
import threading
from contextlib import contextmanager
from dataclasses import replace
from datetime import datetime

import pytest

from omnimate.driver.bus.clock import SyncClock
from omnimate.driver.errors import BusLost, DrivesStopped
from omnimate.driver.robot import flight_recorder
from omnimate.driver.robot.driver import Driver
from omnimate.driver.robot.recorder import Recorder
from omnimate.files.logs.blocks import read_log
from omnimate.files.recordings.events_jsonl import EVENTS, read_events
from omnimate.files.recordings.folder import load_recording
from omnimate.vcan_sim.coupled_bus import CoupledBus
from omnimate.vcan_sim.faults import parse_fault
from omnimate.vcan_sim.plant import Plant
from omnimate.vcan_sim.reference import reference_single
from omnimate.vcan_sim.truth import Truth
from omnimate.vehicle.file import load_vehicle

START, PERIOD = 1_700_000_000.0, 0.05


@contextmanager
def flying(folder, *faults, recorder=None, start=START):
    """Yield a driver with enabled drives on a simulated robot, and the flight recorder in a folder."""
    nominal = reference_single()
    vehicle = replace(nominal, bus=replace(nominal.bus, sync_period=PERIOD))
    with (
        CoupledBus(vehicle, Plant(Truth(vehicle), vehicle), [parse_fault(fault) for fault in faults]) as bus,
        Driver(
            vehicle, bus, clock=SyncClock(PERIOD, start), recorder=recorder, flight_recorder=folder
        ) as driver,
    ):
        driver.configure()
        driver.enable()
        yield driver


def fly(driver, seconds, speed=2.0):
    """Return the samples of a drive that goes on after its wheels were stopped."""
    samples = []
    for _ in range(round(seconds / PERIOD)):
        if not driver.drives.troubles:
            driver.command([speed] * 2)
        samples.append(driver.cycle())
    return samples


def times(folder):
    """Return the times in the names of the folders [s] from the start."""
    names = [path.name for path in folders(folder)]
    return [datetime.strptime(name, "flight-%Y%m%dT%H%M%S.%f%z").timestamp() - START for name in names]


def folders(folder):
    return sorted(folder.iterdir()) if folder.exists() else []


def whats(path, kind):
    return [event.what for event in read_events(path / EVENTS) if event.kind == kind]


def test_a_drive_without_a_fault_leaves_no_folder(tmp_path):
    with flying(tmp_path / "flights") as driver:
        fly(driver, 10.0)
        driver.stop()
        fly(driver, 1.0, speed=0.0)
    assert folders(tmp_path / "flights") == []


class FullDisk:
    """A recorder whose disk is full."""

    def use(self, vehicle):
        """Take the vehicle."""

    def frame(self, at, message):
        raise OSError(errno.ENOSPC, "No space left on device")


def test_a_full_disk_of_the_recording_costs_the_flight_recorder_no_frame(tmp_path):
    with flying(tmp_path, recorder=FullDisk()) as driver:
        fly(driver, 12.0)
    path = folders(tmp_path)[0]
    faults = whats(path, "fault")
    assert "No space left on device" in faults[0]
    assert len(faults) < 20  # not one for each frame
    syncs = [frame.time for frame in read_log(path / "can.log").frames if frame.can_id == 0x080]
    assert len(syncs) == round((syncs[-1] - syncs[0]) / PERIOD) + 1 > 90


def test_a_folder_holds_the_minute_before_the_fault_and_the_seconds_after_as_they_were_sampled(tmp_path):
    with flying(tmp_path, "emcy:node=11,at=70.02") as driver:
        samples = fly(driver, 90.0)
    (path,) = folders(tmp_path)
    assert path.name == "flight-20231114T221430.000Z"
    recording = load_recording(path)
    by_time = {round(sample.time, 6): list(sample.counts) for sample in samples}
    assert recording.time[0] - START == pytest.approx(10.0, abs=2 * PERIOD)
    assert recording.time[-1] - START == pytest.approx(75.0, abs=2 * PERIOD)
    assert [by_time[round(time, 6)] for time in recording.time.tolist()] == recording.counts.tolist()
    assert whats(path, "fault") == ["all wheels stopped; enable() is needed"]
    assert "EMCY 5000h: device hardware (error register 01h)" in whats(path, "event")


def test_commands_are_recorded_where_they_change(tmp_path):
    with flying(tmp_path, "emcy:node=11,at=2") as driver:
        fly(driver, 1.0, speed=1.5)
        fly(driver, 2.0, speed=2.5)
    words = [f"commanded a.left {speed}, a.right {speed} rad/s" for speed in ("1.500", "2.500", "0.000")]
    assert whats(folders(tmp_path)[0], "command") == words


def test_a_lost_node_is_a_fault(tmp_path):
    with flying(tmp_path, "silence:node=1,at=2") as driver:
        fly(driver, 3.5)
    (path,) = folders(tmp_path)
    assert "heartbeat lost: none for" in whats(path, "fault")[0]


def test_the_faults_that_follow_within_seconds_are_in_the_folder_of_the_first(tmp_path):
    with flying(tmp_path, "reboot:node=2,at=2", "emcy:node=11,at=4") as driver:
        fly(driver, 10.0)
    (path,) = folders(tmp_path)
    assert times(tmp_path) == pytest.approx([2.3], abs=2 * PERIOD)
    assert whats(path, "fault") == ["restarted (boot-up)", "all wheels stopped; enable() is needed"]


def test_wheels_that_are_stopped_without_a_command_are_a_fault(tmp_path):
    with flying(tmp_path) as driver:
        fly(driver, 1.0)
        for _ in range(10):
            driver.cycle()
    assert whats(folders(tmp_path)[0], "fault") == ["no command for 0.2 s: wheels stopped"]


def test_an_error_that_leaves_cycle_is_a_fault_whose_folder_is_written_by_close(kit, tmp_path):
    driver, bus = kit.driver_and_bus(flight_recorder=tmp_path)
    with driver:
        driver.configure()
        for _ in range(20):
            driver.cycle()
        bus.is_dead = True
        with pytest.raises(BusLost):
            driver.cycle()
        assert folders(tmp_path) == []
    (path,) = folders(tmp_path)
    assert len(load_recording(path)) == 20
    lost, ended = whats(path, "fault")
    assert "interface is down" in lost
    assert ended.startswith("the driver cannot go on: ")


def test_a_defect_of_the_program_that_leaves_cycle_is_a_fault_too(kit, tmp_path, monkeypatch):
    with kit.driver_and_bus(flight_recorder=tmp_path)[0] as driver:
        driver.configure()
        driver.cycle()
        monkeypatch.setattr(driver, "_check_wheels", lambda _sample: 1 // 0)
        with pytest.raises(ZeroDivisionError):
            driver.cycle()
    assert whats(folders(tmp_path)[0], "fault") == [
        "the driver cannot go on: integer division or modulo by zero"
    ]


def test_a_second_fault_within_a_minute_waits_and_nothing_in_between_is_missing(tmp_path):
    with flying(tmp_path, "reboot:node=2,at=20", "reboot:node=1,at=40") as driver:
        fly(driver, 90.0)
    first, second = map(load_recording, folders(tmp_path))
    assert second.time[-1] - first.time[-1] == pytest.approx(60.0, abs=2 * PERIOD)
    assert times(tmp_path) == pytest.approx([20.3, 40.3], abs=0.2)
    assert second.time[0] - first.time[-1] == pytest.approx(PERIOD)


def test_of_many_folders_the_oldest_ones_are_removed_and_nothing_else(tmp_path, monkeypatch):
    monkeypatch.setattr(flight_recorder, "MAX_FOLDERS", 2)
    (tmp_path / "flight-manual").mkdir()
    for number in range(4):
        with flying(tmp_path, "emcy:node=11,at=1.02", start=START + 100.0 * number) as driver:
            fly(driver, 2.0)
    (tmp_path / "flight-manual").rmdir()
    assert times(tmp_path) == pytest.approx([201.0, 301.0])


def test_a_robot_that_fails_whenever_it_is_opened_keeps_its_first_fault_and_has_one_folder_a_minute(tmp_path):
    for number in range(14):
        with flying(tmp_path, "emcy:node=11,at=1.02", start=START + 10.0 * number) as driver:
            fly(driver, 2.0 if number % 2 else 7.0)
    assert times(tmp_path) == pytest.approx([1.0, 61.0, 121.0])


def test_a_folder_from_a_clock_that_was_ahead_hinders_no_other(tmp_path):
    for start in (START + 1e6, START):
        with flying(tmp_path, "emcy:node=11,at=1.02", start=start) as driver:
            fly(driver, 2.0)
    assert times(tmp_path) == pytest.approx([1.0, 1e6 + 1.0])


def test_a_full_disk_is_an_event_and_leaves_no_part_of_a_folder(tmp_path, monkeypatch):
    def full(_path, _packed):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(flight_recorder, "_write_log", full)
    with flying(tmp_path / "flights", "emcy:node=11,at=1") as driver:
        fly(driver, 2.0)
    assert folders(tmp_path / "flights") == []
    assert "No space left on device" in driver.report().events[-1].what


def test_sync_goes_on_while_a_folder_is_written_and_the_end_waits_for_it(tmp_path, monkeypatch):
    released, written = threading.Event(), []
    write_log = flight_recorder._write_log

    def slow_disk(path, packed):
        assert released.wait(60.0)
        written.append(len(packed))
        write_log(path, packed)

    monkeypatch.setattr(flight_recorder, "_write_log", slow_disk)
    with flying(tmp_path, "emcy:node=11,at=1") as driver:
        samples = fly(driver, 20.0)
        assert not written
        released.set()
    assert len(samples) == 400
    recording = load_recording(folders(tmp_path)[0])
    assert recording.time[-1] - START == pytest.approx(1.0 + flight_recorder.AFTER, abs=2 * PERIOD)


def test_memory_is_bounded_in_frames_and_events_and_the_last_ones_stay(tmp_path, monkeypatch):
    monkeypatch.setattr(flight_recorder, "MAX_FRAMES", 50)
    monkeypatch.setattr(flight_recorder, "MAX_EVENTS", 3)
    with flying(tmp_path, "emcy:node=11,at=2") as driver:
        for step in range(100):
            fly(driver, PERIOD, speed=step / 50.0)
    (path,) = folders(tmp_path)
    assert len(read_log(path / "can.log").frames) == 50
    assert len(read_events(path / EVENTS)) == 3


def test_the_recorder_gets_all_that_it_gets_without_a_flight_recorder(tmp_path):
    for name, flights in (("with", tmp_path / "flights"), ("without", None)):
        with (
            Recorder(tmp_path / name, reference_single()) as recorder,
            flying(flights, "emcy:node=11,at=1", recorder=recorder) as driver,
        ):
            fly(driver, 2.0)
    assert (tmp_path / "with" / "can.log").read_bytes() == (tmp_path / "without" / "can.log").read_bytes()
    (path,) = folders(tmp_path / "flights")
    assert (path / "can.log").read_bytes() == (tmp_path / "with" / "can.log").read_bytes()
    assert load_vehicle(path / "vehicle.toml") == load_vehicle(tmp_path / "with" / "vehicle.toml")


def test_a_stopped_program_finds_the_fault_in_its_folder(tmp_path):
    with flying(tmp_path, "emcy:node=11,at=1") as driver:
        fly(driver, 2.0)
        with pytest.raises(DrivesStopped):
            driver.command([2.0, 2.0])
    lines = (folders(tmp_path)[0] / EVENTS).read_text().splitlines()
    assert {"event", "fault", "command"} == {json.loads(line)["kind"] for line in lines}
